//! Registers that must be kept for lanes that are not active, and those that are the same in all lanes.
//!
//! All lanes go through the C++ together, and those that are not active *wait* somewhere: at the other way of a branch, at
//! its end, or at the end of a scope that they have left. An assignment must be masked exactly if the register is *live*
//! (still needed) where lanes wait. So a variable of a loop needs no mask as long as nothing behind the loop reads it, and of
//! the two ways of a branch only the second masks what both assign, and the branch's condition is all the mask that takes
//! unless lanes wait elsewhere too.
//!
//! A register is *varying*, a vector of lanes, if it is made of what varies, or if it is masked; the others are scalars.
//! Lanes part only at conditions that vary: the others make nobody wait. Both are found together, from the assumption that
//! nothing varies, until nothing changes.

use crate::bits::Bits;
use crate::program::{Instruction, Kept, Label, Memory, Node, Place, Program, Register, Value};
use crate::simplify::falls;

/// Result of the analysis.
#[derive(Debug, Default)]
pub struct Analysis {
    varying: Vec<bool>,
    /// Registers by their places in sets of live ones.
    numbered: Vec<Register>,
}

impl Analysis {
    /// Whether a value is a vector of lanes.
    pub fn varies(&self, value: Value) -> bool {
        matches!(value, Value::Register(register) if self.varying[register as usize])
    }

    /// Registers of a set of live ones.
    pub fn registers<'a>(&'a self, live: &'a Bits) -> impl Iterator<Item = Register> + 'a {
        live.iter().map(|number| self.numbered[number as usize])
    }
}

impl Program {
    /// Drops what nothing needs, and finds out what is masked and what varies.
    pub fn analyse(&mut self) -> Analysis {
        let mut body = std::mem::take(&mut self.body);
        let numbers = self.numbers(&body);
        let mut liveness = Liveness {
            numbers: &numbers,
            after: vec![Bits::default(); self.labels as usize],
            here: vec![false; numbers.len()],
            changed: true,
            sweeps: false,
        };
        while std::mem::take(&mut liveness.changed) {
            liveness.list(&mut body, Bits::default());
        }
        liveness.sweeps = true;
        liveness.list(&mut body, Bits::default());
        let after = liveness.after;

        let mut varying = vec![false; self.registers.len()];
        varying[..self.parameters as usize].fill(true);
        let parted = vec![false; self.labels as usize];
        let mut waiting =
            Waiting { numbers, after, varying, parted, open: vec![], at: vec![], depth: 0, changed: true };
        while std::mem::take(&mut waiting.changed) {
            waiting.list(&mut body, &Bits::default(), &Bits::default());
        }
        self.body = body;
        let numbered =
            (0..).zip(&waiting.numbers).filter(|(_, number)| **number != LOCAL).map(|(register, _)| register);
        Analysis { varying: waiting.varying, numbered: numbered.collect() }
    }

    /// Numbers of the registers that may outlive the run of instructions in which they are assigned; `LOCAL` for others.
    fn numbers(&self, body: &[Node]) -> Vec<u32> {
        let mut scan = Scan { seen: vec![Seen::Nowhere; self.registers.len()], run: 0 };
        scan.list(body);
        let mut next = 0;
        let outlives = scan.seen.into_iter().zip(&self.registers);
        let number = |outlives: bool| {
            next += u32::from(outlives);
            if outlives { next - 1 } else { LOCAL }
        };
        outlives.map(|(seen, held)| matches!(seen, Seen::Everywhere) || held.length > 0).map(number).collect()
    }
}

const LOCAL: u32 = u32::MAX;

#[derive(Clone, Copy)]
enum Seen {
    Nowhere,
    /// In one run, assigned once.
    Here(u32),
    Everywhere,
}

struct Scan {
    seen: Vec<Seen>,
    run: u32,
}

impl Scan {
    fn list(&mut self, nodes: &[Node]) {
        for node in nodes {
            self.run += 1;
            match node {
                Node::Run(run) => {
                    for instruction in run {
                        instruction.operands().into_iter().for_each(|value| self.read(value));
                        for target in instruction.targets() {
                            let seen = &mut self.seen[target.register as usize];
                            *seen = if matches!(seen, Seen::Nowhere) { Seen::Here(self.run) } else { Seen::Everywhere };
                        }
                    }
                }
                Node::If { condition, yes, no, .. } => {
                    self.read(*condition);
                    self.list(yes);
                    self.list(no);
                }
                Node::Switch { selector, .. } => self.read(*selector),
                Node::Loop { body, .. } | Node::Scope { body, .. } => self.list(body),
                Node::Exit(_) => {}
            }
        }
    }

