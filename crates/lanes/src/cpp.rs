//! Text of C++: lines in blocks, and the declarations of registers in the innermost block that has all their uses.

use std::fmt::Write as _;

use crate::program::{Held, Kind, Register};

/// Place of a block of C++ in [`Text`].
pub type Block = usize;

/// A line that may still be dropped.
#[derive(Clone, Copy, Debug)]
pub struct Line(Block, usize);

#[derive(Debug)]
enum Item {
    Line(String),
    /// What stands before the braces, and the block in them.
    Block(String, Block),
    Dropped,
}

#[derive(Debug, Default)]
struct Contents {
    parent: Option<Block>,
    depth: usize,
    declarations: Vec<String>,
    items: Vec<Item>,
}

/// What is known of a register's place in the text.
#[derive(Clone, Debug, Default)]
struct Known {
    /// Innermost block with all that mentions it.
    around: Option<Block>,
    assignments: u32,
    /// Where it can be declared: the line of its only assignment.
    line: Option<Line>,
    /// Whether it is mentioned before it is assigned.
    early: bool,
}

/// The body of a function.
#[derive(Debug)]
pub struct Text {
    blocks: Vec<Contents>,
    registers: Vec<Known>,
}

impl Text {
    pub const BODY: Block = 0;

    pub fn new(registers: usize) -> Self {
        Self { blocks: vec![Contents::default()], registers: vec![Known::default(); registers] }
    }

    /// Appends a line.
    pub fn line(&mut self, block: Block, text: impl Into<String>) -> Line {
        self.blocks[block].items.push(Item::Line(text.into()));
        Line(block, self.blocks[block].items.len() - 1)
    }

    pub fn drop(&mut self, line: Line) {
        self.blocks[line.0].items[line.1] = Item::Dropped;
    }

    /// Appends a block with `head` before its braces.
    pub fn block(&mut self, parent: Block, head: impl Into<String>) -> Block {
        let depth = self.blocks[parent].depth + 1;
        self.blocks.push(Contents { parent: Some(parent), depth, ..Contents::default() });
        let block = self.blocks.len() - 1;
        self.blocks[parent].items.push(Item::Block(head.into(), block));
        block
    }

    /// Appends the assignment of a register; `line` may be preceded by its declaration.
    pub fn assignment(&mut self, block: Block, register: Register, line: String) {
        let line = self.line(block, line);
        self.assigned(block, register, Some(line));
    }

    /// Notes that a register is assigned in `block`, by a line that may declare it if one is given.
    pub fn assigned(&mut self, block: Block, register: Register, line: Option<Line>) {
        self.mention(block, register);
        let known = &mut self.registers[register as usize];
        known.assignments += 1;
        known.line = line;
    }

    /// Notes that a register is read in `block`.
    pub fn read(&mut self, block: Block, register: Register) {
        self.mention(block, register);
        let known = &mut self.registers[register as usize];
        known.early |= known.assignments == 0;
    }

    /// Notes that a register must be declared in `block` or around it.
    pub fn mention(&mut self, block: Block, register: Register) {
        let around = self.registers[register as usize].around;
        let common = around.map_or(block, |around| self.common(around, block));
        self.registers[register as usize].around = Some(common);
    }

    /// Innermost block around both.
    fn common(&self, mut a: Block, mut b: Block) -> Block {
        while a != b {
            let outer = if self.blocks[a].depth >= self.blocks[b].depth { &mut a } else { &mut b };
            *outer = self.blocks[*outer].parent.unwrap_or(Self::BODY);
        }
        a
    }

    /// Declares all registers but the first `parameters`, which are the function's. They begin with zeros: a lane that is
    /// not active may compute with what was never assigned, and C++ lets a compiler assume that nobody does.
    pub fn declare(&mut self, registers: &[Held], parameters: usize, varies: impl Fn(Register) -> bool) {
        for (register, held) in registers.iter().enumerate().skip(parameters) {
            let known = self.registers[register].clone();
            let Some(around) = known.around else { continue };
            let kind = match (held.kind, varies(register as Register)) {
                (_, _) if held.length > 0 => {
                    self.blocks[around].declarations.push(format!("Float v{register}[{}];", held.length));
                    continue;
                }
                (Kind::Float, true) => "Float",
                (Kind::Uint, true) => "Uint",
                (Kind::Bool, true) => "Mask",
                (Kind::Float, false) => "float",
                (Kind::Uint, false) => "uint32_t",
                (Kind::Bool, false) => "bool",
            };
            match known.line {
                Some(Line(block, place)) if block == around && known.assignments == 1 && !known.early => {
                    if let Item::Line(text) = &mut self.blocks[block].items[place] {
                        *text = format!("const {kind} {text}");
                    }
                }
                _ => self.blocks[around].declarations.push(format!("{kind} v{register} = {{}};")),
            }
        }
    }

    /// Writes all of it.
    pub fn write(&self, to: &mut String) {
        self.write_block(Self::BODY, to);
    }

    fn write_block(&self, block: Block, to: &mut String) {
        let contents = &self.blocks[block];
        let indent = " ".repeat(contents.depth.min(20) + 1);
        for line in &contents.declarations {
            let _ = writeln!(to, "{indent}{line}");
        }
        for item in &contents.items {
            match item {
                Item::Line(line) => _ = writeln!(to, "{indent}{line}"),
                Item::Block(head, block) => {
                    let _ = writeln!(to, "{indent}{head} {{");
                    self.write_block(*block, to);
                    let _ = writeln!(to, "{indent}}}");
                }
                Item::Dropped => {}
            }
        }
    }
}
