//! Scrambled Sobol' points: even where they should be, random where they may be.

use raggio_render::Sequence;
use raggio_tests::statistics::Verdict;
use raggio_tests::{Pcg, for_each_device};

use crate::samplers::numbers::{Key, numbers, test_lanes, test_pairs};

/// Pairs of lanes, each with the least t for which 2^m points hold equally many in each box of 2^t points.
const PAIRS: [(usize, usize, u32); 6] = [(0, 1, 0), (0, 2, 1), (1, 2, 1), (0, 3, 2), (1, 3, 2), (2, 3, 3)];

/// Whether each of 2^a by 2^b boxes holds equally many of the points.
fn evenly(points: &[[f32; 4]], (first, a): (usize, u32), (second, b): (usize, u32)) -> bool {
    let mut counts = vec![0; 1 << (a + b)];
    let cell = |u: f32, digits: u32| (u * (1u32 << digits) as f32) as usize;
    points.iter().for_each(|p| counts[(cell(p[first], a) << b) + cell(p[second], b)] += 1);
    counts.iter().all(|count| *count == points.len() >> (a + b))
}

/// Any aligned run of 2^m samples of any pixel, in any dimension, is a net: lanes 0 and 1 are a (0, m, 2)-net, the
/// other pairs as near to one as Sobol's construction comes.
#[test]
fn powers_of_two_are_nets() {
    for_each_device(|device| {
        let random = &mut Pcg::new(11);
        for m in 1..=11 {
            let [x, y] = [random.bits() & 0xffff, random.bits() & 0xffff];
            let (seed, dimension, run) = (random.bits(), random.bits() % 64, random.bits() % 1000);
            let keys: Vec<Key> = (0..1 << m).map(|i| [x, y, (run << m) + i, seed, dimension]).collect();
            let points = numbers(&device, Sequence::Sobol, &keys);
            for (first, second, t) in PAIRS {
                let digits = u32::saturating_sub(m, t);
                for a in 0..=digits {
                    let even = evenly(&points, (first, a), (second, digits - a));
                    assert!(even, "{}: lanes {first} and {second} of 2^{m} points: {a} digits", device.label);
                }
            }
        }
    });
}

/// Every number is uniform over seeds; and independent of the point's others, of the pixel's in other dimensions, and,
/// past the first two digits, of the neighbours'.
#[test]
fn points_are_uniform_and_dimensions_independent() {
    for_each_device(|device| {
        let seeds = 1u32 << device.pick(19, 18);
        let mut verdict = Verdict::default();
        let at = |x: u32, y: u32, sample: u32, dimension: u32| -> Vec<[f32; 4]> {
            let keys: Vec<Key> = (0..seeds).map(|seed| [x, y, sample, seed, dimension]).collect();
            numbers(&device, Sequence::Sobol, &keys)
        };
        let own = at(37, 21, 5, 2);
        test_lanes(&own, &mut verdict);
        for (a, b, _) in PAIRS {
            test_pairs(format!("lanes {a} and {b}"), own.iter().map(|n| (n[a], n[b])), &mut verdict);
        }
        let later = at(37, 21, 5, 3);
        let fine = |u: f32| (4.0 * u).fract();
        let neighbours = [("right", at(38, 21, 5, 2)), ("below", at(37, 22, 5, 2)), ("far away", at(900, 4000, 5, 2))];
        for lane in 0..4 {
            for other in [lane, (lane + 1) % 4] {
                let pairs = own.iter().zip(&later).map(|(a, b)| (a[lane], b[other]));
                test_pairs(format!("lane {lane} and lane {other} of the next dimension"), pairs, &mut verdict);
                for (place, next) in &neighbours {
                    let pairs = own.iter().zip(next).map(|(a, b)| (fine(a[lane]), fine(b[other])));
                    test_pairs(format!("lane {lane} and lane {other} of the pixel {place}"), pairs, &mut verdict);
                }
            }
        }
        println!("{}: the least p-value is {:.2e}", device.label, verdict.least());
        verdict.assert_all();
    });
}

