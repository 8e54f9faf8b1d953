//! From a [`Program`] to C++.
//!
//! Each piece of control flow has a mask of the lanes that are active in it. The two ways of a branch have the mask of those
//! that go there, tested with `any` before anything costly. Lanes that leave a scope are added to the mask of its end, and
//! what follows in between belongs to those that stay; where lanes can only have come to the end of a scope, all that entered
//! it are there again, and no mask is kept at all.

use std::fmt::Write as _;

use crate::analysis::Analysis;
use crate::cpp::{Block, Line, Text};
use crate::program::{
    Buffer, Callee, Index, Instruction, Kept, Kind, Label, Memory, Node, Operation, Place, Program, Register, Target,
    Value,
};

/// Operations that are quicker done than asked whether any lane needs them.
const SMALL: usize = 10;

/// C++ of one program.
pub struct Emitter<'a> {
    program: &'a Program,
    analysis: &'a Analysis,
    buffers: &'a [Buffer],
    text: Text,
    /// Masks of lanes at the ends of scopes, and the lines that fill them.
    ends: Vec<Option<(String, Vec<Line>)>>,
    names: u32,
    /// Mask of the lanes that go this way at the innermost branch where lanes part, among all lanes, active or not; and
    /// whether anything has needed it.
    way: (String, bool),
}

/// Where the text goes on, and the mask of the lanes there; `None` where there are none.
type Way = Option<(Block, String)>;

/// Body of the function that `program` is.
pub fn function(name: &str, program: &Program, analysis: &Analysis, buffers: &[Buffer]) -> String {
    let text = Text::new(program.registers.len());
    let ends = vec![None; program.labels as usize];
    let way = (String::new(), false);
    let mut emitter = Emitter { program, analysis, buffers, text, ends, names: 0, way };
    emitter.list(&program.body, Text::BODY, "mask".into());
    emitter.text.declare(&program.registers, program.parameters as usize, |register| {
        analysis.varies(Value::Register(register))
    });
    let mut body = String::new();
    emitter.text.write(&mut body);
    // Nothing that the function stores changes the context: pointers in it need not be read again.
    let mut parameters = String::new();
    for (register, held) in (0..program.parameters).zip(&program.registers) {
        let _ = write!(parameters, ", {} v{register}", vector_type(held.kind));
    }
    for (i, kind) in program.results.iter().enumerate() {
        let _ = write!(parameters, ", {}& r{i}", vector_type(*kind));
    }
    let apart = if program.is_entry_point { "" } else { "__attribute__((noinline)) " };
    format!(
        "template <class Context>\n\
         {apart}static void {name}(const Context& __restrict context, Mask mask{parameters}) {{\n \
         (void)context, (void)mask;\n{body}}}\n"
    )
}

/// Type of a vector of what a register holds.
fn vector_type(kind: Kind) -> &'static str {
    match kind {
        Kind::Float => "Float",
        Kind::Uint => "Uint",
        Kind::Bool => "Mask",
    }
}

