//! Samples of the principled material: they follow the density that is stated, and their weights are what it says.

use std::f64::consts::TAU;

use glam::Vec3;
use raggio_tests::statistics::{Verdict, chi_square};
use raggio_tests::{Pcg, TestDevice, for_each_device};

use super::{Closure, Sample, WHITE, closures, incident};

/// Number of bins in the cosine, from -1 to 1, and in the angle around the normal.
const BINS: (usize, usize) = (16, 24);
/// Number of places in a bin, in each coordinate.
const PLACES: usize = 16;

fn samples(device: &TestDevice, closure: &Closure, wo: Vec3, count: usize) -> Vec<Sample> {
    let mut random = Pcg::new(11);
    let numbers: Vec<_> = (0..count).map(|_| [0; 4].map(|_| random.unit())).collect();
    closure.ask_samples(device, wo, &numbers)
}

/// Middles of the `PLACES` x `PLACES` parts of every bin, bin by bin.
fn places() -> Vec<Vec3> {
    let place = |i: usize| {
        let (bin, part) = (i / (PLACES * PLACES), i % (PLACES * PLACES));
        let along =
            |bin: usize, part: usize, bins: usize| ((bin * PLACES + part) as f64 + 0.5) / (bins * PLACES) as f64;
        let z = 2.0 * along(bin / BINS.1, part / PLACES, BINS.0) - 1.0;
        let (sin, cos) = (TAU * along(bin % BINS.1, part % PLACES, BINS.1)).sin_cos();
        let r = (1.0 - z * z).sqrt();
        glam::DVec3::new(r * cos, r * sin, z).as_vec3()
    };
    (0..BINS.0 * BINS.1 * PLACES * PLACES).map(place).collect()
}

/// Probability of each bin, from the device's density.
fn probabilities(device: &TestDevice, closure: &Closure, wo: Vec3) -> Vec<f64> {
    let pairs: Vec<_> = places().into_iter().map(|wi| (wo, wi)).collect();
    let area = 2.0 * TAU / pairs.len() as f64;
    let densities = closure.eval(device, &pairs);
    densities
        .chunks(PLACES * PLACES)
        .map(|bin| bin.iter().map(|(_, pdf)| f64::from(*pdf)).sum::<f64>() * area)
        .collect()
}

fn bin(w: Vec3) -> usize {
    let row = ((f64::from(w.z) + 1.0) / 2.0 * BINS.0 as f64) as usize;
    let turn = f64::from(w.y).atan2(f64::from(w.x)).rem_euclid(TAU) / TAU;
    row.min(BINS.0 - 1) * BINS.1 + ((turn * BINS.1 as f64) as usize).min(BINS.1 - 1)
}

#[test]
fn samples_follow_their_density() {
    for_each_device(|device| {
        let mut verdict = Verdict::default();
        for (what, closure) in closures() {
            for cosine in [0.9, 0.3] {
                let wo = incident(cosine);
                let count = device.pick(200_000, 50_000);
                let mut counts = vec![0; BINS.0 * BINS.1];
                let drawn = samples(&device, &closure, wo, count);
                let found = drawn.iter().filter(|s| s.pdf > 0.0);
                found.clone().for_each(|s| counts[bin(s.wi)] += 1);
                let probabilities = probabilities(&device, &closure, wo);
                let expected: Vec<_> = probabilities.iter().map(|p| p * count as f64).collect();
                verdict.add(format!("{}: {what} at {cosine}", device.label), chi_square(&counts, &expected));

                let (total, share) = (probabilities.iter().sum::<f64>(), found.count() as f64 / count as f64);
                let error = 4.0 * (share * (1.0 - share) / count as f64).sqrt() + 1e-3;
                let what = format!("{}: {what} at {cosine}", device.label);
                assert!((total - share).abs() <= error, "{what}: density {total}, but {share} of the light goes on");
            }
        }
        println!("{}: the least p-value is {:.2e}", device.label, verdict.least());
        verdict.assert_all();
    });
}

/// Densities that come with samples are those of their directions, and weights are the values over them.
#[test]
fn weights_are_values_over_densities() {
    for_each_device(|device| {
        for (what, closure) in closures() {
            for cosine in [1.0, 0.6, 0.05] {
                let drawn = samples(&device, &closure, incident(cosine), 5000);
                let what = format!("{}: {what} at {cosine}", device.label);
                let pairs: Vec<_> = drawn.iter().map(|s| (incident(cosine), s.wi)).collect();
                for (s, (value, pdf)) in drawn.iter().zip(closure.eval(&device, &pairs)).filter(|(s, _)| s.found()) {
                    assert!(!s.delta && s.pdf == pdf, "{what}: {s:?} of density {pdf}");
                    assert_eq!(s.transmitted, s.wi.z < 0.0, "{what}: {s:?}");
                    let near = (s.weight * s.pdf - value).abs().max_element() <= 1e-5 * value.max_element();
                    assert!(near, "{what}: {s:?}");
                }
                assert!(drawn.iter().filter(|s| s.found()).count() > 2000, "{what}: most light ends");
            }
        }
    });
}

/// Smooth lobes have no density and no value, and the rest beside them has.
#[test]
fn smooth_lobes_are_apart() {
    let smooth = Closure { roughness: 0.0, ..WHITE };
    let cases = [
        ("smooth plastic", smooth, true),
        ("smooth metal", Closure { metallic: 1.0, ..smooth }, false),
        ("smooth glass", Closure { transmission: 1.0, ..smooth }, false),
        ("smooth sheet", Closure { transmission: 1.0, thin_walled: true, ..smooth }, false),
        ("smooth coat on rough plastic", Closure { clearcoat: 1.0, ..WHITE }, true),
    ];
    for_each_device(|device| {
        for (what, closure, rest) in cases {
            let drawn = samples(&device, &closure, incident(0.7), 20_000);
            let what = format!("{}: {what}", device.label);
            let (smooth, rough): (Vec<&Sample>, Vec<&Sample>) =
                drawn.iter().filter(|s| s.found()).partition(|s| s.delta);
            assert!(smooth.len() > 500 && rough.is_empty() != rest, "{what}: {} and {}", smooth.len(), rough.len());
            assert!(smooth.iter().all(|s| s.pdf == 0.0), "{what}: a density of what has none");
            assert!(rough.iter().all(|s| s.pdf > 0.0), "{what}: a sample without density");
            if !rest {
                let pairs: Vec<_> = smooth.iter().map(|s| (incident(0.7), s.wi)).collect();
                let answers = closure.eval(&device, &pairs);
                assert!(answers.iter().all(|a| *a == (Vec3::ZERO, 0.0)), "{what}: {answers:?}");
            }
        }
    });
}
