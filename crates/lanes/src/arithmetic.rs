//! Instructions that compute: each becomes one or more operations on scalars, in an order that decides the bits.

use std::rc::Rc;

use spirv::{GlslStd450Op as GLOp, Op};

use crate::error::{Error, Result};
use crate::lower::Lowering;
use crate::module::Instruction;
use crate::program::{Kind, Operation, Value};

use Operation::{Call, Infix};

/// Operation on each scalar of two operands, and the kind of its result.
fn binary(op: Op) -> Option<(Operation, Kind)> {
    use Kind::{Bool, Float, Uint};
    Some(match op {
        Op::FAdd => (Infix("+"), Float),
        Op::FSub => (Infix("-"), Float),
        Op::FMul => (Infix("*"), Float),
        Op::FDiv => (Infix("/"), Float),
        Op::IAdd => (Infix("+"), Uint),
        Op::ISub => (Infix("-"), Uint),
        Op::IMul => (Infix("*"), Uint),
        Op::BitwiseAnd => (Infix("&"), Uint),
        Op::BitwiseOr => (Infix("|"), Uint),
        Op::BitwiseXor => (Infix("^"), Uint),
        Op::ShiftLeftLogical => (Call("shift_left"), Uint),
        Op::ShiftRightLogical => (Call("shift_right"), Uint),
        Op::ShiftRightArithmetic => (Call("shift_right_signed"), Uint),
        Op::UDiv => (Call("quotient"), Uint),
        Op::UMod => (Call("remainder"), Uint),
        Op::SDiv => (Call("quotient_signed"), Uint),
        Op::SRem => (Call("remainder_signed"), Uint),
        Op::FRem => (Call("remainder"), Float),

        Op::FOrdEqual => (Call("equal"), Bool),
        Op::FUnordNotEqual => (Call("not_equal"), Bool),
        Op::FOrdLessThan => (Call("less"), Bool),
        Op::FOrdGreaterThan => (Call("greater"), Bool),
        Op::FOrdLessThanEqual => (Call("less_equal"), Bool),
        Op::FOrdGreaterThanEqual => (Call("greater_equal"), Bool),
        Op::FOrdNotEqual => (Call("less_or_greater"), Bool),
        Op::IEqual => (Call("equal"), Bool),
        Op::INotEqual => (Call("not_equal"), Bool),
        Op::ULessThan => (Call("less"), Bool),
        Op::UGreaterThan => (Call("greater"), Bool),
        Op::ULessThanEqual => (Call("less_equal"), Bool),
        Op::UGreaterThanEqual => (Call("greater_equal"), Bool),
        Op::SLessThan => (Call("less_signed"), Bool),
        Op::SGreaterThan => (Call("greater_signed"), Bool),
        Op::SLessThanEqual => (Call("less_equal_signed"), Bool),
        Op::SGreaterThanEqual => (Call("greater_equal_signed"), Bool),

        Op::LogicalAnd => (Infix("&"), Bool),
        Op::LogicalOr => (Infix("|"), Bool),
        Op::LogicalNotEqual => (Call("differ"), Bool),
        Op::LogicalEqual => (Call("agree"), Bool),
        _ => return None,
    })
}

/// Comparison that is false exactly where `op` is true, NaN included.
fn opposite(op: Op) -> Option<&'static str> {
    Some(match op {
        Op::FUnordEqual => "less_or_greater",
        Op::FUnordLessThan => "greater_equal",
        Op::FUnordGreaterThan => "less_equal",
        Op::FUnordLessThanEqual => "greater",
        Op::FUnordGreaterThanEqual => "less",
        _ => return None,
    })
}

