//! Scalars of a type, and where they lie in memory.

use std::rc::Rc;

use spirv::Decoration;

use crate::error::{Error, Result};
use crate::module::{Id, Module, Type};
use crate::program::Kind;

/// How a matrix lies in memory: the distance of its columns, or of its rows if `rows`.
#[derive(Clone, Copy, Debug, Default)]
pub struct MatrixLayout {
    pub stride: u32,
    pub rows: bool,
}

impl Module {
    /// Kinds of the scalars of a type, in the order in which they are numbered everywhere.
    pub fn scalars(&self, kind: Id) -> Result<Rc<[Kind]>> {
        let repeated =
            |of: Id, count: u32| -> Result<Rc<[Kind]>> { Ok(self.scalars(of)?.repeat(count as usize).into()) };
        match self.kind(kind)? {
            Type::Void => Ok([].into()),
            Type::Float => Ok([Kind::Float].into()),
            Type::Int => Ok([Kind::Uint].into()),
            Type::Bool => Ok([Kind::Bool].into()),
            Type::Vector(of, count) | Type::Matrix(of, count) | Type::Array(of, count) => repeated(*of, *count),
            Type::Struct(members) => {
                let mut scalars = vec![];
                for member in members.iter() {
                    scalars.extend_from_slice(&self.scalars(*member)?);
                }
                Ok(scalars.into())
            }
            other => Err(Error::Malformed(format!("{other:?} is no type of a value"))),
        }
    }

    /// Type of a part of a composite, and its first scalar.
    pub fn part(&self, kind: Id, index: u32) -> Result<(Id, u32)> {
        match self.kind(kind)? {
            Type::Vector(of, _) | Type::Matrix(of, _) | Type::Array(of, _) => {
                Ok((*of, index * self.scalars(*of)?.len() as u32))
            }
            Type::Struct(members) => {
                let mut first = 0;
                for member in members.iter().take(index as usize) {
                    first += self.scalars(*member)?.len() as u32;
                }
                let member = members.get(index as usize);
                Ok((*member.ok_or_else(|| Error::Malformed("a member that there is not".into()))?, first))
            }
            other => Err(Error::Malformed(format!("{other:?} has no parts"))),
        }
    }

    /// Offsets in bytes of the scalars of a type in memory.
    pub fn offsets(&self, kind: Id, matrix: MatrixLayout) -> Result<Vec<u32>> {
        Ok(match self.kind(kind)? {
            Type::Float | Type::Int => vec![0],
            Type::Bool => return Err(Error::Malformed("a bool lies in memory".into())),
            Type::Vector(_, count) => {
                let step = if matrix.rows { matrix.stride } else { 4 };
                (0..*count).map(|i| i * step).collect()
            }
            Type::Array(of, count) => {
                let (stride, element) = (self.stride(kind)?, self.offsets(*of, matrix)?);
                (0..*count).flat_map(|i| element.iter().map(move |offset| i * stride + offset)).collect()
            }
            Type::Matrix(of, count) => {
                let (step, column) = (if matrix.rows { 4 } else { matrix.stride }, self.offsets(*of, matrix)?);
                (0..*count).flat_map(|i| column.iter().map(move |offset| i * step + offset)).collect()
            }
            Type::Struct(members) => {
                let mut offsets = vec![];
                for (i, member) in members.iter().enumerate() {
                    let (first, matrix) = self.member_layout(kind, i as u32)?;
                    offsets.extend(self.offsets(*member, matrix)?.iter().map(|offset| first + offset));
                }
                offsets
            }
            other => return Err(Error::Malformed(format!("{other:?} does not lie in memory"))),
        })
    }

    /// Offset of a member in bytes, and the layout of matrices in it.
    pub fn member_layout(&self, structure: Id, member: u32) -> Result<(u32, MatrixLayout)> {
        let offset = self.member(structure, member, Decoration::Offset);
        let offset = offset.ok_or_else(|| Error::Malformed("a member has no offset".into()))?;
        let stride = self.member(structure, member, Decoration::MatrixStride).unwrap_or(0);
        let rows = self.member(structure, member, Decoration::RowMajor).is_some();
        Ok((offset, MatrixLayout { stride, rows }))
    }

    /// Distance of an array's elements in bytes.
    pub fn stride(&self, array: Id) -> Result<u32> {
        let stride = self.decoration(array, Decoration::ArrayStride);
        stride.ok_or_else(|| Error::Malformed("an array in memory has no stride".into()))
    }
}
