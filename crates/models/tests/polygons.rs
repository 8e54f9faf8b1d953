//! Polygons become triangles that cover them, in a time that grows little faster than their corners.

use std::f64::consts::TAU;
use std::time::{Duration, Instant};

use proptest::collection::vec;
use proptest::prelude::*;
use raggio_models::{MeshFile, parse_obj};

/// The mesh of one polygon in the plane z = 0.
fn polygon(corners: &[[f64; 2]]) -> MeshFile {
    let mut text: String = corners.iter().map(|[x, y]| format!("v {x} {y} 0\n")).collect();
    text += "f";
    (1..=corners.len()).for_each(|i| text += &format!(" {i}"));
    parse_obj(text.as_bytes(), "").unwrap()
}

/// Areas of the triangles, positive where they turn to the left.
fn areas(file: &MeshFile) -> Vec<f64> {
    let area = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|i| file.mesh.positions[i as usize].map(f64::from));
        ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2.0
    };
    file.mesh.triangles.iter().map(area).collect()
}

/// Area of a polygon as its corners are stored.
fn outlined(corners: &[[f64; 2]]) -> f64 {
    let stored: Vec<_> = corners.iter().map(|corner| corner.map(|x| f64::from(x as f32))).collect();
    let next = stored.iter().cycle().skip(1);
    stored.iter().zip(next).map(|(a, b)| (a[0] * b[1] - a[1] * b[0]) / 2.0).sum()
}

/// The triangles of a polygon without crossings are two fewer than its corners, turn as it does, and have its area. Corners
/// that are where the one before is may have none.
#[track_caller]
fn check(corners: &[[f64; 2]]) {
    let file = polygon(corners);
    let areas = areas(&file);
    let (sum, area) = (areas.iter().sum::<f64>(), outlined(corners));
    let count = areas.len() + file.dropped.degenerate;
    let next = corners.iter().cycle().skip(1);
    let repeated = corners.iter().zip(next).filter(|(corner, next)| corner == next).count();
    assert!([corners.len() - 2, corners.len() - 2 - repeated].contains(&count), "{count} of {}", corners.len());
    assert!(areas.iter().all(|part| part.signum() == area.signum()), "some triangles turn the other way");
    assert!((sum / area - 1.0).abs() < 1e-9, "{sum} should be {area}");
}

fn star(count: usize) -> Vec<[f64; 2]> {
    let corner = |i: usize| {
        let (angle, radius) = (TAU * i as f64 / count as f64, if i.is_multiple_of(2) { 1.0 } else { 0.5 });
        [radius * angle.cos(), radius * angle.sin()]
    };
    (0..count).map(corner).collect()
}

/// A band that winds around the origin, there and back.
fn spiral(count: usize) -> Vec<[f64; 2]> {
    let turns = (count as f64).sqrt() / 8.0;
    let half = count / 2;
    let corner = |i: usize, offset: f64| {
        let angle = TAU * turns * i as f64 / half as f64;
        let radius = 1.0 + angle / TAU + offset;
        [radius * angle.cos(), radius * angle.sin()]
    };
    (0..half).map(|i| corner(i, 0.5)).chain((0..half).rev().map(|i| corner(i, 0.0))).collect()
}

fn comb(count: usize) -> Vec<[f64; 2]> {
    let tooth = |i: usize| [i as f64, if i.is_multiple_of(2) { 0.0 } else { 1000.0 }];
    [[count as f64, -1.0], [count as f64, 500.0]]
        .into_iter()
        .chain((0..count - 3).rev().map(tooth))
        .chain([[0.0, -1.0]])
        .collect()
}

#[test]
fn polygons_of_all_sizes() {
    for count in [5, 8, 30, 64, 66, 100, 1000, 5000] {
        for shape in [star(count), spiral(count), comb(count)].iter_mut() {
            if shape.len() < 5 {
                continue;
            }
            check(shape);
            shape.reverse();
            check(shape);
        }
    }
}

