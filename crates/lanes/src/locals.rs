//! Local variables become registers, but for arrays in which an index chooses.
//!
//! A value that has been stored is handed on to what reads it next, as long as nothing else can have been stored between.

use std::collections::HashMap;

use crate::bits::Bits;
use crate::program::{Instruction, Node, Operation, Place, Program, Register, Target, Value};

/// Where a word of a local variable is kept.
#[derive(Clone, Copy)]
enum Home {
    Register(Register),
    /// An array, and the place in it.
    Array(Register, u32),
}

impl Program {
    /// Gives all words of local variables their registers.
    pub fn resolve_locals(&mut self) {
        let mut body = std::mem::take(&mut self.body);
        let mut ranges = vec![vec![]; self.locals.len()];
        each(&body, &mut |instruction| match instruction {
            Instruction::Read { place, .. } | Instruction::Write { place, .. } => {
                ranges[place.variable as usize].extend(place.index.map(|index| index.range));
            }
            _ => {}
        });
        let locals = self.locals.clone();
        let homes = locals.iter().zip(ranges).map(|(local, ranges)| self.homes(local, ranges)).collect();
        let mut assigned = vec![0u8; self.registers.len()];
        each(&body, &mut |instruction| {
            instruction.targets().iter().for_each(|target| {
                let count = &mut assigned[target.register as usize];
                *count = count.saturating_add(1);
            });
        });
        let mut resolver = Resolver { homes, assigned, alias: HashMap::new() };
        resolver.list(&mut body, &mut HashMap::new());
        self.body = body;
    }

    /// Homes of the words of a variable in which indices choose among `ranges`.
    fn homes(&mut self, local: &[crate::program::Kind], mut ranges: Vec<(u32, u32)>) -> Vec<Home> {
        ranges.sort_unstable();
        let mut arrays: Vec<(u32, u32)> = vec![];
        for (first, count) in ranges {
            match arrays.last_mut() {
                Some((_, end)) if first < *end => *end = (*end).max(first + count),
                _ => arrays.push((first, first + count)),
            }
        }
        let arrays: Vec<_> = arrays.into_iter().map(|(first, end)| (first, end, self.array(end - first))).collect();
        let home = |(word, kind): (u32, &crate::program::Kind)| match arrays
            .iter()
            .find(|(first, end, _)| (*first..*end).contains(&word))
        {
            Some((first, _, array)) => Home::Array(*array, word - first),
            None => Home::Register(self.register(*kind)),
        };
        (0..).zip(local).map(home).collect()
    }
}

/// Calls `see` with every instruction.
pub fn each(nodes: &[Node], see: &mut dyn FnMut(&Instruction)) {
    for node in nodes {
        match node {
            Node::Run(run) => run.iter().for_each(&mut *see),
            Node::If { yes, no, .. } => {
                each(yes, see);
                each(no, see);
            }
            Node::Loop { body, .. } | Node::Scope { body, .. } => each(body, see),
            Node::Switch { .. } | Node::Exit(_) => {}
        }
    }
}

/// What words of variables are known to hold: by register, and the place in an array.
type Known = HashMap<(Register, u32), Value>;

struct Resolver {
    homes: Vec<Vec<Home>>,
    /// How many instructions assign each register.
    assigned: Vec<u8>,
    /// What registers are copies of.
    alias: HashMap<Register, Value>,
}

impl Resolver {
    fn list(&mut self, nodes: &mut Vec<Node>, known: &mut Known) {
        for node in nodes {
            match node {
                Node::Run(run) => {
                    let instructions = std::mem::take(run);
                    for instruction in instructions {
                        self.instruction(instruction, run, known);
                    }
                }
                Node::If { condition, yes, no, .. } => {
                    self.replace(condition);
                    self.list(yes, &mut known.clone());
                    self.list(no, &mut known.clone());
                    self.forget(yes, known);
                    self.forget(no, known);
                }
                Node::Switch { selector, .. } => self.replace(selector),
                Node::Scope { body, .. } => {
                    self.list(body, &mut known.clone());
                    self.forget(body, known);
                }
                Node::Loop { body, .. } => {
                    self.forget_unresolved(body, known);
                    self.list(body, &mut known.clone());
                }
                Node::Exit(_) => {}
            }
        }
    }

