//! Program between SPIR-V and C++: scalar registers, and a tree of control flow.
//!
//! Every scalar of a vector, a structure or an array is a register of its own. Registers may be assigned many times; there
//! are no phis. Control flow is a tree of branches, loops and labelled scopes: leaving a scope is the only jump.

use std::rc::Rc;

use crate::bits::Bits;

/// Kind of a scalar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Float,
    /// Integers, signed or not.
    Uint,
    Bool,
}

/// Place of a register in [`Program::registers`].
pub type Register = u32;

/// What a register holds: a scalar, or an array of words if `length` is not 0.
#[derive(Clone, Copy, Debug)]
pub struct Held {
    pub kind: Kind,
    pub length: u32,
}

/// Operand of an instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Value {
    Register(Register),
    /// Bits of a constant; 0 or 1 of a bool.
    Constant(Kind, u32),
}

/// Lanes that must keep what a register holds while others assign it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kept {
    #[default]
    Nowhere,
    /// In lanes that go the other way at the innermost branch: its condition tells them apart.
    TheOtherWay,
    /// In all that are not active.
    Everywhere,
}

/// Register that an instruction assigns.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    pub register: Register,
    pub kept: Kept,
}

/// Element of an array that is known only when the kernel runs.
#[derive(Clone, Copy, Debug)]
pub struct Index {
    pub value: Value,
    /// Distance of two elements.
    pub stride: u32,
    /// Words, of a local variable, among which the index chooses: the first, and their number.
    pub range: (u32, u32),
}

/// Word of a local variable, or, once those are resolved, of an array.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Place of the variable in [`Program::locals`], then the array's register.
    pub variable: u32,
    pub word: u32,
    pub index: Option<Index>,
}

/// How a result comes from operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    Copy,
    /// Operator of C++.
    Infix(&'static str),
    /// Function of the runtime header.
    Call(&'static str),
}

/// Memory outside of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// Buffer, by its place in [`Program::buffers`]: elements one after another, each lane has its own.
    Buffer(usize),
    /// Buffer of which every lane owns one element: a column for each word.
    Columns(usize),
    /// Push constants.
    Work,
}

/// An instruction, which all active lanes execute.
#[derive(Clone, Debug)]
pub enum Instruction {
    Compute {
        operation: Operation,
        to: Target,
        from: Vec<Value>,
    },
    /// Words of memory by their offsets in bytes, from the element at `index`.
    Load {
        memory: Memory,
        to: Vec<(Target, u32)>,
        index: Option<Index>,
    },
    Store {
        memory: Memory,
        from: Vec<(Value, u32)>,
        index: Option<Index>,
    },
    /// A word of an array.
    Read {
        to: Target,
        place: Place,
    },
    Write {
        from: Value,
        place: Place,
        kept: Kept,
    },
    /// Variables, then registers, that hold nothing yet.
    Begin(Vec<u32>),
    /// Call of a function.
    Call {
        callee: Callee,
        from: Vec<Value>,
        to: Vec<Target>,
    },
    /// Results of the function that the program is, for all lanes.
    Return(Vec<Value>),
}

/// Function that a call is of.
#[derive(Clone, Debug)]
pub enum Callee {
    /// A function that is written by hand.
    Hook(Rc<str>),
    /// Another program.
    Program(Rc<str>),
}

/// Name of a scope.
pub type Label = u32;

/// A piece of control flow.
#[derive(Clone, Debug)]
pub enum Node {
    Run(Vec<Instruction>),
    /// `live` are registers that are needed at the start of `no`, and after both.
    If {
        condition: Value,
        yes: Vec<Node>,
        no: Vec<Node>,
        live: [Bits; 2],
    },
    /// Leaves the scope of the case that has the selector's value, or else the last.
    Switch {
        selector: Value,
        cases: Vec<(Vec<u32>, Label)>,
        default: Label,
    },
    /// `outward` says whether the body may leave scopes around this one. `live` are registers that are needed after it.
    Scope {
        label: Label,
        body: Vec<Node>,
        outward: bool,
        live: Bits,
    },
    /// Runs until no lane is left. `live` are registers that are needed at the start.
    Loop {
        body: Vec<Node>,
        live: Bits,
    },
    Exit(Label),
}

