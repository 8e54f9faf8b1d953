//! Independent random numbers, and the sine and cosine made for them.

use std::f64::consts::TAU;

use raggio_render::{Probe, Question, Sequence};
use raggio_tests::devices::{cpu, vulkan};
use raggio_tests::statistics::{Verdict, chi_square};
use raggio_tests::{Pcg, TestDevice, for_each_device};

use crate::samplers::anywhere;

/// Key of a draw: pixel in x and y, sample, seed, dimension.
pub type Key = [u32; 5];

/// Keys that are neighbours of all kinds, as renders use them: 64 x 64 pixels, 16 samples, 8 dimensions, 2 seeds.
fn keys() -> Vec<Key> {
    (0..1u32 << 20).map(|i| [i & 63, (i >> 6) & 63, (i >> 12) & 15, (i >> 19) & 1, (i >> 16) & 7]).collect()
}

/// Draws the sampler's numbers for each key.
pub fn numbers(device: &TestDevice, sequence: Sequence, keys: &[Key]) -> Vec<[f32; 4]> {
    let bits = |key: &Key| key.map(f32::from_bits);
    let question = |key: &Key| -> Question {
        let [x, y, sample, seed, dimension] = bits(key);
        [[x, y, sample, seed], [dimension, f32::from_bits(sequence as u32), 0.0, 0.0], [0.0; 4]]
    };
    let questions: Vec<_> = keys.iter().map(question).collect();
    device.ask(&anywhere(), Probe::Random, &questions).into_iter().map(|answer| answer[0]).collect()
}

/// Expected counts, equal in all bins.
fn flat(counts: &[u64], total: usize) -> Vec<f64> {
    vec![total as f64 / counts.len() as f64; counts.len()]
}

/// Tests each lane by itself.
pub fn test_lanes(numbers: &[[f32; 4]], verdict: &mut Verdict) {
    for lane in 0..4 {
        let mut counts = vec![0; 1024];
        numbers.iter().for_each(|n| counts[(n[lane] * 1024.0) as usize] += 1);
        verdict.add(format!("lane {lane}"), chi_square(&counts, &flat(&counts, numbers.len())));
    }
}

/// Tests two series of numbers against each other.
pub fn test_pairs(what: String, pairs: impl Iterator<Item = (f32, f32)>, verdict: &mut Verdict) {
    const SIDE: usize = 64;
    let mut counts = vec![0; SIDE * SIDE];
    let mut total = 0;
    for (a, b) in pairs {
        counts[(a * SIDE as f32) as usize * SIDE + (b * SIDE as f32) as usize] += 1;
        total += 1;
    }
    verdict.add(what, chi_square(&counts, &flat(&counts, total)));
}

#[test]
fn numbers_are_uniform_and_independent() {
    for_each_device(|device| {
        let keys = keys();
        let own = numbers(&device, Sequence::Pcg, &keys);
        for n in own.iter().flatten() {
            let on_grid = (n * 16_777_216.0).fract() == 0.0;
            assert!((0.0..1.0).contains(n) && on_grid, "{}: {n} is no multiple of 2^-24 in [0, 1)", device.label);
        }
        let mut verdict = Verdict::default();
        test_lanes(&own, &mut verdict);
        for (a, b) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            test_pairs(format!("lanes {a} and {b}"), own.iter().map(|n| (n[a], n[b])), &mut verdict);
        }
        for (part, what) in
            ["pixel to the right", "pixel below", "next sample", "next seed", "next dimension"].iter().enumerate()
        {
            let next: Vec<Key> =
                keys.iter().map(|key| std::array::from_fn(|i| key[i] + u32::from(i == part))).collect();
            let next = numbers(&device, Sequence::Pcg, &next);
            for lane in 0..4 {
                for other in [lane, (lane + 1) % 4] {
                    let pairs = own.iter().zip(&next).map(|(a, b)| (a[lane], b[other]));
                    test_pairs(format!("lane {lane} and lane {other} of the {what}"), pairs, &mut verdict);
                }
            }
        }
        println!("{}: the least p-value is {:.2e}", device.label, verdict.least());
        verdict.assert_all();
    });
}

/// Integers and their exact conversions have equal bits on every device.
#[test]
fn devices_draw_the_same_numbers() {
    let Some(vulkan) = vulkan() else { return };
    let random = &mut Pcg::new(3);
    let mut keys: Vec<Key> = (0..200_000).map(|_| [(); 5].map(|()| random.bits())).collect();
    keys.iter_mut().for_each(|key| key[..2].iter_mut().for_each(|coordinate| *coordinate &= 0xffff));
    keys.extend(self::keys().into_iter().step_by(7));
    for sequence in Sequence::ALL {
        let cpu = numbers(&TestDevice { label: "cpu", slow: false, device: cpu() }, sequence, &keys);
        let vulkan = numbers(&TestDevice { label: "vulkan", slow: true, device: vulkan }, sequence, &keys);
        for ((key, a), b) in keys.iter().zip(&cpu).zip(&vulkan) {
            assert!(a.map(f32::to_bits) == b.map(f32::to_bits), "{key:?}: {a:?} on the CPU, {b:?} on Vulkan");
        }
    }
}

