//! Interpreter of SPIR-V: one invocation, block after block, as the specification tells it.

use std::collections::HashMap;
use std::rc::Rc;

use spirv::{GlslStd450Op as GLOp, Op, StorageClass};

use crate::module::{Constant, Function, Id, Instruction, Module, Type};

/// Words of buffers, by their names.
pub type Buffers = HashMap<String, Vec<u32>>;

#[derive(Clone, Debug)]
enum Bound {
    Words(Rc<[u32]>),
    /// Variable, the word in it, and the type of what lies there.
    Pointer(Root, usize, Id),
}

#[derive(Clone, Debug)]
enum Root {
    Local(usize),
    Buffer(Rc<str>),
    Place,
}

/// One invocation.
pub struct Interpreter<'m> {
    module: &'m Module,
    buffers: &'m mut Buffers,
    invocation: u32,
    locals: Vec<Vec<u32>>,
}

impl<'m> Interpreter<'m> {
    /// Runs an entry point for the invocation at this place along x.
    pub fn run(module: &'m Module, entry: Id, invocation: u32, buffers: &'m mut Buffers) {
        let mut interpreter = Self { module, buffers, invocation, locals: vec![] };
        interpreter.call(&module.functions[&entry], vec![]);
    }

    fn size(&self, kind: Id) -> usize {
        self.module.scalars(kind).unwrap().len()
    }

    fn call(&mut self, function: &Function, arguments: Vec<Bound>) -> Rc<[u32]> {
        let mut values: HashMap<Id, Bound> = function.parameters.iter().map(|(id, _)| *id).zip(arguments).collect();
        let mut kinds: HashMap<Id, Id> = function.parameters.iter().copied().collect();
        let (mut block, mut before) = (function.start, 0);
        loop {
            let instructions = &function.blocks[&block].instructions;
            let phis = instructions.iter().take_while(|instruction| instruction.op == Op::Phi);
            let chosen: Vec<_> = phis
                .map(|phi| {
                    let pair = phi.words.chunks(2).find(|pair| pair[1] == before).expect("the edge has a value");
                    (phi.result, phi.kind, self.bound(&values, pair[0]))
                })
                .collect();
            for (id, kind, bound) in chosen {
                values.insert(id, bound);
                kinds.insert(id, kind);
            }
            before = block;
            for instruction in instructions {
                let w = &instruction.words;
                match instruction.op {
                    Op::Branch => block = w[0],
                    Op::BranchConditional => block = w[if self.words(&values, w[0])[0] != 0 { 1 } else { 2 }],
                    Op::Switch => {
                        let selector = self.words(&values, w[0])[0];
                        let case = w[2..].chunks(2).find(|case| case[0] == selector);
                        block = case.map_or(w[1], |case| case[1]);
                    }
                    Op::Return => return [].into(),
                    Op::ReturnValue => return self.words(&values, w[0]),
                    Op::Unreachable => panic!("the unreachable is reached"),
                    _ => {
                        if let Some(bound) = self.instruction(instruction, &values, &kinds) {
                            values.insert(instruction.result, bound);
                            kinds.insert(instruction.result, instruction.kind);
                        }
                    }
                }
            }
        }
    }

    fn bound(&self, values: &HashMap<Id, Bound>, id: Id) -> Bound {
        if let Some(bound) = values.get(&id) {
            return bound.clone();
        }
        if self.module.constants.contains_key(&id) {
            return Bound::Words(self.constant(id));
        }
        let global = &self.module.globals[&id];
        let root = match global.class {
            StorageClass::Input => Root::Place,
            _ => Root::Buffer(self.module.name(id).into()),
        };
        Bound::Pointer(root, 0, global.kind)
    }

    fn constant(&self, id: Id) -> Rc<[u32]> {
        match &self.module.constants[&id] {
            Constant::Scalar(_, bits) => [*bits].into(),
            Constant::Null(kind) | Constant::Undefined(kind) => vec![0; self.size(*kind)].into(),
            Constant::Composite(_, parts) => parts.iter().flat_map(|part| self.constant(*part).to_vec()).collect(),
        }
    }

    fn words(&self, values: &HashMap<Id, Bound>, id: Id) -> Rc<[u32]> {
        match self.bound(values, id) {
            Bound::Words(words) => words,
            Bound::Pointer(..) => panic!("a pointer where a value is needed"),
        }
    }

