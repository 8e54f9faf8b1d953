//! Pointers, and what is read and written through them.
//!
//! A pointer is known when kernels are translated, but for the indices of elements. Words of local variables are registers,
//! except where an index chooses among them: see `locals.rs`. Buffers hold words of 32 bits at the offsets that SPIR-V says.

use std::rc::Rc;

use spirv::{BuiltIn, StorageClass};

use crate::error::{Error, Result};
use crate::layout::MatrixLayout;
use crate::lower::{Bound, Lowering};
use crate::module::{Id, Type};
use crate::program::{Index, Instruction, Kept, Kind, Memory, Operation, Place, Target, Value};

/// Variable in which a pointer points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Root {
    /// Place of a function's variable in `Program::locals`.
    Local(u32),
    Outside(Memory),
    Input(BuiltIn),
}

/// Where something lies.
#[derive(Clone, Copy, Debug)]
pub struct Pointer {
    pub root: Root,
    /// Type of what lies there.
    pub kind: Id,
    /// Place in the variable but for the index: words of a local one, bytes of others.
    place: u32,
    index: Option<Index>,
    matrix: MatrixLayout,
}

impl Pointer {
    /// A whole variable.
    pub fn to(root: Root, kind: Id) -> Self {
        Self { root, kind, place: 0, index: None, matrix: MatrixLayout::default() }
    }
}

impl Lowering<'_, '_> {
    /// Pointer to a part of what `pointer` points to.
    pub fn part_of(&mut self, mut pointer: Pointer, indices: &[Id]) -> Result<Pointer> {
        let local = matches!(pointer.root, Root::Local(_));
        for &id in indices {
            let kind = self.module.kind(pointer.kind)?.clone();
            let constant = self.module.scalar(id);
            let (element, count) = match kind {
                Type::Struct(_) => {
                    let member = constant.ok_or_else(|| Error::Malformed("a member is not constant".into()))?;
                    let (part, first) = self.module.part(pointer.kind, member)?;
                    if local || matches!(pointer.root, Root::Input(_)) {
                        pointer.place += first;
                    } else {
                        let (offset, matrix) = self.module.member_layout(pointer.kind, member)?;
                        (pointer.place, pointer.matrix) = (pointer.place + offset, matrix);
                    }
                    pointer.kind = part;
                    continue;
                }
                Type::RuntimeArray(of) => (of, u32::MAX),
                Type::Array(of, count) | Type::Vector(of, count) | Type::Matrix(of, count) => (of, count),
                other => return Err(Error::Malformed(format!("{other:?} has no elements"))),
            };
            let words = self.module.scalars(element)?.len() as u32;
            let step = match (pointer.root, &kind) {
                (Root::Outside(Memory::Columns(buffer)), Type::RuntimeArray(_)) => {
                    self.own_element(buffer, id)?;
                    pointer.kind = element;
                    continue;
                }
                (Root::Local(_) | Root::Input(_), _) => words,
                (_, Type::Array(..) | Type::RuntimeArray(_)) => self.module.stride(pointer.kind)?,
                (_, Type::Matrix(..)) if pointer.matrix.rows => 4,
                (_, Type::Matrix(..)) => pointer.matrix.stride,
                (_, Type::Vector(..)) if pointer.matrix.rows => pointer.matrix.stride,
                _ => 4,
            };
            match constant {
                Some(index) => pointer.place += index * step,
                None => {
                    let range = (pointer.place, count.saturating_mul(words));
                    let value = self.values(id)?[0];
                    let index = Index { value, stride: step, range };
                    pointer.index = Some(match pointer.index {
                        Some(outer) => self.both(outer, index, if local { 1 } else { 4 }),
                        None => index,
                    });
                }
            }
            pointer.kind = element;
        }
        Ok(pointer)
    }

    /// Both indices as one, of words that are `unit` apart.
    fn both(&mut self, outer: Index, inner: Index, unit: u32) -> Index {
        let mut scaled = |index: Index| {
            let stride = Value::Constant(Kind::Uint, index.stride / unit);
            self.compute(Operation::Infix("*"), Kind::Uint, &[index.value, stride])
        };
        let (outer_words, inner_words) = (scaled(outer), scaled(inner));
        let value = self.compute(Operation::Infix("+"), Kind::Uint, &[outer_words, inner_words]);
        Index { value, stride: unit, range: outer.range }
    }

