//! Guards between hostile bytes and the libraries that decode them.

use std::panic::{AssertUnwindSafe, catch_unwind};

use bytemuck::Pod;

use crate::error::Problem;
use crate::format::Format;

/// Runs a decoder that may panic on damaged data, and makes the panic an error.
///
/// This is the last resort behind checks that bound what the decoder reserves: an allocation that fails ends the program
/// and cannot be caught. Nothing that the decoder touches is used after a panic.
pub(crate) fn caught<T>(format: Format, decoder: impl FnOnce() -> Result<T, Problem>) -> Result<T, Problem> {
    catch_unwind(AssertUnwindSafe(decoder))
        .unwrap_or_else(|_| Err(Problem::malformed(format, "its decoder gave up on what it holds")))
}

/// A list of `count` copies of `value`, or an error where there is not so much memory.
pub(crate) fn filled<T: Copy>(count: usize, value: T) -> Result<Vec<T>, Problem> {
    let mut list = Vec::new();
    list.try_reserve_exact(count).map_err(|error| Problem::Unreadable(error.to_string()))?;
    list.resize(count, value);
    Ok(list)
}

/// A number of a float image, made finite and not negative, at most `largest`.
pub(crate) fn radiance(value: f32, largest: f32) -> f32 {
    // The maximum of a number and NaN is the number.
    value.max(0.0).min(largest)
}

/// The numbers in groups, without a copy where the memory's size allows that. No group is incomplete.
pub(crate) fn grouped<T: Pod, Group: Pod>(values: Vec<T>) -> Vec<Group> {
    bytemuck::allocation::try_cast_vec(values).unwrap_or_else(|(_, values)| bytemuck::cast_slice(&values).to_vec())
}
