//! Random kernels: nested branches, loops and switches that invocations leave at different times.

use std::fmt::Write as _;

use super::assembly::{Given, Source, store};

/// Random numbers, the same in each run (xorshift).
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, limit: u32) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 33) % u64::from(limit)) as u32
    }

    pub fn word(&mut self) -> u32 {
        self.below(1 << 16) << 16 | self.below(1 << 16)
    }
}

const VARIABLES: u32 = 4;

/// Where a way may leave early.
#[derive(Clone, Default)]
struct Around {
    /// Blocks behind the loop or switch around here, and of the loop's next turn.
    leave: Option<String>,
    next: Option<String>,
    returns: bool,
}

struct Generator<'a> {
    random: &'a mut Random,
    text: String,
    names: u32,
    /// Variables, as operands.
    variables: Vec<String>,
    budget: u32,
}

/// Appends a random kernel.
pub fn kernel(source: &mut Source, name: &str, random: &mut Random) {
    let mut helper = Generator { random, text: String::new(), names: 0, variables: vec![], budget: 12 };
    helper.variables = vec!["%@helper_v".into(), "%@helper_p".into()];
    helper.list(2, &Around { returns: true, ..Around::default() });
    let result = helper.read();
    let functions = format!(
        "%@helper = OpFunction %uint None %helperType\n%@helper_a = OpFunctionParameter %uint\n\
         %@helper_p = OpFunctionParameter %local\n%@helper_l = OpLabel\n%@helper_v = OpVariable %local Function\n\
         %@array = OpVariable %localWords Function\nOpStore %@helper_v %@helper_a\n{}\
         OpReturnValue {result}\nOpFunctionEnd\n",
        initial_array("%@array") + &helper.text
    );
    let names = helper.names;
    let mut body = String::new();
    for v in 0..VARIABLES {
        let _ = writeln!(body, "%@v{v} = OpVariable %local Function");
    }
    body += "%@words = OpVariable %localWords Function\n%%%\n";
    for v in 0..VARIABLES {
        let _ = writeln!(body, "OpStore %@v{v} %@u{v}");
    }
    body += &initial_array("%@words");
    let variables = (0..VARIABLES).map(|v| format!("%@v{v}")).collect();
    let mut main = Generator { random, text: String::new(), names, variables, budget: 40 };
    main.list(4, &Around::default());
    body += &main.text;
    for v in 0..VARIABLES {
        let _ = writeln!(body, "%@end{v} = OpLoad %uint %@v{v}");
        body += &store(v as usize, &format!("%@end{v}"), "uint");
    }
    source.with_functions(name, Given::Words, &functions.replace("%@words", "%@array"), &body);
}

/// Fills an array: reading what was never written is undefined.
fn initial_array(array: &str) -> String {
    (0..8).fold(String::new(), |text, k| {
        let pointer = format!("{array}_{k}");
        text + &format!("{pointer} = OpAccessChain %local {array} %c{k}\nOpStore {pointer} %c{}\n", k * 5 + 1)
    })
}