    fn replace(&self, value: &mut Value) {
        while let Value::Register(register) = value
            && let Some(alias) = self.alias.get(register)
        {
            *value = *alias;
        }
    }

    fn home(&self, place: &Place) -> Home {
        self.homes[place.variable as usize][place.word as usize]
    }

    fn instruction(&mut self, mut instruction: Instruction, run: &mut Vec<Instruction>, known: &mut Known) {
        for operand in instruction.operands_mut() {
            self.replace(operand);
        }
        match instruction {
            Instruction::Read { to, place } => {
                let (home, (variable, word)) = (self.home(&place), self.key(&place));
                if place.index.is_some() {
                    run.push(Instruction::Read { to, place: Place { variable, word, ..place } });
                } else if let Some(value) = known.get(&(variable, word)) {
                    self.alias.insert(to.register, *value);
                } else {
                    known.insert((variable, word), Value::Register(to.register));
                    run.push(match home {
                        Home::Register(register) => copy(to, Value::Register(register)),
                        Home::Array(..) => Instruction::Read { to, place: Place { variable, word, index: None } },
                    });
                }
            }
            Instruction::Write { from, place, kept } => {
                let (home, (variable, word)) = (self.home(&place), self.key(&place));
                if place.index.is_some() {
                    known.retain(|(other, _), _| *other != variable);
                } else if self.is_fixed(from) {
                    known.insert((variable, word), from);
                } else {
                    known.remove(&(variable, word));
                }
                run.push(match home {
                    Home::Register(register) => copy(register.into(), from),
                    Home::Array(..) => Instruction::Write { from, place: Place { variable, word, ..place }, kept },
                });
            }
            Instruction::Begin(variables) => {
                let homes = variables.iter().flat_map(|variable| &self.homes[*variable as usize]);
                let mut registers: Vec<_> = homes.map(|home| home.key().0).collect();
                registers.dedup();
                known.retain(|(register, _), _| !registers.contains(register));
                run.push(Instruction::Begin(registers));
            }
            other => run.push(other),
        }
    }

    /// Whether a value stays what it is until the instruction that made it is executed again.
    fn is_fixed(&self, value: Value) -> bool {
        match value {
            Value::Register(register) => self.assigned.get(register as usize).is_some_and(|count| *count <= 1),
            Value::Constant(..) => true,
        }
    }

    fn key(&self, place: &Place) -> (Register, u32) {
        self.home(place).key()
    }

    /// Forgets what resolved `nodes` may have changed.
    fn forget(&self, nodes: &[Node], known: &mut Known) {
        let (mut changed, mut arrays) = (Bits::default(), Bits::default());
        each(nodes, &mut |instruction| match instruction {
            Instruction::Write { place, .. } => arrays.insert(place.variable),
            Instruction::Begin(registers) => registers.iter().for_each(|register| changed.insert(*register)),
            other => other.targets().iter().for_each(|target| changed.insert(target.register)),
        });
        known.retain(|(register, _), _| !changed.contains(*register) && !arrays.contains(*register));
    }

    /// Forgets what `nodes`, which are not resolved yet, may change.
    fn forget_unresolved(&self, nodes: &[Node], known: &mut Known) {
        let mut changed = Bits::default();
        each(nodes, &mut |instruction| match instruction {
            Instruction::Write { place, .. } => changed.insert(self.key(place).0),
            Instruction::Begin(variables) => {
                let homes = variables.iter().flat_map(|variable| &self.homes[*variable as usize]);
                homes.for_each(|home| changed.insert(home.key().0));
            }
            _ => {}
        });
        known.retain(|(register, _), _| !changed.contains(*register));
    }
}

impl Home {
    fn key(self) -> (Register, u32) {
        match self {
            Self::Register(register) => (register, 0),
            Self::Array(register, word) => (register, word),
        }
    }
}

fn copy(to: Target, value: Value) -> Instruction {
    Instruction::Compute { operation: Operation::Copy, to, from: vec![value] }
}
