//! From SPIR-V to a [`Program`]: calls are put into their callers, and blocks into a tree.
//!
//! SPIR-V is structured: each selection and loop names the block in which its branches come together. That block becomes
//! the end of a [`Node::Scope`], and a branch to it an exit, whatever it leaves on the way; so do the next turn of a loop
//! and a function's return. Phis become assignments on the edges that lead to them.

mod calls;

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use spirv::{Decoration, Op};

use crate::bits::Bits;
use crate::error::{Error, Result};
use crate::memory::Pointer;
use crate::module;
use crate::module::{Block, Constant, Function, Id, Module};
use crate::program::{Buffer, Instruction, Kind, Label, Memory, Node, Operation, Program, Register, Target, Value};

pub use calls::Shared;

/// What a name of the module stands for.
#[derive(Clone, Debug)]
pub enum Bound {
    Values(Rc<[Value]>),
    Pointer(Pointer),
}

/// A call that is being put into its caller.
struct Frame<'m> {
    function: &'m Function,
    values: HashMap<Id, Bound>,
    kinds: HashMap<Id, Id>,
    undefined: HashSet<Id>,
    /// Blocks that are the ends of scopes around here.
    ends: HashMap<Id, Label>,
    /// Scopes that something leaves.
    left: HashSet<Label>,
    visited: HashSet<Id>,
    end: Label,
    /// Registers of the result, if it comes from several places.
    result: Option<Rc<[Register]>>,
    returned: Rc<[Value]>,
}

/// Translation of one entry point, or of a function that is called.
pub struct Lowering<'m, 's> {
    pub module: &'m Module,
    pub program: Program,
    pub shared: &'s mut Shared<'m>,
    frames: Vec<Frame<'m>>,
    nodes: Vec<Node>,
}

impl<'m, 's> Lowering<'m, 's> {
    /// Program of the entry point `id`.
    pub fn entry_point(shared: &'s mut Shared<'m>, id: Id) -> Result<Program> {
        let mut lowering = Self::new(shared);
        (0..3).for_each(|_| _ = lowering.program.register(Kind::Uint));
        lowering.program.parameters = 3;
        lowering.program.is_entry_point = true;
        lowering.inline(id, vec![])?;
        Ok(lowering.finish())
    }

    fn new(shared: &'s mut Shared<'m>) -> Self {
        let module = shared.module;
        Self { module, program: Program::default(), shared, frames: vec![], nodes: vec![] }
    }

    fn finish(mut self) -> Program {
        self.program.body = self.nodes;
        self.program
    }

