//! Reader of SPIR-V modules: types, constants, names, decorations and functions with their blocks.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use spirv::{BuiltIn, Decoration, Op, StorageClass};

use crate::error::{Error, Result};

/// Name of a result in a module.
pub type Id = u32;

/// Type of a value.
#[derive(Clone, Debug)]
pub enum Type {
    Void,
    Bool,
    /// 32 bits.
    Int,
    /// 32 bits.
    Float,
    Vector(Id, u32),
    /// Type of the columns, and their number.
    Matrix(Id, u32),
    /// Type of the elements, and their number.
    Array(Id, u32),
    RuntimeArray(Id),
    Struct(Rc<[Id]>),
    Pointer(StorageClass, Id),
    /// A type that no value of a kernel may have.
    Other,
}

/// Value that is known before the kernel runs.
#[derive(Clone, Debug)]
pub enum Constant {
    /// Type, and the bits; 0 or 1 of a bool.
    Scalar(Id, u32),
    Composite(Id, Rc<[Id]>),
    /// All zeros.
    Null(Id),
    /// Any value.
    Undefined(Id),
}

impl Constant {
    /// Type of the value.
    pub fn kind(&self) -> Id {
        match *self {
            Self::Scalar(kind, _) | Self::Composite(kind, _) | Self::Null(kind) | Self::Undefined(kind) => kind,
        }
    }
}

/// One instruction, with its type and result apart from the other words.
#[derive(Clone, Debug)]
pub struct Instruction {
    pub op: Op,
    /// Type of the result; 0 if there is none.
    pub kind: Id,
    /// Result; 0 if there is none.
    pub result: Id,
    pub words: Rc<[u32]>,
}

/// Instructions that run one after another; the last says where to go on.
#[derive(Clone, Debug, Default)]
pub struct Block {
    pub instructions: Vec<Instruction>,
    /// Where the branches of a selection or a loop come together again.
    pub merge: Option<Id>,
    /// Where a loop goes on to its next turn, if the block is a loop's header.
    pub next: Option<Id>,
}

/// A function.
#[derive(Clone, Debug)]
pub struct Function {
    pub id: Id,
    /// Type of what it returns.
    pub kind: Id,
    /// Parameters, with their types.
    pub parameters: Vec<(Id, Id)>,
    /// Its first block.
    pub start: Id,
    pub blocks: BTreeMap<Id, Block>,
}

/// A variable outside of functions.
#[derive(Clone, Debug)]
pub struct Global {
    pub class: StorageClass,
    /// Type of what it holds.
    pub kind: Id,
}

/// Layout of a type or variable, and what else decorations say.
#[derive(Clone, Debug, Default)]
struct Decorated {
    words: HashMap<Decoration, u32>,
    members: HashMap<(u32, Decoration), u32>,
}

/// A whole module.
#[derive(Debug, Default)]
pub struct Module {
    pub types: HashMap<Id, Type>,
    pub constants: HashMap<Id, Constant>,
    pub globals: HashMap<Id, Global>,
    pub functions: HashMap<Id, Function>,
    /// Entry points, by their names.
    pub entry_points: Vec<(String, Id)>,
    /// Set of instructions that `OpExtInst` calls GLSL.std.450.
    pub glsl: Option<Id>,
    names: HashMap<Id, String>,
    decorations: HashMap<Id, Decorated>,
}

impl Module {
    /// Reads the module in `words`. Specialisation constants have the values that `specialisation` gives them by their
    /// `SpecId`, or else their own.
    pub fn read(words: &[u32], specialisation: &HashMap<u32, u32>) -> Result<Self> {
        const HEADER: usize = 5;
        const MAGIC: u32 = 0x0723_0203;
        if words.len() < HEADER || words[0] != MAGIC {
            return Err(Error::Malformed("it has no header".into()));
        }
        let mut module = Self::default();
        let mut function: Option<Function> = None;
        let mut block: Option<(Id, Block)> = None;
        let mut rest = &words[HEADER..];
        while let Some(&first) = rest.first() {
            let length = first as usize >> 16;
            let words = rest.get(1..length.max(1)).ok_or_else(|| Error::Malformed("it is cut short".into()))?;
            if length == 0 {
                return Err(Error::Malformed("an instruction has no length".into()));
            }
            rest = &rest[length..];
            let op = Op::from_u32(first & 0xffff).ok_or_else(|| Error::unsupported(first & 0xffff, "the module"))?;
            module.instruction(op, words, specialisation, &mut function, &mut block)?;
        }
        Ok(module)
    }