    /// Insists that the element of a buffer of columns is the invocation's own.
    fn own_element(&mut self, buffer: usize, index: Id) -> Result<()> {
        if self.values(index)?[..] == [Value::Register(0)] && self.program.is_entry_point {
            return Ok(());
        }
        let name = self.shared.buffers[buffer].name.clone();
        Err(Error::Malformed(format!(
            "`{name}`, of which each invocation owns one element, is indexed by other than its place along x in {}",
            self.function_name()
        )))
    }

    /// What lies there.
    pub fn load(&mut self, pointer: Pointer) -> Result<Rc<[Value]>> {
        let kinds = self.module.scalars(pointer.kind)?;
        let variable = match pointer.root {
            Root::Input(BuiltIn::GlobalInvocationId) if pointer.index.is_none() && self.program.is_entry_point => {
                return Ok((pointer.place..).take(kinds.len()).map(Value::Register).collect());
            }
            Root::Input(built_in) => {
                return Err(Error::Unsupported {
                    instruction: format!("the built-in {built_in:?}"),
                    function: self.function_name(),
                });
            }
            Root::Outside(memory) => {
                let registers: Vec<_> = kinds.iter().map(|kind| self.program.register(*kind)).collect();
                let offsets = self.module.offsets(pointer.kind, pointer.matrix)?;
                let to = registers
                    .iter()
                    .zip(offsets)
                    .map(|(register, offset)| (Target::from(*register), pointer.place + offset));
                self.push(Instruction::Load { memory, to: to.collect(), index: pointer.index });
                return Ok(registers.into_iter().map(Value::Register).collect());
            }
            Root::Local(variable) => variable,
        };
        let mut values = vec![];
        for (i, kind) in kinds.iter().enumerate() {
            let register = self.program.register(*kind);
            let place = Place { variable, word: pointer.place + i as u32, index: pointer.index };
            self.push(Instruction::Read { to: register.into(), place });
            values.push(Value::Register(register));
        }
        Ok(values.into())
    }

    /// Puts `values` there.
    pub fn store(&mut self, pointer: Pointer, values: &[Value]) -> Result<()> {
        match pointer.root {
            Root::Local(variable) => {
                for (i, value) in values.iter().enumerate() {
                    let place = Place { variable, word: pointer.place + i as u32, index: pointer.index };
                    self.push(Instruction::Write { from: *value, place, kept: Kept::default() });
                }
            }
            Root::Outside(memory) => {
                let offsets = self.module.offsets(pointer.kind, pointer.matrix)?;
                let from = values.iter().zip(offsets).map(|(value, offset)| (*value, pointer.place + offset));
                self.push(Instruction::Store { memory, from: from.collect(), index: pointer.index });
            }
            Root::Input(_) => return Err(Error::Malformed("an input is written".into())),
        }
        Ok(())
    }

    /// A new variable of the running function, which holds nothing yet.
    pub fn local(&mut self, pointer: Id) -> Result<Pointer> {
        let &Type::Pointer(_, kind) = self.module.kind(pointer)? else {
            return Err(Error::Malformed("a variable is not reached by a pointer".into()));
        };
        self.program.locals.push(self.module.scalars(kind)?);
        let variable = self.program.locals.len() as u32 - 1;
        self.push(Instruction::Begin(vec![variable]));
        Ok(Pointer::to(Root::Local(variable), kind))
    }

    /// Pointer to a variable outside of functions.
    pub fn global(&mut self, id: Id) -> Result<Bound> {
        let global = self.module.globals.get(&id).ok_or_else(|| Error::Malformed(format!("%{id} is nowhere")))?;
        let kind = global.kind;
        let root = match global.class {
            StorageClass::PushConstant => Root::Outside(Memory::Work),
            StorageClass::StorageBuffer | StorageClass::Uniform => Root::Outside(self.buffer(id)),
            StorageClass::Input => {
                let built_in = self.module.built_in(id);
                Root::Input(built_in.ok_or_else(|| Error::Malformed("an input is not built in".into()))?)
            }
            class => {
                let instruction = format!("a variable of the class {class:?}");
                return Err(Error::Unsupported { instruction, function: self.function_name() });
            }
        };
        Ok(Bound::Pointer(Pointer::to(root, kind)))
    }
}
