//! Chi-square tests of the samplers, and the densities of the device against those of double precision.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};
use raggio_kernels::SamplerKind;
use raggio_render::{Probe, Question};
use raggio_tests::statistics::{ChiSquare, Verdict, chi_square};
use raggio_tests::{Pcg, TestDevice, for_each_device};

use crate::samplers::anywhere;
use crate::samplers::densities::{Case, Chart, cases};

/// Number of bins in h and in phi.
const BINS: (usize, usize) = (16, 32);
/// Number of cells of a bin for its integral, in each coordinate; two Gauss points in each.
const CELLS: usize = 12;

fn sample_questions(case: &Case, count: usize, random: &mut Pcg) -> Vec<Question> {
    let wo = case.wo.as_vec3().extend(case.detail as f32).to_array();
    let u = |random: &mut Pcg| [case.kind as u32 as f32, random.unit(), random.unit(), case.smoothness as f32];
    let mut question = || {
        let u = u(random);
        let choice = if case.loses() { random.unit() } else { 0.0 };
        [u, case.n.as_vec3().extend(choice).to_array(), wo]
    };
    (0..count).map(|_| question()).collect()
}

fn density_question(case: &Case, w: DVec3) -> Question {
    let w = w.as_vec3();
    let n = case.n.as_vec3().extend(case.smoothness as f32).to_array();
    [[case.kind as u32 as f32, w.x, w.y, w.z], n, case.wo.as_vec3().extend(case.detail as f32).to_array()]
}

/// Integral of `density` over a bin of `chart`.
fn integral(chart: &Chart, bin: (usize, usize), density: &dyn Fn(DVec3) -> f64) -> f64 {
    let (low, high) = chart.range;
    let size = ((high - low) / (BINS.0 * CELLS) as f64, TAU / (BINS.1 * CELLS) as f64);
    let gauss = 0.5 / 3f64.sqrt();
    let places = |bin: usize, size: f64| {
        (bin * CELLS..(bin + 1) * CELLS).flat_map(move |cell| [-gauss, gauss].map(|g| (cell as f64 + 0.5 + g) * size))
    };
    let mut sum = 0.0;
    for h in places(bin.0, size.0).map(|h| low + h) {
        sum += places(bin.1, size.1).map(|phi| density(chart.point(h, phi)) * chart.measure(h, phi)).sum::<f64>();
    }
    sum * size.0 * size.1 / 4.0
}

fn integrals(chart: &Chart, density: &dyn Fn(DVec3) -> f64) -> Vec<f64> {
    (0..BINS.0 * BINS.1).map(|i| integral(chart, (i / BINS.1, i % BINS.1), density)).collect()
}

fn histogram(chart: &Chart, points: impl Iterator<Item = DVec3>) -> Vec<u64> {
    let mut counts = vec![0; BINS.0 * BINS.1];
    let (low, high) = chart.range;
    for (h, phi) in points.map(|w| chart.coordinates(w)) {
        let place = |x: f64, bins: usize| ((x * bins as f64).max(0.0) as usize).min(bins - 1);
        counts[place((h - low) / (high - low), BINS.0) * BINS.1 + place(phi / TAU, BINS.1)] += 1;
    }
    counts
}

/// Draws samples from a device, and tests them against `density`.
fn test_against(device: &TestDevice, case: &Case, random: &mut Pcg, density: &dyn Fn(DVec3) -> f64) -> ChiSquare {
    let count = device.pick(1_000_000, 200_000);
    let answers = device.ask(&anywhere(), Probe::Sample, &sample_questions(case, count, random));
    let chart = case.chart();
    let points = answers.iter().map(|answer| Vec3::from_slice(&answer[0]).as_dvec3());
    // A zero vector is a sample that found no direction.
    let counts = histogram(&chart, points.filter(|w| !(case.loses() && *w == DVec3::ZERO)));
    let expected: Vec<_> = integrals(&chart, density).iter().map(|p| p * count as f64).collect();
    chi_square(&counts, &expected)
}