    /// Words of memory at which the scalars of a pointer's target lie.
    fn at(&self, root: &Root, word: usize, kind: Id) -> Vec<usize> {
        match root {
            Root::Local(_) | Root::Place => (word..word + self.size(kind)).collect(),
            Root::Buffer(_) => {
                let offsets = self.module.offsets(kind, Default::default()).unwrap();
                offsets.iter().map(|offset| word + *offset as usize / 4).collect()
            }
        }
    }

    fn instruction(
        &mut self,
        instruction: &Instruction,
        values: &HashMap<Id, Bound>,
        kinds: &HashMap<Id, Id>,
    ) -> Option<Bound> {
        let w = &instruction.words;
        let of = |this: &Self, i: usize| this.words(values, w[i]);
        let kind_of = |id: Id| kinds.get(&id).copied().unwrap_or_else(|| self.module.constants[&id].kind());
        Some(Bound::Words(match instruction.op {
            Op::Phi => return None,
            Op::Variable => {
                let Type::Pointer(_, kind) = self.module.types[&instruction.kind] else { panic!("no pointer") };
                // What a variable holds before anything is stored must not matter.
                self.locals.push(vec![0x5bad_5bad; self.size(kind)]);
                return Some(Bound::Pointer(Root::Local(self.locals.len() - 1), 0, kind));
            }
            Op::AccessChain => {
                let Bound::Pointer(root, mut word, mut kind) = self.bound(values, w[0]) else { panic!("no pointer") };
                for id in &w[1..] {
                    let index = self.words(values, *id)[0];
                    let local = !matches!(root, Root::Buffer(_));
                    (word, kind) = match self.module.types[&kind] {
                        Type::Struct(_) if !local => {
                            let offset = self.module.member_layout(kind, index).unwrap().0 as usize / 4;
                            (word + offset, self.module.part(kind, index).unwrap().0)
                        }
                        Type::Array(of, _) | Type::RuntimeArray(of) if !local => {
                            (word + index as usize * self.module.stride(kind).unwrap() as usize / 4, of)
                        }
                        _ => {
                            let (part, first) = self.module.part(kind, index).unwrap();
                            (word + first as usize, part)
                        }
                    };
                }
                return Some(Bound::Pointer(root, word, kind));
            }
            Op::Load => {
                let Bound::Pointer(root, word, kind) = self.bound(values, w[0]) else { panic!("no pointer") };
                let at = self.at(&root, word, kind);
                match root {
                    Root::Local(local) => at.iter().map(|i| self.locals[local][*i]).collect(),
                    Root::Buffer(name) => at.iter().map(|i| self.buffers[&*name][*i]).collect(),
                    Root::Place => at.iter().map(|i| [self.invocation, 0, 0][*i]).collect(),
                }
            }
            Op::Store => {
                let Bound::Pointer(root, word, kind) = self.bound(values, w[0]) else { panic!("no pointer") };
                let stored = of(self, 1);
                for (i, value) in self.at(&root, word, kind).into_iter().zip(stored.iter()) {
                    match &root {
                        Root::Local(local) => self.locals[*local][i] = *value,
                        Root::Buffer(name) => self.buffers.get_mut(&**name).unwrap()[i] = *value,
                        Root::Place => panic!("an input is written"),
                    }
                }
                return None;
            }
            Op::FunctionCall => {
                let arguments = w[1..].iter().map(|id| self.bound(values, *id)).collect();
                let module = self.module;
                self.call(&module.functions[&w[0]], arguments)
            }
            Op::CompositeConstruct => w.iter().flat_map(|id| self.words(values, *id).to_vec()).collect(),
            Op::CompositeExtract | Op::CompositeInsert => {
                let inserts = instruction.op == Op::CompositeInsert;
                let (whole, indices) = if inserts { (w[1], &w[2..]) } else { (w[0], &w[1..]) };
                let (mut kind, mut first) = (kind_of(whole), 0);
                for index in indices {
                    let part = self.module.part(kind, *index).unwrap();
                    (kind, first) = (part.0, first + part.1 as usize);
                }
                let (mut whole, end) = (self.words(values, whole).to_vec(), first + self.size(kind));
                if inserts {
                    whole[first..end].copy_from_slice(&of(self, 0));
                    whole.into()
                } else {
                    whole[first..end].into()
                }
            }
            Op::VectorShuffle => {
                let both = [of(self, 0), of(self, 1)].concat();
                w[2..].iter().map(|i| both[*i as usize]).collect()
            }
            Op::VectorExtractDynamic => [of(self, 0)[of(self, 1)[0] as usize]].into(),
            Op::CopyObject | Op::CopyLogical | Op::Bitcast => of(self, 0),
            Op::Undef => vec![0; self.size(instruction.kind)].into(),
            Op::Select => {
                let (condition, yes, no) = (of(self, 0), of(self, 1), of(self, 2));
                let condition = |i: usize| condition[if condition.len() == 1 { 0 } else { i }];
                (0..yes.len()).map(|i| if condition(i) != 0 { yes[i] } else { no[i] }).collect()
            }
            Op::All => [u32::from(of(self, 0).iter().all(|x| *x != 0))].into(),
            Op::Any => [u32::from(of(self, 0).iter().any(|x| *x != 0))].into(),
            Op::VectorTimesScalar => {
                let scalar = of(self, 1)[0];
                of(self, 0).iter().map(|x| binary(Op::FMul, *x, scalar)).collect()
            }
            Op::Dot => [dot(&of(self, 0), &of(self, 1))].into(),
            Op::MatrixTimesVector => {
                let (matrix, vector) = (of(self, 0), of(self, 1));
                let rows = matrix.len() / vector.len();
                let row = |i| matrix.iter().skip(i).step_by(rows).copied().collect::<Vec<_>>();
                (0..rows).map(|i| dot(&row(i), &vector)).collect()
            }
            Op::VectorTimesMatrix => {
                let (vector, matrix) = (of(self, 0), of(self, 1));
                matrix.chunks(vector.len()).map(|column| dot(&vector, column)).collect()
            }
            Op::ExtInst => {
                let arguments: Vec<_> = (2..w.len()).map(|i| of(self, i)).collect();
                glsl(GLOp::from_u32(w[1]).unwrap(), &arguments)
            }
            op if w.len() == 1 => of(self, 0).iter().map(|x| unary(op, *x)).collect(),
            op => of(self, 0).iter().zip(of(self, 1).iter()).map(|(a, b)| binary(op, *a, *b)).collect(),
        }))
    }
}