/// A buffer of the module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Buffer {
    /// Name in the source.
    pub name: String,
    /// Descriptor set.
    pub set: u32,
    /// Binding in the set.
    pub binding: u32,
    /// Whether the kernels may write it.
    pub writable: bool,
    /// Whether it is one of `Options::columns`.
    pub columns: bool,
}

/// Variable of a function: the kinds of its words.
pub type Local = Rc<[Kind]>;

/// One entry point, or a function that is called.
#[derive(Debug, Default)]
pub struct Program {
    pub registers: Vec<Held>,
    pub locals: Vec<Local>,
    pub labels: Label,
    /// Number of registers, the first ones, that are assigned from outside: those of an entry point are the invocation's
    /// place in the grid.
    pub parameters: u32,
    /// Kinds of the function's results.
    pub results: Vec<Kind>,
    pub is_entry_point: bool,
    pub body: Vec<Node>,
}

impl Program {
    pub fn register(&mut self, kind: Kind) -> Register {
        self.registers.push(Held { kind, length: 0 });
        self.registers.len() as u32 - 1
    }

    pub fn array(&mut self, length: u32) -> Register {
        self.registers.push(Held { kind: Kind::Float, length });
        self.registers.len() as u32 - 1
    }

    pub fn label(&mut self) -> Label {
        self.labels += 1;
        self.labels - 1
    }
}

impl Instruction {
    /// Operands.
    pub fn operands(&self) -> Vec<Value> {
        let index = |index: &Option<Index>| index.map(|index| index.value);
        match self {
            Self::Compute { from, .. } | Self::Call { from, .. } | Self::Return(from) => from.clone(),
            Self::Load { index: i, .. } => index(i).into_iter().collect(),
            Self::Store { from, index: i, .. } => from.iter().map(|(value, _)| *value).chain(index(i)).collect(),
            Self::Read { place, .. } => index(&place.index).into_iter().collect(),
            Self::Write { from, place, .. } => [*from].into_iter().chain(index(&place.index)).collect(),
            Self::Begin(_) => vec![],
        }
    }

    /// Operands, to be changed.
    pub fn operands_mut(&mut self) -> Vec<&mut Value> {
        fn value(index: &mut Option<Index>) -> Option<&mut Value> {
            index.as_mut().map(|index| &mut index.value)
        }
        match self {
            Self::Compute { from, .. } | Self::Call { from, .. } | Self::Return(from) => from.iter_mut().collect(),
            Self::Load { index, .. } => value(index).into_iter().collect(),
            Self::Store { from, index, .. } => from.iter_mut().map(|(v, _)| v).chain(value(index)).collect(),
            Self::Read { place, .. } => value(&mut place.index).into_iter().collect(),
            Self::Write { from, place, .. } => [from].into_iter().chain(value(&mut place.index)).collect(),
            Self::Begin(_) => vec![],
        }
    }

    /// Registers that are assigned. Arrays are not among them.
    pub fn targets_mut(&mut self) -> Vec<&mut Target> {
        match self {
            Self::Compute { to, .. } | Self::Read { to, .. } => vec![to],
            Self::Load { to, .. } => to.iter_mut().map(|(target, _)| target).collect(),
            Self::Call { to, .. } => to.iter_mut().collect(),
            Self::Store { .. } | Self::Write { .. } | Self::Begin(_) | Self::Return(_) => vec![],
        }
    }

    /// Registers that are assigned. Arrays are not among them.
    pub fn targets(&self) -> Vec<Target> {
        match self {
            Self::Compute { to, .. } | Self::Read { to, .. } => vec![*to],
            Self::Load { to, .. } => to.iter().map(|(target, _)| *target).collect(),
            Self::Call { to, .. } => to.clone(),
            Self::Store { .. } | Self::Write { .. } | Self::Begin(_) | Self::Return(_) => vec![],
        }
    }
}

impl From<Register> for Target {
    fn from(register: Register) -> Self {
        Self { register, kept: Kept::default() }
    }
}