#[test]
fn samples_follow_their_density() {
    for_each_device(|device| {
        let mut verdict = Verdict::default();
        for (i, case) in cases().iter().enumerate() {
            let result = test_against(&device, case, &mut Pcg::new(i as u64), &|w| case.density(w));
            verdict.add(format!("{}: {case:?}", device.label), result);
        }
        println!("{}: the least p-value is {:.2e}", device.label, verdict.least());
        verdict.assert_all();
    });
}

/// The test above can tell: it rejects densities that are nearly right.
#[test]
fn wrong_densities_are_rejected() {
    let case = |kind, smoothness| {
        let all = cases();
        *all.iter().find(|c| c.kind as u32 == kind as u32 && c.smoothness == smoothness).expect("there is such a case")
    };
    for_each_device(|device| {
        let cosine = case(SamplerKind::CosineHemisphere, 0.0);
        let uniform = Case { kind: SamplerKind::UniformHemisphere, ..cosine };
        let rougher = case(SamplerKind::InterpolatedMirror, f64::from(0.2f32));
        let smoother = Case { smoothness: 0.21, ..rougher };
        let sharp = case(SamplerKind::InterpolatedMirror, f64::from(0.7f32));
        let tilted = Case { wo: (sharp.wo + DVec3::new(0.02, 0.0, 0.01)).normalize(), ..sharp };
        for (drawn, stated) in [(cosine, uniform), (uniform, cosine), (rougher, smoother), (sharp, tilted)] {
            let p = test_against(&device, &drawn, &mut Pcg::new(99), &|w| stated.density(w)).p_value;
            assert!(p < 1e-9, "{}: {drawn:?} passes for {stated:?} with p = {p}", device.label);
        }
    });
}

/// Densities of the device are those of double precision wherever rounding leaves them digits, and the density that
/// comes with a sample is the density of that sample, to the bit.
#[test]
fn densities_are_those_of_double_precision() {
    for_each_device(|device| {
        for (i, case) in cases().iter().enumerate() {
            let count = 20_000;
            let random = &mut Pcg::new(1000 + i as u64);
            let samples = device.ask(&anywhere(), Probe::Sample, &sample_questions(case, count, random));
            let drawn = samples.iter().map(|s| Vec3::from_slice(&s[0]).as_dvec3());
            // The tested directions include some that are not drawn, most of them improbable or impossible.
            let disk = case.kind as u32 == SamplerKind::UniformDisk as u32;
            let anywhere_else =
                (0..count).map(|_| random.direction() * if disk { DVec3::new(1.2, 1.2, 0.0) } else { DVec3::ONE });
            let points: Vec<_> = drawn.chain(anywhere_else.map(|w| w.as_vec3().as_dvec3())).collect();
            let questions: Vec<_> = points.iter().map(|w| density_question(case, *w)).collect();
            let answers = device.ask(&anywhere(), Probe::Density, &questions);
            for (sample, answer) in samples.iter().zip(&answers) {
                let (with, of) = (sample[0][3], answer[0][0]);
                assert!(
                    with.to_bits() == of.to_bits(),
                    "{}: {case:?}: {with} comes with a sample of {of}",
                    device.label
                );
            }
            let unsure = |w: &DVec3| {
                let (cosine, edge) = (case.n.dot(*w), if disk { w.length_squared() - 1.0 } else { 1.0 });
                cosine.abs() < 1e-6 || edge.abs() < 1e-6
            };
            for (w, answer) in points.iter().zip(&answers).filter(|(w, _)| !unsure(w)) {
                let (expected, found) = (case.density(*w), f64::from(answer[0][0]));
                let near = (found - expected).abs() <= case.tolerance(*w);
                assert!(near, "{}: {case:?} at {w}: expected {expected}, found {found}", device.label);
            }
        }
    });
}

/// Densities in double precision integrate to 1: none of the light is lost or made, but for what ends between rough
/// facets.
#[test]
fn densities_integrate_to_one() {
    for case in cases() {
        let total: f64 = integrals(&case.chart(), &|w| case.density(w)).iter().sum();
        let near = (total - 1.0).abs() < 1e-4 || case.loses() && (0.5..1.0).contains(&total);
        assert!(near, "{case:?}: expected 1, found {total}");
    }
}