/// Operation on each scalar of one operand, and the kind of its result.
fn unary(op: Op) -> Option<(&'static str, Kind)> {
    Some(match op {
        Op::FNegate => ("negate", Kind::Float),
        Op::SNegate => ("negate", Kind::Uint),
        Op::Not => ("complement", Kind::Uint),
        Op::LogicalNot => ("inverse", Kind::Bool),
        Op::BitReverse => ("reverse_bits", Kind::Uint),
        Op::BitCount => ("count_bits", Kind::Uint),
        Op::ConvertUToF => ("from_unsigned", Kind::Float),
        Op::ConvertSToF => ("from_signed", Kind::Float),
        Op::ConvertFToU => ("to_unsigned", Kind::Uint),
        Op::ConvertFToS => ("to_signed", Kind::Uint),
        Op::IsNan => ("is_nan", Kind::Bool),
        Op::IsInf => ("is_infinite", Kind::Bool),
        _ => return None,
    })
}

/// Function of GLSL.std.450 on each scalar of its operands, and the kind of its result.
fn elementwise(op: GLOp) -> Option<(&'static str, Kind)> {
    use Kind::{Float, Uint};
    Some(match op {
        GLOp::FMin => ("least", Float),
        GLOp::FMax => ("largest", Float),
        GLOp::UMin => ("least", Uint),
        GLOp::UMax => ("largest", Uint),
        GLOp::SMin => ("least_signed", Uint),
        GLOp::SMax => ("largest_signed", Uint),
        GLOp::FAbs => ("absolute", Float),
        GLOp::Sqrt => ("square_root", Float),
        GLOp::Floor => ("round_down", Float),
        GLOp::Ceil => ("round_up", Float),
        GLOp::Trunc => ("truncate", Float),
        GLOp::RoundEven => ("round_even", Float),
        GLOp::Exp => ("c_exp", Float),
        GLOp::Exp2 => ("c_exp2", Float),
        GLOp::Log => ("c_log", Float),
        GLOp::Log2 => ("c_log2", Float),
        GLOp::Pow => ("c_pow", Float),
        GLOp::Sin => ("c_sin", Float),
        GLOp::Cos => ("c_cos", Float),
        GLOp::Tan => ("c_tan", Float),
        GLOp::Asin => ("c_asin", Float),
        GLOp::Acos => ("c_acos", Float),
        GLOp::Atan => ("c_atan", Float),
        GLOp::Atan2 => ("c_atan2", Float),
        _ => return None,
    })
}

impl Lowering<'_, '_> {
    fn add(&mut self, a: Value, b: Value) -> Value {
        self.compute(Infix("+"), Kind::Float, &[a, b])
    }

    fn subtract(&mut self, a: Value, b: Value) -> Value {
        self.compute(Infix("-"), Kind::Float, &[a, b])
    }

    fn multiply(&mut self, a: Value, b: Value) -> Value {
        self.compute(Infix("*"), Kind::Float, &[a, b])
    }

    /// Sum of products, from the first to the last.
    fn dot(&mut self, a: &[Value], b: &[Value]) -> Value {
        let mut sum = self.multiply(a[0], b[0]);
        for (a, b) in a.iter().zip(b).skip(1) {
            let product = self.multiply(*a, *b);
            sum = self.add(sum, product);
        }
        sum
    }