impl Generator<'_> {
    fn name(&mut self) -> String {
        self.names += 1;
        format!("%@n{}", self.names)
    }

    fn line(&mut self, text: &str) {
        self.text += text;
        self.text.push('\n');
    }

    /// Appends an instruction with a result, and returns that.
    fn value(&mut self, instruction: &str) -> String {
        let name = self.name();
        self.line(&format!("{name} = {instruction}"));
        name
    }

    fn variable(&mut self) -> String {
        let count = self.variables.len() as u32;
        self.variables[self.random.below(count) as usize].clone()
    }

    fn read(&mut self) -> String {
        let variable = self.variable();
        self.value(&format!("OpLoad %uint {variable}"))
    }

    fn operand(&mut self) -> String {
        match self.random.below(4) {
            0 => format!("%c{}", self.random.below(64)),
            _ => self.read(),
        }
    }

    fn expression(&mut self) -> String {
        let (a, b) = (self.operand(), self.operand());
        let operations = ["OpIAdd", "OpISub", "OpIMul", "OpBitwiseXor", "OpBitwiseAnd", "OpBitwiseOr"];
        let operation = operations[self.random.below(6) as usize];
        self.value(&format!("{operation} %uint {a} {b}"))
    }

    /// A condition that is true of some invocations, or, more rarely, of all or none.
    fn condition(&mut self) -> String {
        let a = if self.random.below(6) == 0 { format!("%c{}", self.random.below(64)) } else { self.expression() };
        let bit = 1 << self.random.below(5);
        let masked = self.value(&format!("OpBitwiseAnd %uint {a} %c{bit}"));
        self.value(&format!("OpINotEqual %bool {masked} %c0"))
    }

    fn element(&mut self) -> String {
        let index = self.operand();
        let index = self.value(&format!("OpBitwiseAnd %uint {index} %c7"));
        self.value(&format!("OpAccessChain %local %@words {index}"))
    }

    /// Statements; false if none follows them.
    fn list(&mut self, depth: u32, around: &Around) -> bool {
        for _ in 0..1 + self.random.below(4) {
            if self.budget == 0 {
                break;
            }
            self.budget -= 1;
            if !self.statement(depth, around) {
                return false;
            }
        }
        true
    }

    fn statement(&mut self, depth: u32, around: &Around) -> bool {
        let is_main = self.variables.len() > 2;
        match self.random.below(if depth > 0 { 13 } else { 7 }) {
            0..=2 => {
                let (value, variable) = (self.expression(), self.variable());
                self.line(&format!("OpStore {variable} {value}"));
            }
            3 => {
                let (value, element) = (self.expression(), self.element());
                self.line(&format!("OpStore {element} {value}"));
            }
            4 => {
                let (element, variable) = (self.element(), self.variable());
                let value = self.value(&format!("OpLoad %uint {element}"));
                self.line(&format!("OpStore {variable} {value}"));
            }
            5 => {
                let function = if is_main && self.random.below(2) == 0 { "%@helper" } else { "%hook" };
                let (argument, pointer) = (self.operand(), self.variable());
                let result = self.value(&format!("OpFunctionCall %uint {function} {argument} {pointer}"));
                let variable = self.variable();
                self.line(&format!("OpStore {variable} {result}"));
            }
            6 => self.leave_early(around),
            7..=9 => self.branch(depth, around),
            10 | 11 => self.turns(depth, around),
            _ => self.switch(depth, around),
        }
        true
    }

    /// Some invocations leave the loop, go on to its next turn, or return.
    fn leave_early(&mut self, around: &Around) {
        let mut ways: Vec<String> = vec![];
        ways.extend(around.leave.iter().chain(&around.next).map(|block| format!("OpBranch {block}")));
        if around.returns {
            ways.push("OpReturnValue".into());
        }
        if ways.is_empty() {
            return;
        }
        let count = ways.len() as u32;
        let mut way = ways[self.random.below(count) as usize].clone();
        let condition = self.condition();
        let (leaves, stays) = (self.name(), self.name());
        self.line(&format!("OpSelectionMerge {stays} None\nOpBranchConditional {condition} {leaves} {stays}"));
        self.line(&format!("{leaves} = OpLabel"));
        let (value, variable) = (self.expression(), self.variable());
        self.line(&format!("OpStore {variable} {value}"));
        if way == "OpReturnValue" {
            way = format!("OpReturnValue {}", self.expression());
        }
        self.line(&format!("{way}\n{stays} = OpLabel"));
    }

    /// A branch whose ways come together in a phi.
    fn branch(&mut self, depth: u32, around: &Around) {
        let condition = self.condition();
        let (yes, no, end) = (self.name(), self.name(), self.name());
        self.line(&format!("OpSelectionMerge {end} None\nOpBranchConditional {condition} {yes} {no}"));
        let mut edges = vec![];
        for way in [yes, no] {
            self.line(&format!("{way} = OpLabel"));
            self.list(depth - 1, around);
            let (value, last) = (self.expression(), self.name());
            self.line(&format!("OpBranch {last}\n{last} = OpLabel\nOpBranch {end}"));
            edges.push(format!("{value} {last}"));
        }
        self.line(&format!("{end} = OpLabel"));
        let phi = self.value(&format!("OpPhi %uint {}", edges.join(" ")));
        let variable = self.variable();
        self.line(&format!("OpStore {variable} {phi}"));
    }

    /// A loop of at most seven turns, tested before or after each, that counts in phis.
    fn turns(&mut self, depth: u32, around: &Around) {
        let limit = if self.random.below(3) == 0 { "%c5".to_owned() } else { self.operand() };
        let limit = self.value(&format!("OpBitwiseAnd %uint {limit} %c7"));
        let tested_first = self.random.below(2) == 0;
        let [before, header, body, next, end] = [(); 5].map(|()| self.name());
        let [count, more, older, newer] = [(); 4].map(|()| self.name());
        let start = self.expression();
        self.line(&format!("OpBranch {before}\n{before} = OpLabel\nOpBranch {header}\n{header} = OpLabel"));
        self.line(&format!("{count} = OpPhi %uint %c0 {before} {more} {next}"));
        // Two phis that hand their values on.
        self.line(&format!("{older} = OpPhi %uint %c1 {before} {newer} {next}"));
        self.line(&format!("{newer} = OpPhi %uint {start} {before} {count} {next}"));
        self.line(&format!("OpLoopMerge {end} {next} None"));
        if tested_first {
            let inside = self.name();
            self.line(&format!("OpBranch {inside}\n{inside} = OpLabel"));
            let goes_on = self.value(&format!("OpULessThan %bool {count} {limit}"));
            self.line(&format!("OpBranchConditional {goes_on} {body} {end}"));
        } else {
            self.line(&format!("OpBranch {body}"));
        }
        self.line(&format!("{body} = OpLabel"));
        let variable = self.variable();
        let mixed = self.value(&format!("OpIAdd %uint {older} {newer}"));
        self.line(&format!("OpStore {variable} {mixed}"));
        let inner = Around { leave: Some(end.clone()), next: Some(next.clone()), returns: around.returns };
        self.list(depth - 1, &inner);
        self.line(&format!("OpBranch {next}\n{next} = OpLabel\n{more} = OpIAdd %uint {count} %c1"));
        if tested_first {
            self.line(&format!("OpBranch {header}"));
        } else {
            let goes_on = self.value(&format!("OpULessThan %bool {more} {limit}"));
            self.line(&format!("OpBranchConditional {goes_on} {header} {end}"));
        }
        self.line(&format!("{end} = OpLabel"));
        let (old, variable) = (self.value(&format!("OpIMul %uint {older} {count}")), self.variable());
        self.line(&format!("OpStore {variable} {old}"));
    }

    /// A switch with two literals for one case, one that falls into the next, and one that is the default or not.
    fn switch(&mut self, depth: u32, around: &Around) {
        let selector = self.operand();
        let selector = self.value(&format!("OpBitwiseAnd %uint {selector} %c3"));
        let [first, second, third, end] = [(); 4].map(|()| self.name());
        let default = if self.random.below(2) == 0 { third.clone() } else { end.clone() };
        self.line(&format!("OpSelectionMerge {end} None"));
        self.line(&format!("OpSwitch {selector} {default} 0 {first} 3 {first} 1 {second} 2 {third}"));
        let inner = Around { leave: Some(end.clone()), ..around.clone() };
        let falls = self.random.below(2) == 0;
        let nexts = [if falls { second.clone() } else { end.clone() }, end.clone(), end.clone()];
        for (case, next) in [first, second, third].into_iter().zip(nexts) {
            self.line(&format!("{case} = OpLabel"));
            self.list(depth - 1, &inner);
            self.line(&format!("OpBranch {next}"));
        }
        self.line(&format!("{end} = OpLabel"));
    }
}
