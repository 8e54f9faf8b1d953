//! Parts of large hierarchies, one for each cell of a grid: they fit into caches, and each thread builds its own.

use glam::UVec3;
use rayon::prelude::*;

use super::Bounds;

/// Most boxes that are built in one piece.
const LARGE: usize = 1 << 15;
/// Boxes that a cell should have.
const IN_CELL: usize = 1 << 13;
/// Least number of boxes in a cell that is a part.
const SCARCE: usize = 1 << 8;
/// Cells along the longest side of the grid.
const MOST_CELLS: f32 = 32.0;

/// Boxes by the part they belong to, as indices.
#[derive(Debug, Default)]
pub(super) struct Parts {
    /// Boxes of each part: at least [`SCARCE`], and not all in one.
    pub together: Vec<Vec<u32>>,
    /// Boxes of no part: those larger than a cell, and those in cells that hardly have any.
    pub alone: Vec<u32>,
}

/// Divides `boxes`, if they are many and not all in one place.
pub(super) fn divide(boxes: &[Bounds]) -> Parts {
    let whole = || Parts { together: vec![], alone: (0..boxes.len() as u32).collect() };
    if boxes.len() <= LARGE {
        return whole();
    }
    let point = |bounds: &Bounds| Bounds(bounds.center(), bounds.center());
    let Bounds(lower, upper) = boxes.par_iter().map(point).reduce(|| Bounds::EMPTY, Bounds::union);
    let extent = upper - lower;
    // The grid is divided as if a surface went through it, which has so many cells on each of three sides.
    let side = (boxes.len() as f32 / (3 * IN_CELL) as f32).sqrt().clamp(2.0, MOST_CELLS).floor();
    let edge = extent.max_element() / side;
    if !edge.is_normal() {
        return whole();
    }
    let size = (extent / edge).as_uvec3() + UVec3::ONE;
    let none = size.element_product() as usize;
    let cell = |bounds: &Bounds| {
        if (bounds.1 - bounds.0).max_element() > edge {
            return none;
        }
        let UVec3 { x, y, z } = ((bounds.center() - lower) / edge).as_uvec3().min(size - UVec3::ONE);
        ((z * size.y + y) * size.x + x) as usize
    };
    let cells: Vec<u32> = boxes.par_iter().map(|bounds| cell(bounds) as u32).collect();
    let mut counts = vec![0; none + 1];
    cells.iter().for_each(|&cell| counts[cell as usize] += 1);
    counts[none] = 0;

    let mut together: Vec<_> = counts.iter().map(|&n| (n >= SCARCE).then(|| Vec::with_capacity(n))).collect();
    let mut alone = vec![];
    for (index, &cell) in (0..).zip(&cells) {
        together[cell as usize].as_mut().unwrap_or(&mut alone).push(index);
    }
    Parts { together: together.into_iter().flatten().collect(), alone }
}