/// Pairs from two dimensions are independent, over the pixels and samples of one picture.
#[test]
fn dimensions_of_one_picture_are_independent() {
    for_each_device(|device| {
        let keys = |dimension: u32| -> Vec<Key> {
            (0..1u32 << 17).map(|i| [i & 63, (i >> 6) & 63, i >> 12, 7, dimension]).collect()
        };
        let dimensions = [0, 1, 2, 9].map(|dimension| numbers(&device, Sequence::Sobol, &keys(dimension)));
        let mut verdict = Verdict::default();
        for (a, b) in [(0, 1), (0, 2), (1, 2), (2, 3), (0, 3)] {
            for lane in 0..4 {
                for other in 0..4 {
                    let pairs = dimensions[a].iter().zip(&dimensions[b]).map(|(a, b)| (a[lane], b[other]));
                    test_pairs(format!("lane {lane} of {a} and lane {other} of {b}"), pairs, &mut verdict);
                }
            }
        }
        verdict.assert_all();
    });
}

/// Errors of the pixels of a 64 x 64 picture of `integrand`, whose mean is `exact`, after `samples` samples.
fn errors(points: &[[f32; 4]], samples: usize, integrand: impl Fn(&[f64; 4]) -> f64, exact: f64) -> Vec<f64> {
    let value = |p: &[f32; 4]| integrand(&p.map(f64::from));
    points.chunks(samples).map(|pixel| pixel.iter().map(value).sum::<f64>() / samples as f64 - exact).collect()
}

fn mean_square(errors: &[f64]) -> f64 {
    errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64
}

fn pixels(samples: u32, dimension: u32) -> Vec<Key> {
    let places = (0..64).flat_map(|y| (0..64).map(move |x| [x, y]));
    places.flat_map(|[x, y]| (0..samples).map(move |sample| [x, y, sample, 3, dimension])).collect()
}

/// Smooth integrands gain: the squared error of independent numbers falls with 1 / N, that of scrambled nets with 1 /
/// N^3 but for logarithms; in four dimensions the gain is smaller for as few points.
#[test]
fn smooth_integrands_converge_faster() {
    for_each_device(|device| {
        let pair = |u: &[f64; 4]| (u[0] * (1.0 + u[1])).exp();
        // The mean is the integral of (e^(1 + y) - 1) / (1 + y): the series of the exponential integral, term by term.
        let exact_pair = (1..30).scan(1.0, |factorial, k| {
            *factorial *= f64::from(k);
            Some((2f64.powi(k) - 1.0) / (f64::from(k) * *factorial))
        });
        let all = |u: &[f64; 4]| u.iter().map(|u| 0.5 + u).product::<f64>();
        let squared = |sequence, samples: u32| {
            let points = numbers(&device, sequence, &pixels(samples, 1));
            let exact_pair = exact_pair.clone().sum();
            let of = |errors: Vec<f64>| mean_square(&errors);
            let samples = samples as usize;
            [of(errors(&points, samples, pair, exact_pair)), of(errors(&points, samples, all, 1.0))]
        };
        let samples = device.pick(256, 64);
        let (independent, sobol) = (squared(Sequence::Pcg, samples), squared(Sequence::Sobol, samples));
        let gain = [independent[0] / sobol[0], independent[1] / sobol[1]];
        println!("{}: {samples} samples, squared error smaller by {gain:.0?}", device.label);
        let expected = device.pick([5000.0, 500.0], [400.0, 80.0]);
        assert!(gain[0] > expected[0] && gain[1] > expected[1], "expected {expected:?}, found {gain:?}");
    });
}

/// Variance of the mean of blocks of 8 x 8 pixels, in parts of what it is if the pixels know nothing of each other.
fn coarse_share(errors: &[f64]) -> f64 {
    let block =
        |left: usize, top: usize| (0..64).map(|i| errors[(top + i / 8) * 64 + left + i % 8]).sum::<f64>() / 64.0;
    // Blocks of the Z-curve itself begin at multiples of 8.
    let blocks: Vec<_> = (3..56).step_by(8).flat_map(|y| (3..56).step_by(8).map(move |x| block(x, y))).collect();
    64.0 * mean_square(&blocks) / mean_square(errors)
}

/// Errors of neighbours make up for one another after one sample.
#[test]
fn few_samples_make_blue_noise() {
    for_each_device(|device| {
        for sequence in Sequence::ALL {
            let share = |dimension| {
                let points = numbers(&device, sequence, &pixels(1, dimension));
                coarse_share(&errors(&points, 1, |u| u[0] * u[1], 0.25))
            };
            let share = (0..16).map(share).sum::<f64>() / 16.0;
            println!("{}: {sequence:?}: {share:.2}", device.label);
            let fits = if sequence == Sequence::Sobol { share < 0.6 } else { (0.8..1.25).contains(&share) };
            assert!(fits, "{}: {sequence:?}: expected less than 0.6 or about 1, found {share}", device.label);
        }
    });
}
