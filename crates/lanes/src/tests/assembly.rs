//! SPIR-V of many small kernels, as text.

use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

/// Words that an invocation reads and writes.
pub const WORDS: usize = 8;

/// Numbers that a kernel is given.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Given {
    /// Any bits.
    Words,
    /// Floats of all kinds: ordinary ones, small whole numbers, zeros, infinities, NaN, subnormal ones.
    Floats,
    /// Floats that fit into an integer.
    Moderate,
}

/// A kernel of the module.
pub struct Kernel {
    pub name: String,
    pub given: Given,
}

/// A module of kernels that each read eight words of their own from `input` and write eight to `output`.
#[derive(Default)]
pub struct Source {
    pub kernels: Vec<Kernel>,
    helpers: Vec<String>,
    text: String,
}

/// Types, constants and buffers.
const DECLARATIONS: &str = "
%void = OpTypeVoid
%bool = OpTypeBool
%uint = OpTypeInt 32 0
%int = OpTypeInt 32 1
%float = OpTypeFloat 32
%v2bool = OpTypeVector %bool 2
%v2float = OpTypeVector %float 2
%v3float = OpTypeVector %float 3
%v4float = OpTypeVector %float 4
%v2uint = OpTypeVector %uint 2
%v3uint = OpTypeVector %uint 3
%v4uint = OpTypeVector %uint 4
%m32 = OpTypeMatrix %v3float 2
%v3int = OpTypeVector %int 3
%fn = OpTypeFunction %void
%true = OpConstantTrue %bool
%false = OpConstantFalse %bool
%two = OpConstant %float 2
%half = OpConstant %float 0.5
%switched = OpSpecConstant %uint 0
%isOn = OpSpecConstantOp %bool INotEqual %switched %c0
%words = OpTypeArray %uint %c8
%list = OpTypeRuntimeArray %words
%buffer = OpTypeStruct %list
%toBuffer = OpTypePointer StorageBuffer %buffer
%toWord = OpTypePointer StorageBuffer %uint
%input = OpVariable %toBuffer StorageBuffer
%output = OpVariable %toBuffer StorageBuffer
%item = OpTypeStruct %uint %v3float %m32 %words
%items = OpTypeRuntimeArray %item
%table = OpTypeStruct %items
%toTable = OpTypePointer StorageBuffer %table
%toItem = OpTypePointer StorageBuffer %item
%toVector = OpTypePointer StorageBuffer %v3float
%toMatrix = OpTypePointer StorageBuffer %m32
%toFloat = OpTypePointer StorageBuffer %float
%items_ = OpVariable %toTable StorageBuffer
%state = OpTypeStruct %uint %v2float %words
%stateList = OpTypeRuntimeArray %state
%states_ = OpTypeStruct %stateList
%toStates = OpTypePointer StorageBuffer %states_
%toPair = OpTypePointer StorageBuffer %v2float
%states = OpVariable %toStates StorageBuffer
%toPlace = OpTypePointer Input %v3uint
%place = OpVariable %toPlace Input
%local = OpTypePointer Function %uint
%localFloat = OpTypePointer Function %float
%localWords = OpTypePointer Function %words
%pair = OpTypeStruct %uint %words
%localPair = OpTypePointer Function %pair
%helperType = OpTypeFunction %uint %uint %local
%hook = OpFunction %uint DontInline %helperType
%hook_a = OpFunctionParameter %uint
%hook_p = OpFunctionParameter %local
%hook_l = OpLabel
%hook_v = OpLoad %uint %hook_p
%hook_x = OpBitwiseXor %uint %hook_v %hook_a
OpStore %hook_p %hook_x
%hook_m = OpIMul %uint %hook_a %c3
%hook_r = OpIAdd %uint %hook_m %hook_v
OpReturnValue %hook_r
OpFunctionEnd
";

const DECORATIONS: &str = "
OpDecorate %place BuiltIn GlobalInvocationId
OpDecorate %switched SpecId 7
OpDecorate %words ArrayStride 4
OpDecorate %list ArrayStride 32
OpDecorate %buffer Block
OpMemberDecorate %buffer 0 Offset 0
OpDecorate %input DescriptorSet 0
OpDecorate %input Binding 0
OpDecorate %input NonWritable
OpDecorate %output DescriptorSet 0
OpDecorate %output Binding 1
OpMemberDecorate %item 0 Offset 0
OpMemberDecorate %item 1 Offset 4
OpMemberDecorate %item 2 Offset 16
OpMemberDecorate %item 2 ColMajor
OpMemberDecorate %item 2 MatrixStride 12
OpMemberDecorate %item 3 Offset 40
OpDecorate %items ArrayStride 72
OpDecorate %table Block
OpMemberDecorate %table 0 Offset 0
OpDecorate %items_ DescriptorSet 0
OpDecorate %items_ Binding 2
OpDecorate %items_ NonWritable
OpMemberDecorate %state 0 Offset 0
OpMemberDecorate %state 1 Offset 4
OpMemberDecorate %state 2 Offset 12
OpDecorate %stateList ArrayStride 44
OpDecorate %states_ Block
OpMemberDecorate %states_ 0 Offset 0
OpDecorate %states DescriptorSet 0
OpDecorate %states Binding 3
";