/// A square with a square hole, joined to it by two edges on top of each other, as exporters write holes; each side has
/// many corners.
#[test]
fn holes_stay_open() {
    let ring = |radius: f64, count: usize| {
        let side = move |from: [f64; 2], to: [f64; 2]| {
            (0..count).map(move |i| {
                let t = i as f64 / count as f64;
                [from[0] + (to[0] - from[0]) * t, from[1] + (to[1] - from[1]) * t]
            })
        };
        let corners = [[-radius, -radius], [radius, -radius], [radius, radius], [-radius, radius], [-radius, -radius]];
        let mut ring: Vec<_> = corners.windows(2).flat_map(|pair| side(pair[0], pair[1])).collect();
        ring.push(corners[0]);
        ring
    };
    for count in [1, 2, 32, 128] {
        let mut corners = ring(2.0, count);
        corners.extend(ring(1.0, count).into_iter().rev());
        let file = polygon(&corners);
        let areas = areas(&file);
        assert!(areas.iter().all(|area| *area > 0.0));
        assert!((areas.iter().sum::<f64>() - 12.0).abs() < 1e-9, "{count}: {}", areas.iter().sum::<f64>());
        let middle = |triangle: &[u32; 3], axis: usize| {
            triangle.iter().map(|i| file.mesh.positions[*i as usize][axis]).sum::<f32>() / 3.0
        };
        assert!(file.mesh.triangles.iter().all(|t| middle(t, 0).abs().max(middle(t, 1).abs()) > 1.0));
    }
}

/// Each of these took half a minute when ears were cut off them. Far less is allowed than that, and far more than they take.
#[test]
fn large_polygons_take_little_time() {
    for shape in [star(200_000), spiral(200_000), comb(200_000)] {
        let start = Instant::now();
        check(&shape);
        let taken = start.elapsed();
        println!("{taken:?}");
        assert!(taken < Duration::from_secs(8), "{taken:?}");
    }
}

/// Corners that all meet in one place, or cross everywhere, have triangles, too, and soon.
#[test]
fn large_polygons_made_to_take_long() {
    let count = 100_000;
    let petals = |i: usize| {
        let angle = TAU * i as f64 / count as f64;
        if i.is_multiple_of(3) { [0.0, 0.0] } else { [angle.cos(), angle.sin()] }
    };
    let line = |i: usize| [i as f64, 0.0];
    let there_and_back = |i: usize| if i.is_multiple_of(2) { [0.0, 0.0] } else { petals(i) };
    let crossing = |i: usize| [((i * 7919) % 1009) as f64, ((i * 104_729) % 1013) as f64];
    let needles = |i: usize| [(i as f64 * 0.001).sin() * 1e-6 + i as f64, if i.is_multiple_of(2) { 0.0 } else { 1e12 }];
    let shapes: [&dyn Fn(usize) -> [f64; 2]; 5] = [&petals, &line, &there_and_back, &crossing, &needles];
    for (number, shape) in shapes.iter().enumerate() {
        let corners: Vec<_> = (0..count).map(shape).collect();
        let start = Instant::now();
        let file = polygon(&corners);
        let taken = start.elapsed();
        println!("{number}: {taken:?}, {} triangles", file.mesh.triangles.len());
        assert!(taken < Duration::from_secs(8), "{number}: {taken:?}");
    }
}

proptest! {
    /// Outlines around the origin, with corners in and out.
    #[test]
    fn outlines_that_are_seen_from_within(radii in vec(0.01..1.0, 65..400)) {
        let count = radii.len() as f64;
        let corner = |(i, radius): (usize, &f64)| [(TAU * i as f64 / count).cos() * radius, (TAU * i as f64 / count).sin() * radius];
        let mut corners: Vec<_> = radii.iter().enumerate().map(corner).collect();
        check(&corners);
        corners.reverse();
        check(&corners);
    }

    /// Outlines whose edges go along the axes, with corners on straight lines, above one another and twice on a place.
    #[test]
    fn outlines_of_bars(heights in vec(1..5u8, 33..200), is_upright in any::<bool>()) {
        let bars = heights.iter().enumerate().rev();
        let tops = bars.flat_map(|(i, height)| [i + 1, i].map(|x| [x as f64, f64::from(*height)]));
        let mut corners: Vec<_> = [[0.0, 0.0], [heights.len() as f64, 0.0]].into_iter().chain(tops).collect();
        if !is_upright {
            corners.iter_mut().for_each(|corner| corner.reverse());
        }
        check(&corners);
    }
}