impl Emitter<'_> {
    fn name(&mut self, prefix: &str) -> String {
        self.names += 1;
        format!("{prefix}{}", self.names)
    }

    /// All of a list.
    fn list(&mut self, nodes: &[Node], mut block: Block, mut mask: String) -> Way {
        for node in nodes {
            let way = match node {
                Node::Run(run) => {
                    run.iter().for_each(|instruction| self.instruction(instruction, block, &mask));
                    continue;
                }
                Node::If { condition, yes, no, .. } => self.branch(*condition, yes, no, block, mask),
                Node::Switch { selector, cases, default } => {
                    self.switch(*selector, cases, *default, block, &mask);
                    None
                }
                Node::Exit(label) => {
                    self.exit(*label, block, &mask, None);
                    None
                }
                Node::Scope { label, body, outward, .. } => self.scope(*label, body, *outward, block, mask),
                Node::Loop { body, live } => {
                    // What a turn leaves for the next is declared around the loop.
                    let registers = self.analysis.registers(live);
                    registers.for_each(|register| self.text.mention(block, register));
                    self.turns(body, block, &mask);
                    None
                }
            };
            (block, mask) = way?;
        }
        Some((block, mask))
    }

    /// Adds `mask`, as far as `condition` is true, to the lanes at the end of a scope.
    fn exit(&mut self, label: Label, block: Block, mask: &str, condition: Option<&str>) {
        let Some((end, lines)) = &mut self.ends[label as usize] else { return };
        let mask = condition.map_or(mask.to_owned(), |condition| format!("({mask} & {condition})"));
        let line = self.text.line(block, format!("{end} = {end} | {mask};"));
        lines.push(line);
    }

    fn scope(&mut self, label: Label, body: &[Node], outward: bool, block: Block, mask: String) -> Way {
        let end = self.name("m");
        let declaration = self.text.line(block, format!("Mask {end} = NONE;"));
        self.ends[label as usize] = Some((end.clone(), vec![]));
        let fallen = self.list(body, block, mask.clone());
        let lines = self.ends[label as usize].take().map(|(_, lines)| lines).unwrap_or_default();
        if !outward {
            // All come here.
            lines.into_iter().chain([declaration]).for_each(|line| self.text.drop(line));
            return Some((block, mask));
        }
        if let Some((last, mask)) = fallen {
            self.text.line(last, format!("{end} = {end} | {mask};"));
        }
        Some((self.text.block(block, format!("if (any({end}))")), end))
    }

    fn turns(&mut self, body: &[Node], block: Block, mask: &str) {
        let (active, next) = (self.name("m"), self.name("m"));
        self.text.line(block, format!("Mask {active} = {mask};"));
        let turn = self.text.block(block, "for (;;)");
        let declaration = self.text.line(turn, format!("Mask {next} = NONE;"));
        match self.list(body, turn, active.clone()) {
            Some((last, mask)) if last == turn => {
                self.text.drop(declaration);
                self.text.line(turn, format!("{active} = {mask};"));
                self.text.line(turn, format!("if (!any({active})) break;"));
            }
            Some((last, mask)) => {
                self.text.line(last, format!("{next} = {mask};"));
                self.text.line(turn, format!("{active} = {next};"));
                self.text.line(turn, format!("if (!any({active})) break;"));
            }
            None => {
                self.text.drop(declaration);
                self.text.line(turn, "break;");
            }
        }
    }

    fn branch(&mut self, condition: Value, yes: &[Node], no: &[Node], block: Block, mask: String) -> Way {
        let together = self.name("m");
        let declaration = self.text.line(block, format!("Mask {together} = NONE;"));
        let varies = self.analysis.varies(condition);
        // Among all lanes: the ways may change what the condition is read from.
        let mut all = [None, None];
        let masks = if varies {
            let condition = self.vector(condition, block);
            for (way, text) in all.iter_mut().zip([condition.clone(), format!("inverse({condition})")]) {
                let name = self.name("c");
                let line = self.text.line(block, format!("const Mask {name} = {text};"));
                *way = Some((name, line));
            }
            let masks = [self.name("m"), self.name("m")];
            self.text.line(block, format!("const Mask {} = {mask} & {condition};", masks[0]));
            self.text.line(block, format!("const Mask {} = without({mask}, {condition});", masks[1]));
            masks
        } else {
            [mask.clone(), mask.clone()]
        };
        // Lanes of the second way alone go on where those of the first have all left.
        let leaves = !crate::simplify::falls(yes);
        let (mut ways, mut starts) = (vec![], vec![]);
        for (i, nodes) in [yes, no].into_iter().enumerate() {
            let goes_on = i == 1 && leaves;
            let inner = if !varies {
                if nodes.is_empty() && !goes_on {
                    ways.push(Some((block, masks[i].clone())));
                    starts.push(block);
                    continue;
                }
                let head = if i == 0 { format!("if ({})", self.scalar(condition, block)) } else { "else".into() };
                self.text.block(block, head)
            } else if is_small(nodes) && !goes_on {
                block
            } else {
                self.text.block(block, format!("if (any({}))", masks[i]))
            };
            starts.push(inner);
            let Some((name, line)) = all[i].take() else {
                ways.push(self.list(nodes, inner, masks[i].clone()));
                continue;
            };
            let around = std::mem::replace(&mut self.way, (name, false));
            ways.push(self.list(nodes, inner, masks[i].clone()));
            if !std::mem::replace(&mut self.way, around).1 {
                self.text.drop(line);
            }
        }
        // Lanes that leave where none parts from the others change no mask, but the block in which the rest goes on.
        let stay = |way: &Way, start: Block, mask: &str| {
            way.as_ref().is_some_and(|(end, at_end)| *end == start && at_end == mask)
        };
        if (0..2).all(|i| stay(&ways[i], starts[i], &masks[i])) {
            self.text.drop(declaration);
            return Some((block, mask));
        }
        let mut ways: Vec<_> = ways.into_iter().flatten().collect();
        if ways.len() < 2 {
            self.text.drop(declaration);
            return ways.pop();
        }
        for (last, mask) in ways {
            self.text.line(last, format!("{together} = {together} | {mask};"));
        }
        Some((self.text.block(block, format!("if (any({together}))")), together))
    }

    fn switch(&mut self, selector: Value, cases: &[(Vec<u32>, Label)], default: Label, block: Block, mask: &str) {
        let varies = self.analysis.varies(selector);
        let selector = self.any(selector, block, varies);
        let is = |literal: &u32| {
            if varies { format!("equal({selector}, splat({literal}u))") } else { format!("{selector} == {literal}u") }
        };
        let among =
            |literals: &[u32]| literals.iter().map(is).collect::<Vec<_>>().join(if varies { " | " } else { " || " });
        if !varies {
            let mut otherwise = "";
            for (literals, label) in cases {
                let case = self.text.block(block, format!("{otherwise}if ({})", among(literals)));
                self.exit(*label, case, mask, None);
                otherwise = "else ";
            }
            let last = if cases.is_empty() { block } else { self.text.block(block, "else") };
            self.exit(default, last, mask, None);
            return;
        }
        let mut matches = vec![];
        for (literals, label) in cases {
            let name = self.name("m");
            self.text.line(block, format!("const Mask {name} = {};", among(literals)));
            self.exit(*label, block, mask, Some(&name));
            matches.push(name);
        }
        let others =
            if matches.is_empty() { mask.to_owned() } else { format!("without({mask}, {})", matches.join(" | ")) };
        self.exit(default, block, &others, None);
    }

    /// Text of a value in which all lanes are equal.
    fn scalar(&mut self, value: Value, block: Block) -> String {
        match value {
            Value::Register(register) => {
                self.text.read(block, register);
                format!("v{register}")
            }
            Value::Constant(Kind::Bool, bits) => (bits != 0).to_string(),
            Value::Constant(Kind::Uint, bits) => format!("{bits}u"),
            Value::Constant(Kind::Float, bits) => {
                let number = f32::from_bits(bits);
                if number.is_finite() { format!("{number:?}f") } else { format!("number({bits:#x}u)") }
            }
        }
    }

    /// Text of a value as a vector of lanes.
    fn vector(&mut self, value: Value, block: Block) -> String {
        let text = self.scalar(value, block);
        if self.analysis.varies(value) { text } else { format!("splat({text})") }
    }

    fn any(&mut self, value: Value, block: Block, varies: bool) -> String {
        if varies { self.vector(value, block) } else { self.scalar(value, block) }
    }

    /// Mask of an assignment where `mask` is that of active lanes.
    fn mask_of(&mut self, kept: Kept, mask: &str) -> Option<String> {
        match kept {
            Kept::Nowhere => None,
            Kept::TheOtherWay => {
                self.way.1 = true;
                Some(self.way.0.clone())
            }
            Kept::Everywhere => Some(mask.into()),
        }
    }

    fn assign(&mut self, to: Target, value: &str, block: Block, mask: &str) {
        let register = to.register;
        let value = match self.mask_of(to.kept, mask) {
            Some(mask) => {
                self.text.read(block, register);
                format!("choose({mask}, {value}, v{register})")
            }
            None => value.into(),
        };
        self.text.assignment(block, register, format!("v{register} = {value};"));
    }

    fn instruction(&mut self, instruction: &Instruction, block: Block, mask: &str) {
        match instruction {
            Instruction::Compute { operation, to, from } => self.compute(*operation, *to, from, block, mask),
            Instruction::Load { memory: Memory::Columns(buffer), to, index } => {
                let buffer = &self.buffers[*buffer].name;
                for (target, offset) in to {
                    let column = self.column(*offset, index.as_ref(), block);
                    let value = match index {
                        Some(index) if self.analysis.varies(index.value) => {
                            format!("own_words(context.{buffer}, {mask}, {column})")
                        }
                        _ => format!("column(context.{buffer}, {column})"),
                    };
                    let value = self.converted(target.register, &value);
                    self.assign(*target, &value, block, mask);
                }
            }
            Instruction::Load { memory, to, index } => self.load(*memory, to, index.as_ref(), block, mask),
            Instruction::Store { memory: Memory::Columns(buffer), from, index } => {
                for (value, offset) in from {
                    let (column, value) = (self.column(*offset, index.as_ref(), block), self.vector(*value, block));
                    let buffer = &self.buffers[*buffer].name;
                    let varies = index.as_ref().is_some_and(|index| self.analysis.varies(index.value));
                    let function = if varies { "set_own_words" } else { "set_column" };
                    let line = format!("{function}(context.{buffer}, {mask}, {column}, as_float({value}));");
                    self.text.line(block, line);
                }
            }
            Instruction::Store { memory, from, index } => {
                let pointer = self.pointer(*memory);
                let (place, stride) = match index {
                    Some(index) => (self.vector(index.value, block), index.stride),
                    None => ("splat(0u)".into(), 0),
                };
                for (value, offset) in from {
                    let value = self.vector(*value, block);
                    let line = format!("scatter({pointer}, {mask}, {place}, {stride}, {offset}, as_float({value}));");
                    self.text.line(block, line);
                }
            }
            Instruction::Read { to, place } => {
                let value = self.element(place, block, mask);
                let value = self.converted(to.register, &value);
                self.assign(*to, &value, block, mask);
            }
            Instruction::Write { from, place, kept } => {
                let value = self.vector(*from, block);
                let array = format!("v{}", place.variable);
                let word = place.word;
                self.text.assigned(block, place.variable, None);
                let line = match &place.index {
                    Some(index) if self.analysis.varies(index.value) => {
                        let (place, stride) = (self.vector(index.value, block), index.stride);
                        format!("set_own_word({array}, {mask}, {place}, {stride}, {word}, as_float({value}));")
                    }
                    index => {
                        let word = self.word(word, index.as_ref(), block);
                        match self.mask_of(*kept, mask) {
                            Some(mask) => format!("set_own_word({array}, {mask}, {word}, as_float({value}));"),
                            None => format!("{array}[{word}] = as_float({value});"),
                        }
                    }
                };
                self.text.line(block, line);
            }
            Instruction::Begin(_) => {}
            Instruction::Return(from) => {
                for (i, value) in from.iter().enumerate() {
                    let value = self.vector(*value, block);
                    self.text.line(block, format!("r{i} = {value};"));
                }
            }
            Instruction::Call { callee, from, to } => {
                let (function, mut arguments) = match callee {
                    Callee::Hook(name) => (format!("context.{name}"), vec![mask.to_owned()]),
                    Callee::Program(name) => (name.to_string(), vec!["context".into(), mask.to_owned()]),
                };
                arguments.extend(from.iter().map(|value| self.vector(*value, block)));
                let results = self.results(to.iter().copied(), block);
                arguments.extend(results.iter().map(|(_, name)| name.clone()));
                self.text.line(block, format!("{function}({});", arguments.join(", ")));
                self.settle(&results, block, mask);
            }
        }
    }

    /// Variables to which a statement can assign `targets`: temporary ones where lanes are masked.
    fn results(&mut self, targets: impl Iterator<Item = Target>, block: Block) -> Vec<(Target, String)> {
        let mut results = vec![];
        for target in targets {
            let apart = target.kept != Kept::Nowhere;
            let name = if apart { self.name("t") } else { format!("v{}", target.register) };
            if apart {
                let kind = self.vector_type(target.register);
                self.text.line(block, format!("{kind} {name};"));
            } else {
                self.text.assigned(block, target.register, None);
            }
            results.push((target, name));
        }
        results
    }

    /// Assigns what has been kept in temporary variables.
    fn settle(&mut self, results: &[(Target, String)], block: Block, mask: &str) {
        for (target, name) in results.iter().filter(|(target, _)| target.kept != Kept::Nowhere) {
            self.assign(*target, name, block, mask);
        }
    }

    fn vector_type(&self, register: Register) -> &'static str {
        vector_type(self.program.registers[register as usize].kind)
    }

    /// `value`, a vector of words, as what a register holds.
    fn converted(&self, register: Register, value: &str) -> String {
        match self.program.registers[register as usize].kind {
            Kind::Float => value.into(),
            Kind::Uint => format!("as_uint({value})"),
            Kind::Bool => format!("as_mask({value})"),
        }
    }

    fn compute(&mut self, operation: Operation, to: Target, from: &[Value], block: Block, mask: &str) {
        let varies = self.analysis.varies(Value::Register(to.register));
        let text = match operation {
            // All lanes choose alike.
            Operation::Call("choose") if varies && !self.analysis.varies(from[0]) => {
                let condition = self.scalar(from[0], block);
                let (yes, no) = (self.vector(from[1], block), self.vector(from[2], block));
                format!("{condition} ? {yes} : {no}")
            }
            _ => {
                let from: Vec<_> = from.iter().map(|value| self.any(*value, block, varies)).collect();
                match operation {
                    Operation::Copy => from[0].clone(),
                    Operation::Infix(operator) => format!("{} {operator} {}", from[0], from[1]),
                    Operation::Call(function) => format!("{function}({})", from.join(", ")),
                }
            }
        };
        self.assign(to, &text, block, mask);
    }

    /// Number of a column, by the place of its word in an element.
    fn column(&mut self, offset: u32, index: Option<&Index>, block: Block) -> String {
        let column = offset / 4;
        match index {
            Some(index) if self.analysis.varies(index.value) => {
                format!("{}, {}, {column}", self.vector(index.value, block), index.stride / 4)
            }
            Some(index) => format!("{column} + {} * {}", self.scalar(index.value, block), index.stride / 4),
            None => column.to_string(),
        }
    }

    fn word(&mut self, word: u32, index: Option<&Index>, block: Block) -> String {
        match index {
            Some(index) => format!("{word} + {} * {}", self.scalar(index.value, block), index.stride),
            None => word.to_string(),
        }
    }

    /// Element of an array, as a vector of words.
    fn element(&mut self, place: &Place, block: Block, mask: &str) -> String {
        self.text.read(block, place.variable);
        let (array, word) = (format!("v{}", place.variable), place.word);
        match &place.index {
            Some(index) if self.analysis.varies(index.value) => {
                let (place, stride) = (self.vector(index.value, block), index.stride);
                format!("own_word({array}, {mask}, {place}, {stride}, {word})")
            }
            index => format!("own_word({array}, {})", self.word(word, index.as_ref(), block)),
        }
    }

    fn pointer(&self, memory: Memory) -> String {
        match memory {
            Memory::Buffer(buffer) | Memory::Columns(buffer) => {
                format!("context.buffers.{}", self.buffers[buffer].name)
            }
            Memory::Work => "context.work".into(),
        }
    }

    /// Words from an element of a buffer: in scalars where all lanes want the same, else in rows of 16 bytes.
    fn load(&mut self, memory: Memory, to: &[(Target, u32)], index: Option<&Index>, block: Block, mask: &str) {
        let pointer = self.pointer(memory);
        let scalar = |this: &Self, register: Register, at: &str, offset: u32| {
            let kind = match this.program.registers[register as usize].kind {
                Kind::Float => "float",
                _ => "uint32_t",
            };
            format!("word<{kind}>({at}, {offset})")
        };
        let Some(index) = index.filter(|index| self.analysis.varies(index.value)) else {
            let at = match index {
                Some(index) => {
                    format!("{pointer} + size_t({}) * {}", self.scalar(index.value, block), index.stride)
                }
                None => pointer,
            };
            for (target, offset) in to {
                let value = scalar(self, target.register, &at, *offset);
                let varies = self.analysis.varies(Value::Register(target.register));
                self.assign(*target, &if varies { format!("splat({value})") } else { value }, block, mask);
            }
            return;
        };
        let (place, stride) = (self.name("i"), index.stride);
        let value = self.vector(index.value, block);
        self.text.line(block, format!("const Uint {place} = settled({mask}, {value});"));
        let results = self.results(to.iter().map(|(target, _)| *target), block);
        let same = self.text.block(block, format!("if (same({place}))"));
        self.text.line(same, format!("const char* const at = {pointer} + size_t(first({place})) * {stride};"));
        for ((target, name), (_, offset)) in results.iter().zip(to) {
            let value = scalar(self, target.register, "at", *offset);
            self.text.line(same, format!("{name} = splat({value});"));
        }
        let apart = self.text.block(block, "else");
        let mut words: Vec<_> =
            results.iter().zip(to).map(|((target, name), (_, offset))| (*offset, target, name)).collect();
        words.sort_unstable_by_key(|(offset, ..)| *offset);
        let mut words = &words[..];
        while let Some((start, target, name)) = words.first() {
            let count = words.iter().take_while(|(offset, ..)| *offset < start + 16).count();
            if count < 2 || stride < 16 {
                let value = format!("gather({pointer}, {place}, {stride}, {start})");
                let value = self.converted(target.register, &value);
                self.text.line(apart, format!("{name} = {value};"));
                words = &words[1..];
                continue;
            }
            // Rows stay in their element: what is behind the last may not be readable.
            let start = *start.min(&(index.range.0 + stride - 16));
            let row = self.name("r");
            self.text.line(apart, format!("Float {row}[4];"));
            self.text.line(apart, format!("rows({pointer}, {place}, {stride}, {start}, {row});"));
            for (offset, target, name) in &words[..count] {
                let value = self.converted(target.register, &format!("{row}[{}]", (offset - start) / 4));
                self.text.line(apart, format!("{name} = {value};"));
            }
            words = &words[count..];
        }
        self.settle(&results, block, mask);
    }
}

/// Whether a list is short, reads and writes no memory, and calls nothing.
fn is_small(nodes: &[Node]) -> bool {
    let mut cost = 0;
    nodes.iter().all(|node| match node {
        Node::Exit(_) => true,
        Node::Run(run) => run.iter().all(|instruction| {
            cost += match instruction {
                Instruction::Compute { operation: Operation::Copy, .. } => 0,
                Instruction::Compute { operation: Operation::Infix("/"), .. } => 6,
                Instruction::Compute { operation: Operation::Call(function), .. } => match *function {
                    "square_root" => 8,
                    "reverse_bits" => 6,
                    "from_unsigned" | "to_unsigned" => 3,
                    name if name.starts_with("c_") => SMALL + 1,
                    name if name.starts_with("quotient") || name.starts_with("remainder") => SMALL + 1,
                    _ => 1,
                },
                Instruction::Compute { .. } => 1,
                Instruction::Begin(_) => 0,
                _ => SMALL + 1,
            };
            cost <= SMALL
        }),
        _ => false,
    })
}