fn dot(a: &[u32], b: &[u32]) -> u32 {
    let products = a.iter().zip(b).map(|(a, b)| f32::from_bits(*a) * f32::from_bits(*b));
    products.reduce(|sum, product| sum + product).unwrap().to_bits()
}

fn unary(op: Op, x: u32) -> u32 {
    let f = f32::from_bits(x);
    match op {
        Op::FNegate => (-f).to_bits(),
        Op::SNegate => x.wrapping_neg(),
        Op::Not => !x,
        Op::LogicalNot => u32::from(x == 0),
        Op::BitReverse => x.reverse_bits(),
        Op::BitCount => x.count_ones(),
        Op::ConvertUToF => (x as f32).to_bits(),
        Op::ConvertSToF => (x as i32 as f32).to_bits(),
        Op::ConvertFToU => f as u32,
        Op::ConvertFToS => f as i32 as u32,
        Op::IsNan => u32::from(f.is_nan()),
        Op::IsInf => u32::from(f.is_infinite()),
        op => panic!("{op:?}"),
    }
}

fn binary(op: Op, a: u32, b: u32) -> u32 {
    let (x, y) = (f32::from_bits(a), f32::from_bits(b));
    let (i, j) = (a as i32, b as i32);
    let truth = |truth: bool| u32::from(truth);
    let nan = x.is_nan() || y.is_nan();
    match op {
        Op::FAdd => (x + y).to_bits(),
        Op::FSub => (x - y).to_bits(),
        Op::FMul => (x * y).to_bits(),
        Op::FDiv => (x / y).to_bits(),
        Op::FRem => (x % y).to_bits(),
        Op::IAdd => a.wrapping_add(b),
        Op::ISub => a.wrapping_sub(b),
        Op::IMul => a.wrapping_mul(b),
        Op::UDiv => a / b,
        Op::UMod => a % b,
        Op::SDiv => i.wrapping_div(j) as u32,
        Op::SRem => i.wrapping_rem(j) as u32,
        Op::BitwiseAnd | Op::LogicalAnd => a & b,
        Op::BitwiseOr | Op::LogicalOr => a | b,
        Op::BitwiseXor | Op::LogicalNotEqual => a ^ b,
        Op::ShiftLeftLogical => a << b,
        Op::ShiftRightLogical => a >> b,
        Op::ShiftRightArithmetic => (i >> b) as u32,
        Op::LogicalEqual | Op::IEqual => truth(a == b),
        Op::INotEqual => truth(a != b),
        Op::ULessThan => truth(a < b),
        Op::UGreaterThan => truth(a > b),
        Op::ULessThanEqual => truth(a <= b),
        Op::UGreaterThanEqual => truth(a >= b),
        Op::SLessThan => truth(i < j),
        Op::SGreaterThan => truth(i > j),
        Op::SLessThanEqual => truth(i <= j),
        Op::SGreaterThanEqual => truth(i >= j),
        Op::FOrdEqual => truth(x == y),
        Op::FOrdNotEqual => truth(!nan && x != y),
        Op::FOrdLessThan => truth(x < y),
        Op::FOrdGreaterThan => truth(x > y),
        Op::FOrdLessThanEqual => truth(x <= y),
        Op::FOrdGreaterThanEqual => truth(x >= y),
        Op::FUnordEqual => truth(nan || x == y),
        Op::FUnordNotEqual => truth(x != y),
        Op::FUnordLessThan => truth(nan || x < y),
        Op::FUnordGreaterThan => truth(nan || x > y),
        Op::FUnordLessThanEqual => truth(nan || x <= y),
        Op::FUnordGreaterThanEqual => truth(nan || x >= y),
        op => panic!("{op:?}"),
    }
}