    fn instruction(
        &mut self,
        op: Op,
        w: &[u32],
        specialisation: &HashMap<u32, u32>,
        function: &mut Option<Function>,
        block: &mut Option<(Id, Block)>,
    ) -> Result<()> {
        let needed = match op {
            Op::Function | Op::EntryPoint | Op::Variable | Op::TypeArray | Op::TypeVector | Op::TypeMatrix => 3,
            Op::TypePointer | Op::Constant | Op::SpecConstant | Op::SpecConstantOp | Op::MemberDecorate => 3,
            Op::Decorate | Op::FunctionParameter | Op::ConstantTrue | Op::ConstantFalse | Op::ConstantComposite => 2,
            Op::SpecConstantTrue | Op::SpecConstantFalse | Op::SpecConstantComposite | Op::ConstantNull => 2,
            Op::LoopMerge | Op::ExtInstImport | Op::Name | Op::TypeRuntimeArray | Op::TypeInt | Op::TypeFloat => 2,
            Op::SelectionMerge | Op::Label | Op::TypeVoid | Op::TypeBool | Op::TypeStruct | Op::Undef => 1,
            _ => 0,
        };
        if w.len() < needed {
            return Err(Error::Malformed(format!("Op{op:?} lacks operands")));
        }
        match op {
            Op::Name => _ = self.names.insert(w[0], text(&w[1..])),
            Op::ExtInstImport if text(&w[1..]) == "GLSL.std.450" => self.glsl = Some(w[0]),
            Op::EntryPoint => self.entry_points.push((text(&w[2..]), w[1])),
            Op::Decorate => self.decorate(w[0], None, w[1], w.get(2)),
            Op::MemberDecorate => self.decorate(w[0], Some(w[1]), w[2], w.get(3)),

            Op::TypeVoid => self.define(w[0], Type::Void),
            Op::TypeBool => self.define(w[0], Type::Bool),
            Op::TypeInt => self.define(w[0], if w[1] == 32 { Type::Int } else { Type::Other }),
            Op::TypeFloat => self.define(w[0], if w[1] == 32 { Type::Float } else { Type::Other }),
            Op::TypeVector => self.define(w[0], Type::Vector(w[1], w[2])),
            Op::TypeMatrix => self.define(w[0], Type::Matrix(w[1], w[2])),
            Op::TypeArray => {
                let length = self.scalar(w[2]).ok_or_else(|| Error::Malformed("an array has no length".into()))?;
                self.define(w[0], Type::Array(w[1], length));
            }
            Op::TypeRuntimeArray => self.define(w[0], Type::RuntimeArray(w[1])),
            Op::TypeStruct => self.define(w[0], Type::Struct(w[1..].into())),
            Op::TypePointer => {
                let class = StorageClass::from_u32(w[1]).ok_or_else(|| Error::Malformed("a storage class".into()))?;
                self.define(w[0], Type::Pointer(class, w[2]));
            }

            Op::Constant => _ = self.constants.insert(w[1], Constant::Scalar(w[0], w[2])),
            Op::ConstantTrue => _ = self.constants.insert(w[1], Constant::Scalar(w[0], 1)),
            Op::ConstantFalse => _ = self.constants.insert(w[1], Constant::Scalar(w[0], 0)),
            Op::ConstantNull => _ = self.constants.insert(w[1], Constant::Null(w[0])),
            Op::ConstantComposite | Op::SpecConstantComposite => {
                self.constants.insert(w[1], Constant::Composite(w[0], w[2..].into()));
            }
            Op::SpecConstant | Op::SpecConstantTrue | Op::SpecConstantFalse => {
                let own = if op == Op::SpecConstant { w[2] } else { u32::from(op == Op::SpecConstantTrue) };
                let given = self.decoration(w[1], Decoration::SpecId).and_then(|id| specialisation.get(&id));
                self.constants.insert(w[1], Constant::Scalar(w[0], given.copied().unwrap_or(own)));
            }
            Op::SpecConstantOp => {
                let value = self.evaluate(w[2], &w[3..])?;
                self.constants.insert(w[1], Constant::Scalar(w[0], value));
            }
            Op::Undef if function.is_none() && w.len() > 1 => {
                self.constants.insert(w[1], Constant::Undefined(w[0]));
            }
            Op::Variable if function.is_none() => {
                let Some(&Type::Pointer(class, kind)) = self.types.get(&w[0]) else {
                    return Err(Error::Malformed("a variable is not reached by a pointer".into()));
                };
                self.globals.insert(w[1], Global { class, kind });
            }

            Op::Function => {
                let parameters = vec![];
                *function = Some(Function { id: w[1], kind: w[0], parameters, start: 0, blocks: BTreeMap::new() });
            }
            Op::FunctionParameter => {
                let function = function.as_mut().ok_or_else(|| Error::Malformed("a parameter of nothing".into()))?;
                function.parameters.push((w[1], w[0]));
            }
            Op::FunctionEnd => {
                let function = function.take().ok_or_else(|| Error::Malformed("an end of nothing".into()))?;
                self.functions.insert(function.id, function);
            }
            Op::Label => {
                let function = function.as_mut().ok_or_else(|| Error::Malformed("a label outside".into()))?;
                if function.blocks.is_empty() && function.start == 0 {
                    function.start = w[0];
                }
                *block = Some((w[0], Block::default()));
            }
            Op::SelectionMerge | Op::LoopMerge => {
                if let Some((_, block)) = block {
                    block.merge = Some(w[0]);
                    block.next = (op == Op::LoopMerge).then(|| w[1]);
                }
            }
            Op::Line | Op::NoLine => {}
            _ => return self.body(op, w, function, block),
        }
        Ok(())
    }