    /// Values of an instruction that computes; `None` if it is none.
    pub fn arithmetic(&mut self, instruction: &Instruction) -> Result<Option<Vec<Value>>> {
        let words = &instruction.words;
        if let Some((operation, kind)) = binary(instruction.op) {
            let (a, b) = (self.values(words[0])?, self.values(words[1])?);
            let results = a.iter().zip(b.iter()).map(|(a, b)| self.compute(operation, kind, &[*a, *b]));
            return Ok(Some(results.collect()));
        }
        if let Some(opposite) = opposite(instruction.op) {
            let (a, b) = (self.values(words[0])?, self.values(words[1])?);
            let compare = |(a, b): (&Value, &Value)| {
                let opposite = self.compute(Call(opposite), Kind::Bool, &[*a, *b]);
                self.compute(Call("inverse"), Kind::Bool, &[opposite])
            };
            return Ok(Some(a.iter().zip(b.iter()).map(compare).collect()));
        }
        if let Some((name, kind)) = unary(instruction.op) {
            let a = self.values(words[0])?;
            return Ok(Some(a.iter().map(|a| self.compute(Call(name), kind, &[*a])).collect()));
        }
        Ok(Some(match instruction.op {
            Op::ExtInst if Some(words[0]) == self.module.glsl => return self.glsl(words[1], &words[2..]).map(Some),
            Op::Select => {
                let (condition, yes, no) = (self.values(words[0])?, self.values(words[1])?, self.values(words[2])?);
                let choice = |(i, (yes, no)): (usize, (&Value, &Value))| {
                    let condition = if condition.len() == 1 { condition[0] } else { condition[i] };
                    let kind = self.program_kind(*yes);
                    self.compute(Call("choose"), kind, &[condition, *yes, *no])
                };
                yes.iter().zip(no.iter()).enumerate().map(choice).collect()
            }
            Op::All | Op::Any => {
                let a = self.values(words[0])?;
                let operation = Infix(if instruction.op == Op::All { "&" } else { "|" });
                let both = |both, a: &Value| self.compute(operation, Kind::Bool, &[both, *a]);
                vec![a.iter().skip(1).fold(a[0], both)]
            }
            Op::Bitcast => {
                let kind = self.module.scalars(instruction.kind)?[0];
                let values = self.values(words[0])?;
                let cast = |value: &Value| match *value {
                    Value::Constant(_, bits) => Value::Constant(kind, bits),
                    value if self.program_kind(value) == kind => value,
                    value => self.compute(Call("cast"), kind, &[value]),
                };
                values.iter().map(cast).collect()
            }
            Op::VectorTimesScalar | Op::MatrixTimesScalar => {
                let (a, scalar) = (self.values(words[0])?, self.values(words[1])?[0]);
                a.iter().map(|a| self.multiply(*a, scalar)).collect()
            }
            Op::Dot => {
                let (a, b) = (self.values(words[0])?, self.values(words[1])?);
                vec![self.dot(&a, &b)]
            }
            Op::MatrixTimesVector => {
                let (matrix, vector) = (self.values(words[0])?, self.values(words[1])?);
                let rows = matrix.len() / vector.len();
                let row = |i| matrix.iter().skip(i).step_by(rows).copied().collect::<Vec<_>>();
                (0..rows).map(|i| self.dot(&row(i), &vector)).collect()
            }
            Op::VectorTimesMatrix => {
                let (vector, matrix) = (self.values(words[0])?, self.values(words[1])?);
                matrix.chunks(vector.len()).map(|column| self.dot(&vector, column)).collect()
            }
            Op::CompositeConstruct => {
                let mut values = vec![];
                for part in words.iter() {
                    values.extend_from_slice(&self.values(*part)?);
                }
                values
            }
            Op::CompositeExtract => {
                let whole = self.values(words[0])?;
                let (first, count) = self.part(self.kind_of(words[0])?, &words[1..])?;
                whole[first..first + count].to_vec()
            }
            Op::CompositeInsert => {
                let (part, mut whole) = (self.values(words[0])?, self.values(words[1])?.to_vec());
                let (first, count) = self.part(instruction.kind, &words[2..])?;
                whole[first..first + count].copy_from_slice(&part);
                whole
            }
            Op::VectorShuffle => {
                let both = [self.values(words[0])?, self.values(words[1])?].concat();
                let undefined = Value::Constant(self.module.scalars(instruction.kind)?[0], 0);
                words[2..].iter().map(|i| both.get(*i as usize).copied().unwrap_or(undefined)).collect()
            }
            Op::VectorExtractDynamic => {
                let (vector, index) = (self.values(words[0])?, self.values(words[1])?[0]);
                let kind = self.program_kind(vector[0]);
                let mut chosen = vector[0];
                for (i, value) in vector.iter().enumerate().skip(1) {
                    let wanted = Value::Constant(Kind::Uint, i as u32);
                    let here = self.compute(Call("equal"), Kind::Bool, &[index, wanted]);
                    chosen = self.compute(Call("choose"), kind, &[here, *value, chosen]);
                }
                vec![chosen]
            }
            Op::CopyObject | Op::CopyLogical => self.values(words[0])?.to_vec(),
            Op::Undef => self.module.scalars(instruction.kind)?.iter().map(|kind| Value::Constant(*kind, 0)).collect(),
            _ => return Ok(None),
        }))
    }

