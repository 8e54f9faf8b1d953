//! Errors of the translation.

use std::fmt;

use spirv::Op;

/// Reason why a module cannot be translated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// The words are not SPIR-V, and why.
    Malformed(String),
    /// An instruction that there is no translation for.
    Unsupported {
        /// Its name, as SPIR-V spells it.
        instruction: String,
        /// The function in which it stands.
        function: String,
    },
    /// No entry point or function has this name.
    Missing(String),
}

impl Error {
    pub(crate) fn unsupported(op: u32, function: &str) -> Self {
        let instruction = Op::from_u32(op).map_or(format!("opcode {op}"), |op| format!("Op{op:?}"));
        Self::Unsupported { instruction, function: function.into() }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Malformed(reason) => write!(f, "this is no SPIR-V that can be translated: {reason}"),
            Self::Unsupported { instruction, function } => write!(f, "{instruction} in {function} has no translation"),
            Self::Missing(name) => write!(f, "the module has no function `{name}`"),
        }
    }
}

impl std::error::Error for Error {}

pub(crate) type Result<T> = std::result::Result<T, Error>;