    fn read(&mut self, value: Value) {
        let Value::Register(register) = value else { return };
        let seen = &mut self.seen[register as usize];
        if !matches!(*seen, Seen::Here(run) if run == self.run) {
            *seen = Seen::Everywhere;
        }
    }
}

/// Goes through the tree against the order of execution.
struct Liveness<'a> {
    numbers: &'a [u32],
    /// Registers that are live behind each scope.
    after: Vec<Bits>,
    /// Whether a register that does not outlive its run is live.
    here: Vec<bool>,
    changed: bool,
    /// Whether what nothing needs is dropped.
    sweeps: bool,
}

impl Liveness<'_> {
    /// Registers that are live before a list, if `live` are after it.
    fn list(&mut self, nodes: &mut [Node], mut live: Bits) -> Bits {
        for node in nodes.iter_mut().rev() {
            match node {
                Node::Run(run) => {
                    let mut kept = vec![];
                    for mut instruction in std::mem::take(run).into_iter().rev() {
                        if self.instruction(&mut instruction, &mut live) || !self.sweeps {
                            kept.push(instruction);
                        }
                    }
                    kept.reverse();
                    *run = kept;
                }
                Node::If { condition, yes, no, live: [before_no, after] } => {
                    *before_no = self.list(no, live.clone());
                    let mut before = self.list(yes, live.clone());
                    *after = live;
                    before.add(before_no);
                    self.read(*condition, &mut before);
                    live = before;
                }
                Node::Switch { selector, cases, default } => {
                    live = self.after[*default as usize].clone();
                    cases.iter().for_each(|(_, label)| live.add(&self.after[*label as usize]));
                    self.read(*selector, &mut live);
                }
                Node::Exit(label) => live = self.after[*label as usize].clone(),
                Node::Scope { label, body, live: after, .. } => {
                    self.after[*label as usize] = live.clone();
                    *after = live.clone();
                    live = self.list(body, live);
                }
                Node::Loop { body, live: start } => {
                    live = self.list(body, start.clone());
                    self.changed |= live != *start;
                    *start = live.clone();
                }
            }
        }
        live
    }

    /// Whether an instruction is needed; changes `live` to what it is before it.
    fn instruction(&mut self, instruction: &mut Instruction, live: &mut Bits) -> bool {
        let is_live = |this: &Self, live: &Bits, register: Register| match this.numbers[register as usize] {
            LOCAL => this.here[register as usize],
            number => live.contains(number),
        };
        let needed = match &mut *instruction {
            Instruction::Store { .. } | Instruction::Call { .. } | Instruction::Return(_) => true,
            Instruction::Write { place, .. } => is_live(self, live, place.variable),
            Instruction::Begin(registers) => {
                registers.retain(|register| self.numbers[*register as usize] != LOCAL);
                registers.iter().for_each(|register| live.remove(self.numbers[*register as usize]));
                true
            }
            other => other.targets().iter().any(|target| is_live(self, live, target.register)),
        };
        if !needed {
            return false;
        }
        if let (true, Instruction::Load { to, .. }) = (self.sweeps, &mut *instruction) {
            to.retain(|(target, _)| is_live(self, live, target.register));
        }
        for target in instruction.targets() {
            match self.numbers[target.register as usize] {
                LOCAL => self.here[target.register as usize] = false,
                number => live.remove(number),
            }
        }
        if let Instruction::Read { place, .. } = instruction {
            live.insert(self.numbers[place.variable as usize]);
        }
        instruction.operands().into_iter().for_each(|value| self.read(value, live));
        true
    }

    fn read(&mut self, value: Value, live: &mut Bits) {
        let Value::Register(register) = value else { return };
        match self.numbers[register as usize] {
            LOCAL => self.here[register as usize] = true,
            number => live.insert(number),
        }
    }
}

/// Goes through the tree as it is executed.
struct Waiting {
    numbers: Vec<u32>,
    after: Vec<Bits>,
    varying: Vec<bool>,
    /// Scopes that some lanes leave while others stay inside.
    parted: Vec<bool>,
    /// Scopes around here, and at how many parted branches they begin.
    open: Vec<(Label, u32)>,
    /// Scopes at whose ends lanes may wait.
    at: Vec<Label>,
    /// Number of branches around here at which lanes part.
    depth: u32,
    changed: bool,
}

impl Waiting {
    fn varies(&self, value: Value) -> bool {
        matches!(value, Value::Register(register) if self.varying[register as usize])
    }