    /// First scalar of a part of a composite, and how many it has.
    fn part(&self, mut kind: u32, indices: &[u32]) -> Result<(usize, usize)> {
        let mut first = 0;
        for index in indices {
            let part = self.module.part(kind, *index)?;
            (kind, first) = (part.0, first + part.1 as usize);
        }
        Ok((first, self.module.scalars(kind)?.len()))
    }

    /// Values of a function of GLSL.std.450.
    fn glsl(&mut self, op: u32, arguments: &[u32]) -> Result<Vec<Value>> {
        let function = self.function_name();
        let unsupported = |instruction| Error::Unsupported { instruction, function };
        let Some(op) = GLOp::from_u32(op) else { return Err(unsupported(format!("GLSL.std.450's {op}"))) };
        let arguments: Vec<Rc<[Value]>> = arguments.iter().map(|id| self.values(*id)).collect::<Result<_>>()?;
        let of = |i: usize| arguments.iter().map(|argument| argument[i]).collect::<Vec<_>>();
        let count = arguments.first().map_or(0, |first| first.len());
        if let Some((name, kind)) = elementwise(op) {
            return Ok((0..count).map(|i| self.compute(Call(name), kind, &of(i))).collect());
        }
        let mut each = |compute: &mut dyn FnMut(&mut Self, &[Value]) -> Value| -> Vec<Value> {
            (0..count).map(|i| compute(self, &of(i))).collect()
        };
        let limited = |this: &mut Self, kind, v: &[Value], largest, least| {
            let raised = this.compute(Call(largest), kind, &[v[0], v[1]]);
            this.compute(Call(least), kind, &[raised, v[2]])
        };
        Ok(match op {
            GLOp::FClamp => each(&mut |this, v| limited(this, Kind::Float, v, "largest", "least")),
            GLOp::UClamp => each(&mut |this, v| limited(this, Kind::Uint, v, "largest", "least")),
            GLOp::SClamp => each(&mut |this, v| limited(this, Kind::Uint, v, "largest_signed", "least_signed")),
            GLOp::FMix => each(&mut |this, v| {
                let difference = this.subtract(v[1], v[0]);
                let part = this.multiply(difference, v[2]);
                this.add(v[0], part)
            }),
            GLOp::Fract => each(&mut |this, v| {
                let whole = this.compute(Call("round_down"), Kind::Float, v);
                this.subtract(v[0], whole)
            }),
            GLOp::Length | GLOp::Normalize => {
                let squared = self.dot(&arguments[0], &arguments[0]);
                let length = self.compute(Call("square_root"), Kind::Float, &[squared]);
                if op == GLOp::Length {
                    return Ok(vec![length]);
                }
                arguments[0].iter().map(|a| self.compute(Infix("/"), Kind::Float, &[*a, length])).collect()
            }
            GLOp::Cross => {
                let (a, b) = (&arguments[0], &arguments[1]);
                let mut component = |i: usize, j: usize| {
                    let (first, second) = (self.multiply(a[i], b[j]), self.multiply(a[j], b[i]));
                    self.subtract(first, second)
                };
                vec![component(1, 2), component(2, 0), component(0, 1)]
            }
            GLOp::Reflect => {
                let (incident, normal) = (&arguments[0], &arguments[1]);
                let cosine = self.dot(normal, incident);
                let twice = self.multiply(Value::Constant(Kind::Float, 2f32.to_bits()), cosine);
                let mut component = |(incident, normal): (&Value, &Value)| {
                    let along = self.multiply(twice, *normal);
                    self.subtract(*incident, along)
                };
                incident.iter().zip(normal.iter()).map(&mut component).collect()
            }
            _ => return Err(unsupported(format!("{op:?} of GLSL.std.450"))),
        })
    }
}
