//! Guards between hostile bytes and the libraries that decode them.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

use bytemuck::Pod;

use crate::error::Problem;
use crate::format::Format;

thread_local! {
    static GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread runs a decoder whose panic becomes an error.
///
/// A panic hook runs before anything is caught, so one that ends the program, or tells the user of a fault, asks here first
/// and does nothing where the answer is yes.
pub fn guarded() -> bool {
    GUARDED.get()
}

/// Runs a decoder that may panic on damaged data, and makes the panic an error.
///
/// This is the last resort behind checks that bound what the decoder reserves: an allocation that fails ends the program
/// and cannot be caught. Nothing that the decoder touches is used after a panic. The decoder must not wait for other
/// threads: while it waits, its own may be given work that is nobody's to guard.
pub(crate) fn caught<T>(format: Format, decoder: impl FnOnce() -> Result<T, Problem>) -> Result<T, Problem> {
    let before = GUARDED.replace(true);
    let outcome = catch_unwind(AssertUnwindSafe(decoder));
    GUARDED.set(before);
    outcome.unwrap_or_else(|_| Err(Problem::malformed(format, "its decoder gave up on what it holds")))
}

/// A list of `count` copies of `value`, or an error where there is not so much memory.
pub(crate) fn filled<T: Copy>(count: usize, value: T) -> Result<Vec<T>, Problem> {
    let mut list = reserved(count)?;
    list.resize(count, value);
    Ok(list)
}

/// A list of what `items` gives, which knows how many there are, or an error where there is not so much memory.
pub(crate) fn collected<T>(items: impl ExactSizeIterator<Item = T>) -> Result<Vec<T>, Problem> {
    let mut list = reserved(items.len())?;
    list.extend(items);
    Ok(list)
}

/// The slices one after another, or an error where there is not so much memory.
pub(crate) fn joined<T: Copy>(slices: &[&[T]]) -> Result<Vec<T>, Problem> {
    let mut list = reserved(slices.iter().map(|slice| slice.len()).sum())?;
    slices.iter().for_each(|slice| list.extend_from_slice(slice));
    Ok(list)
}

fn reserved<T>(count: usize) -> Result<Vec<T>, Problem> {
    let mut list = Vec::new();
    list.try_reserve_exact(count).map_err(|error| Problem::Unreadable(error.to_string()))?;
    Ok(list)
}

/// A number of a float image, made finite and not negative, at most `largest`.
pub(crate) fn radiance(value: f32, largest: f32) -> f32 {
    // The maximum of a number and NaN is the number.
    value.max(0.0).min(largest)
}

/// The numbers in groups, without a copy where the memory's size allows that. No group is incomplete.
pub(crate) fn grouped<T: Pod, Group: Pod>(values: Vec<T>) -> Result<Vec<Group>, Problem> {
    bytemuck::allocation::try_cast_vec(values).or_else(|(_, values)| joined(&[bytemuck::cast_slice(&values)]))
}