    fn frame(&mut self) -> &mut Frame<'m> {
        self.frames.last_mut().expect("a function is being translated")
    }

    /// Name of the function that is being translated.
    pub fn function_name(&self) -> String {
        self.frames.last().map_or_else(|| "the module".into(), |frame| self.module.name(frame.function.id))
    }

    /// Appends an instruction.
    pub fn push(&mut self, instruction: Instruction) {
        match self.nodes.last_mut() {
            Some(Node::Run(run)) => run.push(instruction),
            _ => self.nodes.push(Node::Run(vec![instruction])),
        }
    }

    /// Appends an operation, and returns its result.
    pub fn compute(&mut self, operation: Operation, kind: Kind, from: &[Value]) -> Value {
        let register = self.program.register(kind);
        self.push(Instruction::Compute { operation, to: register.into(), from: from.to_vec() });
        Value::Register(register)
    }

    fn assign(&mut self, register: Register, value: Value) {
        let (operation, to) = (Operation::Copy, Target::from(register));
        self.push(Instruction::Compute { operation, to, from: vec![value] });
    }

    /// Kind of a value.
    pub fn program_kind(&self, value: Value) -> Kind {
        match value {
            Value::Register(register) => self.program.registers[register as usize].kind,
            Value::Constant(kind, _) => kind,
        }
    }

    /// Type of the value of this name.
    pub fn kind_of(&self, id: Id) -> Result<Id> {
        let frame = self.frames.last().and_then(|frame| frame.kinds.get(&id)).copied();
        let constant = || self.module.constants.get(&id).map(Constant::kind);
        frame.or_else(constant).ok_or_else(|| Error::Malformed(format!("%{id} has no type")))
    }

    /// Scalars of the value of this name.
    pub fn values(&mut self, id: Id) -> Result<Rc<[Value]>> {
        match self.bound(id)? {
            Bound::Values(values) => Ok(values),
            Bound::Pointer(_) => Err(Error::Malformed(format!("%{id} is a pointer where a value is needed"))),
        }
    }

    fn pointer(&mut self, id: Id) -> Result<Pointer> {
        match self.bound(id)? {
            Bound::Pointer(pointer) => Ok(pointer),
            Bound::Values(_) => Err(Error::Malformed(format!("%{id} is no pointer"))),
        }
    }

    fn bound(&mut self, id: Id) -> Result<Bound> {
        if let Some(bound) = self.frame().values.get(&id) {
            return Ok(bound.clone());
        }
        let bound = match self.module.constants.get(&id) {
            Some(constant) => Bound::Values(self.constant(constant)?),
            None => self.global(id)?,
        };
        self.frame().values.insert(id, bound.clone());
        Ok(bound)
    }

    fn constant(&mut self, constant: &Constant) -> Result<Rc<[Value]>> {
        Ok(match constant {
            Constant::Scalar(kind, bits) => [Value::Constant(self.module.scalars(*kind)?[0], *bits)].into(),
            Constant::Null(kind) | Constant::Undefined(kind) => {
                self.module.scalars(*kind)?.iter().map(|kind| Value::Constant(*kind, 0)).collect()
            }
            Constant::Composite(_, parts) => {
                let mut values = vec![];
                for part in parts.iter() {
                    values.extend_from_slice(&self.values(*part)?);
                }
                values.into()
            }
        })
    }

    /// The buffer that the variable `id` is.
    pub fn buffer(&mut self, id: Id) -> Memory {
        let name = self.module.name(id);
        let decoration = |decoration| self.module.decoration(id, decoration);
        let set = decoration(Decoration::DescriptorSet).unwrap_or(0);
        let binding = decoration(Decoration::Binding).unwrap_or(0);
        let columns = self.shared.options.columns.contains(&name);
        let writable = decoration(Decoration::NonWritable).is_none();
        let buffer = Buffer { name, set, binding, writable, columns };
        let buffers = &mut self.shared.buffers;
        let place = buffers.iter().position(|known| *known == buffer).unwrap_or_else(|| {
            buffers.push(buffer);
            buffers.len() - 1
        });
        if columns { Memory::Columns(place) } else { Memory::Buffer(place) }
    }

    /// Gives all phis of a function their registers: they may be used before the block that has them.
    fn phis(&mut self, function: &Function) -> Result<()> {
        let instructions = function.blocks.values().flat_map(|block| &block.instructions);
        for phi in instructions.filter(|instruction| instruction.op == Op::Phi) {
            let kinds = self.module.scalars(phi.kind)?;
            let values = kinds.iter().map(|kind| Value::Register(self.program.register(*kind))).collect();
            self.frame().values.insert(phi.result, Bound::Values(values));
            self.frame().kinds.insert(phi.result, phi.kind);
        }
        Ok(())
    }

    /// What `translate` appends, apart from all else.
    fn nested(&mut self, translate: impl FnOnce(&mut Self) -> Result<()>) -> Result<Vec<Node>> {
        let around = std::mem::take(&mut self.nodes);
        translate(self)?;
        Ok(std::mem::replace(&mut self.nodes, around))
    }

    /// A scope of which the block `end` is the end, if that is left by anything, around what `translate` appends.
    fn scope(&mut self, end: Id, translate: impl FnOnce(&mut Self) -> Result<()>) -> Result<bool> {
        let label = self.program.label();
        let shadowed = self.frame().ends.insert(end, label);
        let body = self.nested(translate)?;
        self.frame().ends.remove(&end);
        if let Some(shadowed) = shadowed {
            self.frame().ends.insert(end, shadowed);
        }
        self.nodes.push(Node::Scope { label, body, outward: false, live: Bits::default() });
        Ok(self.frame().left.contains(&label))
    }

    /// Blocks from `start` on, until each way has left a scope around here.
    fn blocks(&mut self, start: Id) -> Result<()> {
        let function = self.frame().function;
        let mut next = Some(start);
        while let Some(id) = next {
            let block = function.blocks.get(&id).ok_or_else(|| Error::Malformed(format!("there is no block %{id}")))?;
            if !self.frame().visited.insert(id) {
                return Err(Error::Malformed(format!("{} is not structured", self.function_name())));
            }
            next = match (block.merge, block.next) {
                (Some(merge), Some(next)) => {
                    let goes_on = self.scope(merge, |this| this.turns(id, block, next))?;
                    goes_on.then_some(merge)
                }
                (Some(merge), None) => {
                    self.instructions(block)?;
                    let goes_on = self.scope(merge, |this| this.leave(id, block))?;
                    goes_on.then_some(merge)
                }
                (None, _) => {
                    self.instructions(block)?;
                    match block.instructions.last() {
                        Some(last) if last.op == Op::Branch => {
                            let to = last.words[0];
                            self.edge(id, to)?.then_some(to)
                        }
                        _ => {
                            self.leave(id, block)?;
                            None
                        }
                    }
                }
            };
        }
        Ok(())
    }

    /// The loop whose header is the block `id`, and whose turns end with the blocks from `next` on.
    fn turns(&mut self, id: Id, block: &'m Block, next: Id) -> Result<()> {
        let body = self.nested(|this| {
            let turn = |this: &mut Self| {
                this.instructions(block)?;
                this.leave(id, block)
            };
            this.scope(id, |this| {
                if next == id {
                    return turn(this);
                }
                if this.scope(next, turn)? {
                    this.blocks(next)?;
                }
                Ok(())
            })?;
            Ok(())
        })?;
        self.nodes.push(Node::Loop { body, live: Bits::default() });
        Ok(())
    }

    /// Takes the edge between two blocks, and says whether blocks go on there: the other edges leave a scope.
    fn edge(&mut self, from: Id, to: Id) -> Result<bool> {
        let block = self.frame().function.blocks.get(&to);
        let instructions = block.map(|block| &block.instructions[..]).unwrap_or_default();
        let mut moves: Vec<(Register, Value)> = vec![];
        for phi in instructions.iter().take_while(|instruction| instruction.op == Op::Phi) {
            let Some(pair) = phi.words.chunks_exact(2).find(|pair| pair[1] == from) else { continue };
            if self.is_undefined(pair[0]) {
                continue;
            }
            let (targets, sources) = (self.values(phi.result)?, self.values(pair[0])?);
            for (target, source) in targets.iter().zip(sources.iter()) {
                match *target {
                    Value::Register(register) if target != source => moves.push((register, *source)),
                    _ => {}
                }
            }
        }
        // Phis change all at once: what another one still needs is kept aside.
        for i in 0..moves.len() {
            let (_, source) = moves[i];
            let overwritten = |(target, _): &(Register, Value)| Value::Register(*target) == source;
            if moves[..i].iter().any(overwritten) {
                let kind = self.program_kind(source);
                moves[i].1 = self.compute(Operation::Copy, kind, &[source]);
            }
        }
        let aside = moves.iter().map(|(register, value)| (*register, *value)).collect::<Vec<_>>();
        for (register, value) in aside {
            self.assign(register, value);
        }
        let Some(&label) = self.frame().ends.get(&to) else { return Ok(true) };
        self.exit(label);
        Ok(false)
    }

    fn exit(&mut self, label: Label) {
        self.frame().left.insert(label);
        self.nodes.push(Node::Exit(label));
    }

    fn is_undefined(&mut self, id: Id) -> bool {
        let constant = || matches!(self.module.constants.get(&id), Some(Constant::Undefined(_)));
        constant() || self.frame().undefined.contains(&id)
    }

    /// The end of a block, which goes on in several ways or returns.
    fn leave(&mut self, id: Id, block: &'m Block) -> Result<()> {
        let last = block.instructions.last().ok_or_else(|| Error::Malformed("a block is empty".into()))?;
        let words = &last.words;
        match last.op {
            Op::Branch => {
                if self.edge(id, words[0])? {
                    self.blocks(words[0])?;
                }
            }
            Op::BranchConditional => {
                let condition = self.values(words[0])?[0];
                let way =
                    |this: &mut Self, to| -> Result<()> { if this.edge(id, to)? { this.blocks(to) } else { Ok(()) } };
                if let Value::Constant(_, bits) = condition {
                    return way(self, words[if bits != 0 { 1 } else { 2 }]);
                }
                let yes = self.nested(|this| way(this, words[1]))?;
                let no = self.nested(|this| way(this, words[2]))?;
                self.nodes.push(Node::If { condition, yes, no, live: Default::default() });
            }
            Op::Switch => self.switch(id, words)?,
            Op::Return | Op::ReturnValue => {
                if last.op == Op::ReturnValue {
                    let values = self.values(words[0])?;
                    match self.frame().result.clone() {
                        Some(registers) => {
                            registers.iter().zip(values.iter()).for_each(|(to, value)| self.assign(*to, *value));
                        }
                        None => self.frame().returned = values,
                    }
                }
                let end = self.frame().end;
                self.exit(end);
            }
            // No invocation comes here: it does not matter where this one goes on.
            Op::Unreachable => {}
            op => return Err(Error::unsupported(op as u32, &self.function_name())),
        }
        Ok(())
    }

    /// A switch: a scope for each of its targets, the first innermost, so that each case may fall into the next.
    fn switch(&mut self, id: Id, words: &[u32]) -> Result<()> {
        let selector = self.values(words[0])?[0];
        let mut targets: Vec<(Id, Vec<u32>)> = vec![];
        for case in words[2..].chunks_exact(2) {
            match targets.iter_mut().find(|(target, _)| *target == case[1]) {
                Some((_, literals)) => literals.push(case[0]),
                None => targets.push((case[1], vec![case[0]])),
            }
        }
        let default = words[1];
        if let Value::Constant(_, bits) = selector {
            let chosen = targets.iter().find(|(_, literals)| literals.contains(&bits));
            targets = vec![(chosen.map_or(default, |chosen| chosen.0), vec![])];
        } else if targets.iter().all(|(target, _)| *target != default) {
            targets.push((default, vec![]));
        }
        let (new, _): (Vec<_>, Vec<_>) = targets.iter().partition(|(to, _)| !self.frame().ends.contains_key(to));
        let new: Vec<Id> = new.into_iter().map(|(target, _)| *target).collect();
        self.cases(id, selector, default, &targets, &new)
    }

    /// Scopes of the targets `new` around the choice among all `targets`.
    fn cases(&mut self, id: Id, selector: Value, default: Id, targets: &[(Id, Vec<u32>)], new: &[Id]) -> Result<()> {
        if let [others @ .., last] = new {
            if self.scope(*last, |this| this.cases(id, selector, default, targets, others))? {
                self.blocks(*last)?;
            }
            return Ok(());
        }
        // An edge may assign phis: then it is a scope of its own.
        let only = targets.len() == 1;
        let mut cases = vec![];
        let mut otherwise = None;
        let mut edges = vec![];
        for (to, literals) in targets {
            let edge = self.nested(|this| this.edge(id, *to).map(|_| ()))?;
            let label = match edge[..] {
                [Node::Exit(label)] => label,
                _ => {
                    let label = self.program.label();
                    edges.push((label, edge));
                    label
                }
            };
            if *to == default || only {
                otherwise = Some(label);
            }
            if *to != default {
                cases.push((literals.clone(), label));
            }
        }
        let default = otherwise.ok_or_else(|| Error::Malformed("a switch has no default".into()))?;
        if only {
            let edge = edges.pop().map_or_else(|| vec![Node::Exit(default)], |(_, edge)| edge);
            self.nodes.extend(edge);
            return Ok(());
        }
        let mut choice = vec![Node::Switch { selector, cases, default }];
        for (label, edge) in edges {
            let scope = Node::Scope { label, body: choice, outward: false, live: Bits::default() };
            choice = [vec![scope], edge].concat();
        }
        self.nodes.extend(choice);
        Ok(())
    }

    /// All of a block but its end.
    fn instructions(&mut self, block: &'m Block) -> Result<()> {
        let count = block.instructions.len().saturating_sub(1);
        for instruction in &block.instructions[..count] {
            if let Some(bound) = self.instruction(instruction)? {
                self.frame().values.insert(instruction.result, bound);
                self.frame().kinds.insert(instruction.result, instruction.kind);
            }
        }
        Ok(())
    }

    fn instruction(&mut self, instruction: &module::Instruction) -> Result<Option<Bound>> {
        let words = &instruction.words;
        Ok(match instruction.op {
            Op::Phi | Op::Nop => None,
            Op::Variable => {
                let pointer = self.local(instruction.kind)?;
                if let Some(initial) = words.get(1).filter(|initial| !self.is_undefined(**initial)) {
                    let values = self.values(*initial)?;
                    self.store(pointer, &values)?;
                }
                Some(Bound::Pointer(pointer))
            }
            Op::AccessChain | Op::InBoundsAccessChain => {
                let base = self.pointer(words[0])?;
                Some(Bound::Pointer(self.part_of(base, &words[1..])?))
            }
            Op::Load => {
                let pointer = self.pointer(words[0])?;
                Some(Bound::Values(self.load(pointer)?))
            }
            Op::Store => {
                // Nothing is stored of what may be anything.
                if !self.is_undefined(words[1]) {
                    let (pointer, values) = (self.pointer(words[0])?, self.values(words[1])?);
                    self.store(pointer, &values)?;
                }
                None
            }
            Op::FunctionCall => Some(Bound::Values(self.call(words[0], &words[1..])?)),
            op => {
                if op == Op::Undef {
                    self.frame().undefined.insert(instruction.result);
                }
                let copied = matches!(op, Op::CopyObject | Op::CopyLogical)
                    && matches!(self.frame().values.get(&words[0]), Some(Bound::Pointer(_)));
                if copied {
                    return self.bound(words[0]).map(Some);
                }
                let values = self.arithmetic(instruction)?;
                let values = values.ok_or_else(|| Error::unsupported(op as u32, &self.function_name()))?;
                Some(Bound::Values(values.into()))
            }
        })
    }
}
