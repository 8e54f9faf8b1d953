//! Calls: functions are put into their callers, or stay functions, or are written by hand.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use spirv::Op;

use super::{Bound, Frame, Lowering};
use crate::Options;
use crate::bits::Bits;
use crate::error::{Error, Result};
use crate::module::{Block, Function, Id, Module, Type};
use crate::program::{Buffer, Callee, Instruction, Node, Program, Register, Target, Value};

/// State that the entry points of a module share.
pub struct Shared<'m> {
    pub module: &'m Module,
    pub options: &'m Options,
    /// Buffers that they use.
    pub buffers: Vec<Buffer>,
    /// Functions that they call, those that others call first.
    pub called: Vec<Called>,
}

/// Function that stays one.
pub struct Called {
    id: Id,
    /// Name in C++.
    pub name: Rc<str>,
    pub program: Program,
}

impl<'m> Lowering<'m, '_> {
    /// Function that a call of `id` is of; `None` if the function is put here instead.
    fn callee(&mut self, id: Id, function: &'m Function) -> Result<Option<Callee>> {
        let (options, name) = (self.shared.options, self.module.name(id));
        if options.hooks.contains(&name) {
            return Ok(Some(Callee::Hook(name.into())));
        }
        if !options.calls.contains(&name) {
            return Ok(None);
        }
        if let Some(called) = self.shared.called.iter().find(|called| called.id == id) {
            return Ok(Some(Callee::Program(called.name.clone())));
        }
        let program = Lowering::function(self.shared, id, function)?;
        let name: Rc<str> = format!("{name}_{id}").into();
        self.shared.called.push(Called { id, name: name.clone(), program });
        Ok(Some(Callee::Program(name)))
    }

    /// Result of a call.
    pub fn call(&mut self, id: Id, arguments: &[Id]) -> Result<Rc<[Value]>> {
        let function = self.module.functions.get(&id).ok_or_else(|| Error::Missing(self.module.name(id)))?;
        let Some(callee) = self.callee(id, function)? else {
            let arguments = arguments.iter().map(|id| self.bound(*id)).collect::<Result<_>>()?;
            return self.inline(id, arguments);
        };
        let mut from = vec![];
        let mut written = vec![];
        for (i, id) in arguments.iter().enumerate() {
            match self.bound(*id)? {
                Bound::Values(values) => from.extend_from_slice(&values),
                Bound::Pointer(pointer) => {
                    from.extend_from_slice(&self.load(pointer)?);
                    if writes(self.module, function, i) {
                        written.push(pointer);
                    }
                }
            }
        }
        let registers = |this: &mut Self, kind| -> Result<Vec<Register>> {
            Ok(this.module.scalars(kind)?.iter().map(|kind| this.program.register(*kind)).collect())
        };
        let mut results = vec![registers(self, function.kind)?];
        for pointer in &written {
            results.push(registers(self, pointer.kind)?);
        }
        let to = results.iter().flatten().map(|register| Target::from(*register)).collect();
        self.push(Instruction::Call { callee, from, to });
        let values = |registers: &Vec<Register>| registers.iter().copied().map(Value::Register).collect::<Vec<_>>();
        for (pointer, registers) in written.into_iter().zip(&results[1..]) {
            self.store(pointer, &values(registers))?;
        }
        Ok(values(&results[0]).into())
    }

    /// Puts a call of a function here, and returns what it returns.
    pub fn inline(&mut self, id: Id, arguments: Vec<Bound>) -> Result<Rc<[Value]>> {
        let function = self.module.functions.get(&id).ok_or_else(|| Error::Missing(self.module.name(id)))?;
        if self.frames.iter().any(|frame| frame.function.id == id) {
            return Err(Error::Malformed(format!("{} calls itself", self.module.name(id))));
        }
        let returns = |block: &&Block| block.instructions.last().is_some_and(|last| last.op == Op::ReturnValue);
        let several = function.blocks.values().filter(returns).count() > 1;
        let kinds = self.module.scalars(function.kind)?;
        let result = several.then(|| kinds.iter().map(|kind| self.program.register(*kind)).collect());
        let end = self.program.label();
        let parameters = || function.parameters.iter();
        self.frames.push(Frame {
            function,
            values: parameters().map(|(id, _)| *id).zip(arguments).collect(),
            kinds: parameters().copied().collect(),
            undefined: HashSet::new(),
            ends: HashMap::new(),
            left: HashSet::new(),
            visited: HashSet::new(),
            end,
            result,
            returned: [].into(),
        });
        self.phis(function)?;
        let body = self.nested(|this| this.blocks(function.start))?;
        self.nodes.push(Node::Scope { label: end, body, outward: false, live: Bits::default() });
        let frame = self.frames.pop().expect("it was pushed");
        Ok(match frame.result {
            Some(registers) => registers.iter().map(|register| Value::Register(*register)).collect(),
            None => frame.returned,
        })
    }

    /// Program of the function `id`: its parameters are what the arguments hold or point to, its results what it returns
    /// and what it writes through pointers.
    fn function(shared: &mut Shared<'m>, id: Id, function: &'m Function) -> Result<Program> {
        let mut lowering = Lowering::new(shared);
        let module = lowering.module;
        let mut parameters = vec![];
        for (_, kind) in &function.parameters {
            let (pointee, is_pointer) = match *module.kind(*kind)? {
                Type::Pointer(_, pointee) => (pointee, true),
                _ => (*kind, false),
            };
            let kinds = module.scalars(pointee)?;
            let values = kinds.iter().map(|kind| Value::Register(lowering.program.register(*kind)));
            parameters.push((*kind, is_pointer, values.collect::<Rc<[Value]>>()));
        }
        lowering.program.parameters = lowering.program.registers.len() as u32;

        let mut arguments = vec![];
        let mut written = vec![];
        for (i, (kind, is_pointer, values)) in parameters.into_iter().enumerate() {
            if !is_pointer {
                arguments.push(Bound::Values(values));
                continue;
            }
            let local = lowering.local(kind)?;
            lowering.store(local, &values)?;
            arguments.push(Bound::Pointer(local));
            if writes(module, function, i) {
                written.push(local);
            }
        }
        let mut results = lowering.inline(id, arguments)?.to_vec();
        for local in written {
            results.extend_from_slice(&lowering.load(local)?);
        }
        lowering.program.results = results.iter().map(|value| lowering.program_kind(*value)).collect();
        lowering.push(Instruction::Return(results));
        Ok(lowering.finish())
    }
}

/// Whether a function may write what its parameter points to.
fn writes(module: &Module, function: &Function, parameter: usize) -> bool {
    let Some(&(id, kind)) = function.parameters.get(parameter) else { return false };
    if !matches!(module.types.get(&kind), Some(Type::Pointer(..))) {
        return false;
    }
    let instructions = || function.blocks.values().flat_map(|block| &block.instructions);
    let mut pointers = HashSet::from([id]);
    loop {
        let known = pointers.len();
        for instruction in instructions() {
            let derives = matches!(instruction.op, Op::AccessChain | Op::InBoundsAccessChain | Op::CopyObject);
            if derives && pointers.contains(&instruction.words[0]) {
                pointers.insert(instruction.result);
            }
        }
        if pointers.len() == known {
            break;
        }
    }
    instructions().any(|instruction| match instruction.op {
        Op::Store | Op::CopyMemory => pointers.contains(&instruction.words[0]),
        Op::FunctionCall => {
            let callee = module.functions.get(&instruction.words[0]);
            let passed = instruction.words[1..].iter().enumerate().filter(|(_, id)| pointers.contains(id));
            callee.is_none_or(|callee| passed.into_iter().any(|(i, _)| writes(module, callee, i)))
        }
        _ => false,
    })
}