    /// Appends an instruction to the block that is being read. What stands outside of functions and is not known here has
    /// no bearing on what kernels do.
    fn body(&self, op: Op, w: &[u32], function: &mut Option<Function>, block: &mut Option<(Id, Block)>) -> Result<()> {
        let (Some(function), Some((_, current))) = (function.as_mut(), block.as_mut()) else { return Ok(()) };
        let ends = matches!(
            op,
            Op::Branch | Op::BranchConditional | Op::Switch | Op::Return | Op::ReturnValue | Op::Unreachable | Op::Kill
        );
        let silent =
            ends || matches!(op, Op::Store | Op::CopyMemory | Op::Nop | Op::ControlBarrier | Op::MemoryBarrier);
        let silent = silent || matches!(op, Op::AtomicStore | Op::TerminateInvocation);
        let skipped = if silent { 0 } else { 2 };
        let words = w.get(skipped..).ok_or_else(|| Error::Malformed(format!("Op{op:?} lacks operands")))?.into();
        let (kind, result) = if silent { (0, 0) } else { (w[0], w[1]) };
        current.instructions.push(Instruction { op, kind, result, words });
        if ends {
            let (label, finished) = block.take().unwrap_or_default();
            function.blocks.insert(label, finished);
        }
        Ok(())
    }

    fn define(&mut self, id: Id, kind: Type) {
        self.types.insert(id, kind);
    }

    fn decorate(&mut self, id: Id, member: Option<u32>, decoration: u32, word: Option<&u32>) {
        let Some(decoration) = Decoration::from_u32(decoration) else { return };
        let (decorated, word) = (self.decorations.entry(id).or_default(), word.copied().unwrap_or(0));
        match member {
            Some(member) => _ = decorated.members.insert((member, decoration), word),
            None => _ = decorated.words.insert(decoration, word),
        }
    }

    /// Value of the specialisation constant that `op` makes of `arguments`.
    fn evaluate(&self, op: u32, arguments: &[Id]) -> Result<u32> {
        let unsupported = || Error::unsupported(op, "a specialisation constant");
        let argument = |i: usize| arguments.get(i).and_then(|id| self.scalar(*id)).ok_or_else(unsupported);
        let op = Op::from_u32(op).ok_or_else(unsupported)?;
        Ok(match op {
            Op::LogicalNot => u32::from(argument(0)? == 0),
            Op::Not => !argument(0)?,
            Op::Select => argument(if argument(0)? != 0 { 1 } else { 2 })?,
            Op::IEqual | Op::LogicalEqual => u32::from(argument(0)? == argument(1)?),
            Op::INotEqual | Op::LogicalNotEqual => u32::from(argument(0)? != argument(1)?),
            Op::ULessThan => u32::from(argument(0)? < argument(1)?),
            Op::UGreaterThan => u32::from(argument(0)? > argument(1)?),
            Op::LogicalAnd | Op::BitwiseAnd => argument(0)? & argument(1)?,
            Op::LogicalOr | Op::BitwiseOr => argument(0)? | argument(1)?,
            Op::BitwiseXor => argument(0)? ^ argument(1)?,
            Op::IAdd => argument(0)?.wrapping_add(argument(1)?),
            Op::ISub => argument(0)?.wrapping_sub(argument(1)?),
            Op::IMul => argument(0)?.wrapping_mul(argument(1)?),
            Op::Bitcast => argument(0)?,
            _ => return Err(unsupported()),
        })
    }

    /// Bits of a scalar constant.
    pub fn scalar(&self, id: Id) -> Option<u32> {
        match self.constants.get(&id)? {
            Constant::Scalar(_, bits) => Some(*bits),
            Constant::Null(_) => Some(0),
            _ => None,
        }
    }

    /// The type of this name.
    pub fn kind(&self, id: Id) -> Result<&Type> {
        self.types.get(&id).ok_or_else(|| Error::Malformed(format!("%{id} is not a type")))
    }

    /// Name for people, with characters that identifiers have.
    pub fn name(&self, id: Id) -> String {
        let name = self.names.get(&id).filter(|name| !name.is_empty());
        let name = name.cloned().unwrap_or_else(|| format!("id{id}"));
        name.replace(|c: char| !c.is_ascii_alphanumeric(), "_")
    }

    /// Operand of a decoration.
    pub fn decoration(&self, id: Id, decoration: Decoration) -> Option<u32> {
        self.decorations.get(&id)?.words.get(&decoration).copied()
    }

    /// Operand of a decoration of a structure's member.
    pub fn member(&self, id: Id, member: u32, decoration: Decoration) -> Option<u32> {
        self.decorations.get(&id)?.members.get(&(member, decoration)).copied()
    }

    /// What an input variable stands for.
    pub fn built_in(&self, id: Id) -> Option<BuiltIn> {
        self.decoration(id, Decoration::BuiltIn).and_then(BuiltIn::from_u32)
    }
}

/// Text that begins at `words` and ends with a zero.
fn text(words: &[u32]) -> String {
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).take_while(|byte| *byte != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}