impl Source {
    /// Appends a kernel. In `body`, `@` stands for a prefix of names that is the kernel's own; `%@i` is the invocation's
    /// place, and `%@u0`, `%@f0` and `%@b0` its first word as an integer, a float and a bool, and so on.
    pub fn kernel(&mut self, name: &str, given: Given, body: &str) {
        self.with_functions(name, given, "", body);
    }

    /// Appends a kernel after `functions`, which are its own, `%@helper` among them.
    pub fn with_functions(&mut self, name: &str, given: Given, functions: &str, body: &str) {
        if !functions.is_empty() {
            self.helpers.push(format!("{name}_helper"));
        }
        let mut text = format!("{functions}\n%@ = OpFunction %void None %fn\n%@start = OpLabel\n");
        let (variables, body) = body.split_once("%%%").unwrap_or(("", body));
        text += variables;
        text += "\n%@place = OpLoad %v3uint %place\n%@i = OpCompositeExtract %uint %@place 0\n";
        for k in 0..WORDS {
            let _ = write!(
                text,
                "%@in{k} = OpAccessChain %toWord %input %c0 %@i %c{k}\n%@u{k} = OpLoad %uint %@in{k}\n\
                 %@f{k} = OpBitcast %float %@u{k}\n%@low{k} = OpBitwiseAnd %uint %@u{k} %c1\n\
                 %@b{k} = OpINotEqual %bool %@low{k} %c0\n"
            );
        }
        text += body;
        text += "\nOpReturn\nOpFunctionEnd\n";
        self.text += &text.replace('@', &format!("{name}_"));
        self.kernels.push(Kernel { name: format!("{name}_"), given });
    }

    /// The whole module.
    pub fn text(&self) -> String {
        let mut text = String::from(
            "OpCapability Shader\n%glsl = OpExtInstImport \"GLSL.std.450\"\nOpMemoryModel Logical GLSL450\n",
        );
        for Kernel { name, .. } in &self.kernels {
            let buffers = "%place %input %output %items_ %states";
            let _ = writeln!(text, "OpEntryPoint GLCompute %{name} \"{name}\" {buffers}");
        }
        for Kernel { name, .. } in &self.kernels {
            let _ = writeln!(text, "OpExecutionMode %{name} LocalSize 1 1 1");
        }
        for name in ["input", "output", "items_", "states", "hook"] {
            let _ = writeln!(text, "OpName %{name} \"{}\"", name.trim_end_matches('_'));
        }
        for Kernel { name, .. } in &self.kernels {
            let _ = writeln!(text, "OpName %{name} \"{name}\"");
        }
        // Every other one is called where it is needed.
        for (helper, name) in self.helpers.iter().zip(["called", "copied"].into_iter().cycle()) {
            let _ = writeln!(text, "OpName %{helper} \"{name}\"");
        }
        text += DECORATIONS;
        let (types, rest) = DECLARATIONS.split_once("%fn = ").expect("types come first");
        text += types;
        for value in 0..64 {
            let _ = writeln!(text, "%c{value} = OpConstant %uint {value}");
        }
        text += "%fn = ";
        let (declarations, hook) = rest.split_once("%hook = ").expect("the hook comes last");
        text += declarations;
        text += "%hook = ";
        text += hook;
        text += &self.text;
        text
    }
}

/// Text that stores a value in a word of the output.
pub fn store(word: usize, value: &str, kind: &str) -> String {
    let bits = match kind {
        "float" | "int" => format!("%@bits{word} = OpBitcast %uint {value}\n"),
        "bool" => format!("%@bits{word} = OpSelect %uint {value} %c1 %c0\n"),
        _ => format!("%@bits{word} = OpCopyObject %uint {value}\n"),
    };
    format!("{bits}%@out{word} = OpAccessChain %toWord %output %c0 %@i %c{word}\nOpStore %@out{word} %@bits{word}\n")
}

/// Runs a tool of SPIR-V that `make setup` has installed; `None` where there is none.
fn tool(name: &str, arguments: &[&str]) -> Option<()> {
    let installed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../.venv/bin").join(name);
    let path = if installed.exists() { installed } else { name.into() };
    let output = Command::new(path).args(arguments).stdin(Stdio::null()).output();
    match output {
        Ok(output) => {
            let messages = [output.stdout, output.stderr].concat();
            assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&messages));
            Some(())
        }
        Err(error) if std::env::var_os("RAGGIO_TEST_EVERYTHING").is_none() => {
            eprintln!("not checked: {name} is missing ({error}); `make setup` installs it");
            None
        }
        Err(error) => panic!("{name} is missing: {error}"),
    }
}

/// Words of the module that `text` describes; `None` where there is no assembler.
pub fn assemble(text: &str, folder: &Path) -> Option<Vec<u32>> {
    let (source, module) = (folder.join("module.txt"), folder.join("module.spv"));
    std::fs::write(&source, text).expect("the folder is writable");
    let (source, module) = (source.to_string_lossy().into_owned(), module.to_string_lossy().into_owned());
    tool("spirv-as", &["--target-env", "spv1.4", &source, "-o", &module])?;
    tool("spirv-val", &["--target-env", "spv1.4", "--scalar-block-layout", &module])?;
    let bytes = std::fs::read(module).expect("it was written");
    Some(bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
}