fn glsl(op: GLOp, arguments: &[Rc<[u32]>]) -> Rc<[u32]> {
    let count = arguments[0].len();
    let float = |i: usize, k: usize| f32::from_bits(arguments[i][k]);
    let floats = |compute: &dyn Fn(usize) -> f32| (0..count).map(|k| compute(k).to_bits()).collect();
    let words = |compute: &dyn Fn(usize) -> u32| (0..count).map(compute).collect();
    let a = |k: usize| float(0, k);
    let b = |k: usize| float(1, k);
    let least = |a: f32, b: f32| if a < b { a } else { b };
    let largest = |a: f32, b: f32| if a > b { a } else { b };
    let length = || f32::from_bits(dot(&arguments[0], &arguments[0])).sqrt();
    match op {
        GLOp::FMin => floats(&|k| least(a(k), b(k))),
        GLOp::FMax => floats(&|k| largest(a(k), b(k))),
        GLOp::UMin => words(&|k| arguments[0][k].min(arguments[1][k])),
        GLOp::UMax => words(&|k| arguments[0][k].max(arguments[1][k])),
        GLOp::SMin => words(&|k| (arguments[0][k] as i32).min(arguments[1][k] as i32) as u32),
        GLOp::SMax => words(&|k| (arguments[0][k] as i32).max(arguments[1][k] as i32) as u32),
        GLOp::FAbs => floats(&|k| a(k).abs()),
        GLOp::Sqrt => floats(&|k| a(k).sqrt()),
        GLOp::Floor => floats(&|k| a(k).floor()),
        GLOp::Ceil => floats(&|k| a(k).ceil()),
        GLOp::Trunc => floats(&|k| a(k).trunc()),
        GLOp::RoundEven => floats(&|k| a(k).round_ties_even()),
        GLOp::Fract => floats(&|k| a(k) - a(k).floor()),
        GLOp::FClamp => floats(&|k| least(largest(a(k), b(k)), float(2, k))),
        GLOp::FMix => floats(&|k| a(k) + (b(k) - a(k)) * float(2, k)),
        GLOp::Length => [length().to_bits()].into(),
        GLOp::Normalize => floats(&|k| a(k) / length()),
        GLOp::Cross => floats(&|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            a(i) * b(j) - a(j) * b(i)
        }),
        GLOp::Reflect => {
            let twice = 2.0 * f32::from_bits(dot(&arguments[1], &arguments[0]));
            floats(&|k| a(k) - twice * b(k))
        }
        op => panic!("{op:?}"),
    }
}
