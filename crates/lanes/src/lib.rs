//! SPIR-V compute kernels as C++ that runs several invocations at once.
//!
//! `LANES`, a constant of the C++ (1, 4, 8 or 16), says how many: one invocation to a lane of the vectors that
//! [`RUNTIME`] defines. Results are the same bits for all of them, as long as the C++ compiler fuses no operations
//! (`-ffp-contract=off`) and takes no liberties.
//!
//! # How it works
//! 1. `module.rs` reads SPIR-V; nothing has to be optimised before.
//! 2. `lower.rs` makes a tree of the blocks (`program.rs`): branches, loops, and scopes that lanes may leave. `lower/calls.rs` puts
//!    functions into their callers, but for those of [`Options::calls`]; `arithmetic.rs` and `memory.rs` translate what stands
//!    in the blocks. Every scalar of a vector, structure or array is a register of its own.
//! 3. `simplify.rs` and `locals.rs` drop scopes that nothing leaves, and copies of local variables.
//! 4. `analysis.rs` finds out which assignments must be masked, and which registers are the same in all lanes.
//! 5. `emit.rs` and `cpp.rs` write C++.
//!
//! **Masks.** All lanes go the same way through the C++, and a mask says which of them are active. A branch divides the
//! mask; leaving a loop, a switch or a function early moves lanes to the mask of its end, and what follows is left to the
//! others. Loops run until no lane is in them.
//!
//! **Assignments** change all lanes unless the register is still needed where lanes wait: `analysis.rs` says when.
//!
//! **Phis** become assignments on the edges that lead to them; slangc without optimisation makes none.
//!
//! **Uniform** registers and conditions, those that are the same in all lanes, are scalars: constants, push constants, what
//! is read at uniform places, what is computed of those, and counters of loops, even of loops that lanes leave one by one.
//!
//! **Memory.** A lane that is not active reads where the first active lane does. Where all lanes read at one place a scalar is
//! read; rows of 16 bytes are read and transposed; single words are gathered. Local arrays that are indexed by variables
//! hold a vector for each word.
//!
//! # Contract
//! Undefined in SPIR-V is undefined here: results of shifts by 32 or more and of conversions that do not fit may differ from
//! one number of lanes to another.

mod analysis;
mod arithmetic;
mod bits;
mod cpp;
mod emit;
mod error;
mod layout;
mod locals;
mod lower;
mod memory;
mod module;
mod program;
mod simplify;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::fmt::Write as _;

pub use error::Error;
pub use program::Buffer;

/// C++ header that the translated code includes as `lanes.h`: vectors of `LANES` numbers, and what is done with them.
pub const RUNTIME: &str = include_str!("../runtime/lanes.h");

/// What is translated in which way.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Functions that are not translated, by name. A call becomes `context.NAME(mask, arguments..., results&...)`, all of
    /// them vectors, a scalar at a time in the order of their declaration. Arguments include what pointers point to.
    /// Results are what the function returns, then what each pointer that it writes through points to. Lanes that are not
    /// in the mask may hold anything, and may be given anything. `[noinline]` keeps a function of Slang apart.
    pub hooks: Vec<String>,
    /// Functions that stay functions, by name, instead of being put into all that call them: those that are long and
    /// called from several places. They are called as hooks are, and know of no argument that it is the same in all lanes.
    /// Those that are not there are ignored.
    pub calls: Vec<String>,
    /// Storage buffers, by name, of which every invocation owns the element at its place along x, and that are stored by
    /// columns: one for each word of an element. `context.NAME` is a `lanes::Columns` at the first lane's element.
    pub columns: Vec<String>,
    /// Values of specialisation constants, by `SpecId`; others keep those that they have.
    pub specialisation: HashMap<u32, u32>,
}

/// Translated kernels.
#[derive(Clone, Debug)]
pub struct Translation {
    /// C++, of which the lines below are the outline. `Context` is a type of the includer's with these members, and those
    /// that [`Options`] speaks of. Kernels and hooks must not change it.
    ///
    /// ```cpp
    /// #include "lanes.h"
    /// namespace lanes {
    /// struct Buffers { char* film; const char* nodes; };
    /// // context.buffers is a Buffers; context.work points to the push constants.
    /// template <class Context>
    /// static void kernel(const Context& __restrict context, Mask mask, Uint x, Uint y, Uint z);
    /// }
    /// ```
    pub code: String,
    /// Buffers that the kernels use, in the order of the members of `Buffers`; those of [`Options::columns`] are no members.
    pub buffers: Vec<Buffer>,
}

/// Translates the entry points of these names in the module `words`.
///
/// # Errors
/// When the module is not valid, has no such entry point, or does what there is no translation for.
pub fn translate(words: &[u32], entry_points: &[&str], options: &Options) -> Result<Translation, Error> {
    let module = module::Module::read(words, &options.specialisation)?;
    let mut shared = lower::Shared { module: &module, options, buffers: vec![], called: vec![] };
    let mut programs = vec![];
    for name in entry_points {
        let entry = module.entry_points.iter().find(|(entry, _)| entry == name);
        let (_, id) = entry.ok_or_else(|| Error::Missing((*name).to_owned()))?;
        programs.push((*name, lower::Lowering::entry_point(&mut shared, *id)?));
    }
    let lower::Shared { mut called, buffers, .. } = shared;
    let called = called.iter_mut().map(|called| (&*called.name, &mut called.program));
    let mut functions = String::new();
    for (name, program) in called.chain(programs.iter_mut().map(|(name, program)| (*name, program))) {
        program.simplify();
        program.resolve_locals();
        let analysis = program.analyse();
        functions += "\n";
        functions += &emit::function(name, program, &analysis, &buffers);
    }
    let mut code = String::from("#include \"lanes.h\"\n\nnamespace lanes {\n\nstruct Buffers {\n");
    for buffer in buffers.iter().filter(|buffer| !buffer.columns) {
        let _ = writeln!(code, " {}char* {};", if buffer.writable { "" } else { "const " }, buffer.name);
    }
    code += "};\n";
    code += &functions;
    code += "\n}\n";
    Ok(Translation { code, buffers })
}