/// Errors are as documented: below 2e-7, absolute.
#[test]
fn sine_and_cosine_are_accurate() {
    let turns: Vec<f32> = (0..=1 << 18).map(|i| i as f32 * 2f32.powi(-18)).collect();
    let random = &mut Pcg::new(4);
    let turns: Vec<f32> = turns.into_iter().chain((0..200_000).map(|_| random.unit())).collect();
    let questions: Vec<Question> = turns.iter().map(|&turn| [[turn, 0.0, 0.0, 0.0], [0.0; 4], [0.0; 4]]).collect();
    for_each_device(|device| {
        let mut worst = 0.0f64;
        for (turn, answer) in turns.iter().zip(device.ask(&anywhere(), Probe::SinCos, &questions)) {
            let (sin, cos) = (TAU * f64::from(*turn)).sin_cos();
            let error = (f64::from(answer[0][0]) - sin).abs().max((f64::from(answer[0][1]) - cos).abs());
            let [found_sin, found_cos, ..] = answer[0];
            let found = format!("found {found_sin} and {found_cos}");
            assert!(error < 2e-7, "{}: of {turn} turns: expected {sin} and {cos}, {found}", device.label);
            worst = worst.max(error);
        }
        println!("{}: worst error of sine and cosine {worst:.2e}", device.label);
    });
}

/// Errors are as documented: below 7e-8, absolute, from the axes to everywhere.
#[test]
fn angles_are_accurate() {
    let random = &mut Pcg::new(5);
    let mut coordinate = || match random.below(4) {
        0 => 0.0,
        1 => random.log_between(1e-30, 1e30) as f32,
        _ => random.between(-1.0, 1.0) as f32,
    };
    let mut points: Vec<[f32; 2]> = (0..400_000).map(|_| [coordinate(), coordinate()]).collect();
    points.extend([[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [0.0, -1.0], [0.0, 0.0]]);
    let questions: Vec<Question> = points.iter().map(|[y, x]| [[*y, *x, 0.0, 0.0], [0.0; 4], [0.0; 4]]).collect();
    for_each_device(|device| {
        let mut worst = 0.0f64;
        for ([y, x], answer) in points.iter().zip(device.ask(&anywhere(), Probe::Atan2, &questions)) {
            let expected = f64::from(*y).atan2(f64::from(*x)) / TAU;
            let error = (f64::from(answer[0][0]) - expected).abs();
            assert!(error < 7e-8, "{}: of ({y}, {x}): expected {expected}, found {}", device.label, answer[0][0]);
            worst = worst.max(error);
        }
        println!("{}: worst error of angles {worst:.2e} turns", device.label);
    });
}

/// Errors are as documented: below 2e-7 of exponentials and 1e-7 of logarithms, relative (absolute near 1); 4e-7 of
/// cosines, absolute.
#[test]
fn elementary_functions_are_accurate() {
    let random = &mut Pcg::new(6);
    let mut numbers: Vec<f32> = (0..200_000).map(|_| random.between(-87.0, 87.0) as f32).collect();
    numbers.extend((0..200_000).map(|_| random.log_between(1e-37, 1e38) as f32));
    numbers.extend((0..100_000).map(|_| random.between(0.5, 2.0) as f32));
    numbers.extend([0.0, 1.0, -1e30, -87.1, 87.0]);
    let questions: Vec<Question> = numbers.iter().map(|&x| [[x, 0.0, 0.0, 0.0], [0.0; 4], [0.0; 4]]).collect();
    for_each_device(|device| {
        let mut worst = [0.0f64; 3];
        for (&number, [answer, ..]) in numbers.iter().zip(device.ask(&anywhere(), Probe::Elementary, &questions)) {
            let x = f64::from(number);
            let error = |i: usize, expected: f64| (f64::from(answer[i]) - expected).abs();
            let exponential = if x > -87.0 { error(0, x.min(87.0).exp()) / x.min(87.0).exp() } else { error(0, 0.0) };
            let logarithm = if x > 0.0 { error(1, x.ln()) / x.ln().abs().max(1.0) } else { 0.0 };
            // A float tells less of turns the more there are.
            let cosine = if x.abs() < 100.0 { error(2, (TAU * (x - x.floor())).cos()) } else { 0.0 };
            let errors = [exponential, logarithm, cosine];
            let allowed = [2e-7, 1e-7, 4e-7];
            assert!((0..3).all(|i| errors[i] < allowed[i]), "{}: of {x}: {answer:?}, errors {errors:?}", device.label);
            worst = [0, 1, 2].map(|i| worst[i].max(errors[i]));
        }
        println!("{}: worst errors of exponential, logarithm and cosine {worst:?}", device.label);
    });
}