    /// What is live where lanes wait, if `branches` is at branches around here.
    fn waits(&self, branches: &Bits) -> Bits {
        let mut waits = branches.clone();
        self.at.iter().for_each(|label| waits.add(&self.after[*label as usize]));
        waits
    }

    /// `way` is what lanes need that go the other way at the innermost branch around, `branches` what is needed at those
    /// around that one.
    fn list(&mut self, nodes: &mut [Node], branches: &Bits, way: &Bits) {
        let mut waits = self.waits(branches);
        let mut scopes = self.at.clone();
        for node in nodes {
            if scopes != self.at {
                waits = self.waits(branches);
                scopes.clone_from(&self.at);
            }
            match node {
                Node::Run(run) => run.iter_mut().for_each(|instruction| self.instruction(instruction, &waits, way)),
                Node::If { condition, yes, no, live: [before_no, after] } => {
                    if !self.varies(*condition) {
                        self.list(yes, branches, way);
                        self.list(no, branches, way);
                        continue;
                    }
                    self.depth += 1;
                    let mut around = branches.clone();
                    around.add(way);
                    self.list(yes, &around, before_no);
                    let nothing = Bits::default();
                    self.list(no, &around, if falls(yes) { after } else { &nothing });
                    self.depth -= 1;
                }
                Node::Switch { selector, cases, default } => {
                    let parts = u32::from(self.varies(*selector));
                    self.depth += parts;
                    let labels: Vec<_> = cases.iter().map(|(_, label)| *label).chain([*default]).collect();
                    labels.into_iter().for_each(|label| self.exit(label));
                    self.depth -= parts;
                }
                Node::Exit(label) => self.exit(*label),
                Node::Scope { label, body, .. } => {
                    self.open.push((*label, self.depth));
                    self.list(body, branches, way);
                    self.open.pop();
                    self.at.retain(|other| other != label);
                }
                Node::Loop { body, .. } => {
                    // Lanes that a turn before has sent out of the loop wait during the next.
                    let mut left = vec![];
                    exits(body, &mut left);
                    for label in left {
                        let is_around = self.open.iter().any(|(open, _)| *open == label);
                        if is_around && self.parted[label as usize] && !self.at.contains(&label) {
                            self.at.push(label);
                        }
                    }
                    self.list(body, branches, way);
                }
            }
        }
    }

    fn exit(&mut self, label: Label) {
        let Some(place) = self.open.iter().position(|(open, _)| *open == label) else { return };
        let waits_inside = self.open[place + 1..].iter().any(|(inner, _)| self.at.contains(inner));
        if self.open[place].1 == self.depth && !waits_inside {
            return;
        }
        self.changed |= !std::mem::replace(&mut self.parted[label as usize], true);
        if !self.at.contains(&label) {
            self.at.push(label);
        }
    }

    fn instruction(&mut self, instruction: &mut Instruction, waits: &Bits, way: &Bits) {
        let kept_where = |numbers: &[u32], register: Register| match numbers[register as usize] {
            LOCAL => Kept::Nowhere,
            number if waits.contains(number) => Kept::Everywhere,
            number if way.contains(number) => Kept::TheOtherWay,
            _ => Kept::Nowhere,
        };
        let varies = match instruction {
            Instruction::Compute { from, .. } => from.iter().any(|value| self.varies(*value)),
            Instruction::Load { memory: Memory::Columns(_), .. } => true,
            Instruction::Load { index, .. } => index.is_some_and(|index| self.varies(index.value)),
            Instruction::Read { .. } | Instruction::Call { .. } | Instruction::Return(_) => true,
            Instruction::Write { place: Place { variable, .. }, kept, .. } => {
                *kept = kept_where(&self.numbers, *variable).max(*kept);
                return;
            }
            Instruction::Store { .. } | Instruction::Begin(_) => return,
        };
        for target in instruction.targets_mut() {
            target.kept = kept_where(&self.numbers, target.register).max(target.kept);
            if varies || target.kept != Kept::Nowhere {
                self.changed |= !std::mem::replace(&mut self.varying[target.register as usize], true);
            }
        }
    }
}

/// Scopes that `nodes` leave.
fn exits(nodes: &[Node], left: &mut Vec<Label>) {
    for node in nodes {
        match node {
            Node::Exit(label) => left.push(*label),
            Node::Switch { cases, default, .. } => {
                left.extend(cases.iter().map(|(_, label)| *label).chain([*default]));
            }
            Node::If { yes, no, .. } => {
                exits(yes, left);
                exits(no, left);
            }
            Node::Loop { body, .. } | Node::Scope { body, .. } => exits(body, left),
            Node::Run(_) => {}
        }
    }
}
