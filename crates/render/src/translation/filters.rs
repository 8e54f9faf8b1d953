//! Reconstruction filters as tables to draw from.

use std::f64::consts::TAU;

use raggio_kernels::FILTER_CELLS;
use raggio_scene::Filter;

/// Cells along an axis, all equally likely.
const CELLS: usize = FILTER_CELLS as usize;
/// Steps of the integration in a cell of average width.
const STEPS: usize = 64;

/// Quantiles of a filter's magnitude along one axis, in pixels from the pixel's middle, each with the weight of samples
/// between it and the next: the filter's integral there over that of its magnitude, so that weights are 1 on average
/// [ernst2006filter]. Empty for filters that need no table.
pub(crate) fn filter_table(filter: Filter) -> Vec<[f32; 2]> {
    match filter {
        Filter::Box | Filter::Point => vec![],
        Filter::BlackmanHarris => table(1.5, blackman_harris),
        Filter::Mitchell => table(2.0, mitchell),
    }
}

/// Blackman-Harris filter of radius 1.
fn blackman_harris(x: f64) -> f64 {
    let term = |k: f64| (k * TAU * 0.5 * (x + 1.0)).cos();
    0.35875 - 0.48829 * term(1.0) + 0.14128 * term(2.0) - 0.01168 * term(3.0)
}

/// Mitchell and Netravali's filter of radius 1, with B = C = 1/3 [mitchell1988reconstruction].
fn mitchell(x: f64) -> f64 {
    match 2.0 * x.abs() {
        x if x < 1.0 => (7.0 * x - 12.0) * x * x + 16.0 / 3.0,
        x => ((-7.0 / 3.0 * x + 12.0) * x - 20.0) * x + 32.0 / 3.0,
    }
}

fn table(radius: f64, filter: fn(f64) -> f64) -> Vec<[f32; 2]> {
    let count = CELLS * STEPS;
    let middle = |i: usize| (2 * i + 1) as f64 / count as f64 - 1.0;
    let magnitude: f64 = (0..count).map(|i| filter(middle(i)).abs()).sum();
    let integral: f64 = (0..count).map(|i| filter(middle(i))).sum();

    // Integrals up to where the step ends, in parts of the whole.
    let mut quantiles = vec![(-1.0, 0.0)];
    let (mut below, mut signed) = (0.0, 0.0);
    for i in 0..count {
        let value = filter(middle(i));
        while quantiles.len() < CELLS && below + value.abs() >= magnitude * quantiles.len() as f64 / CELLS as f64 {
            let part = (magnitude * quantiles.len() as f64 / CELLS as f64 - below) / value.abs();
            quantiles.push(((2.0 * (i as f64 + part)) / count as f64 - 1.0, (signed + part * value) / integral));
        }
        below += value.abs();
        signed += value;
    }
    quantiles.push((1.0, 1.0));

    let weight = |cell: &[(f64, f64)]| CELLS as f64 * (cell[1].1 - cell[0].1);
    let entry = |cell: &[(f64, f64)]| [(radius * cell[0].0) as f32, weight(cell) as f32];
    quantiles.windows(2).map(entry).chain([[radius as f32, 0.0]]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The part of the filter's integral below `x`, as samples drawn from the table see it.
    fn integral_below(table: &[[f32; 2]], x: f32) -> f64 {
        let share = |cell: &[[f32; 2]]| f64::from(((x - cell[0][0]) / (cell[1][0] - cell[0][0])).clamp(0.0, 1.0));
        table.windows(2).map(|cell| share(cell) * f64::from(cell[0][1])).sum::<f64>() / CELLS as f64
    }

    /// Part of the filter's integral below `x`, by Simpson's rule, which is exact for each of Mitchell's cubics.
    fn exact_below(filter: fn(f64) -> f64, radius: f64, x: f64) -> f64 {
        let integral = |to: f64| {
            let step = (to + 1.0) / 4000.0;
            let at = |i: i32| filter(-1.0 + f64::from(i) * step);
            (0..2000).map(|i| at(2 * i) + 4.0 * at(2 * i + 1) + at(2 * i + 2)).sum::<f64>() * step / 3.0
        };
        integral(x / radius) / integral(1.0)
    }

    #[test]
    fn tables_integrate_to_their_filters() {
        for (filter, function, radius) in
            [(Filter::BlackmanHarris, blackman_harris as fn(f64) -> f64, 1.5), (Filter::Mitchell, mitchell, 2.0)]
        {
            let table = filter_table(filter);
            assert_eq!(table.len(), CELLS + 1);
            assert!(table.windows(2).all(|cell| cell[0][0] < cell[1][0]), "{filter:?}: quantiles rise");
            for i in -20..=20 {
                let x = radius * f64::from(i) / 20.0;
                let (found, expected) = (integral_below(&table, x as f32), exact_below(function, radius, x));
                assert!((found - expected).abs() < 5e-4, "{filter:?} below {x}: expected {expected}, found {found}");
            }
        }
    }
}
