//! Closed forms of the principled material where it is something simple: in double precision, by the textbook.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use glam::{DMat3, DVec3, Vec3};
use raggio_tests::{Pcg, TestDevice, for_each_device};

use super::{Closure, Sample, WHITE, incident};
use crate::samplers::microfacets::{Facets, fresnel};

/// Draws samples whose fourth number, which chooses between reflection and refraction, is spread evenly.
fn spread(device: &TestDevice, closure: &Closure, wo: Vec3) -> Vec<Sample> {
    let numbers: Vec<_> = (0..1000).map(|i| [0.3, 0.6, 0.5, (i as f32 + 0.5) / 1000.0]).collect();
    closure.ask_samples(device, wo, &numbers)
}

#[test]
fn smooth_glass_is_fresnels_and_snells() {
    for_each_device(|device| {
        for eta in [1.0 / 1.5f32, 1.5, 1.0 / 2.4, 2.4, 1.0 / 1.05] {
            for cosine in [1.0, 0.8, 0.5, 0.1] {
                let (wo, glass) = (incident(cosine), Closure { roughness: 0.0, transmission: 1.0, eta, ..WHITE });
                let samples = spread(&device, &glass, wo);
                let what = format!("{}: eta {eta}, cosine {cosine}", device.label);
                let reflected = samples.iter().filter(|s| !s.transmitted).count() as f64 / 1000.0;
                let expected = fresnel(f64::from(cosine), f64::from(eta));
                assert!((reflected - expected).abs() < 1.1e-3, "{what}: {reflected} reflected, not {expected}");
                for s in &samples {
                    let weight = if s.transmitted { eta * eta } else { 1.0 };
                    assert!((s.weight - weight).abs().max_element() < 1e-4 * weight, "{what}: {s:?}");
                    let tangents = if s.transmitted { eta } else { 1.0 };
                    let across = s.wi.truncate() + tangents * wo.truncate();
                    assert!(across.length() < 1e-5 && s.wi.is_normalized(), "{what}: {s:?}");
                }
            }
        }
    });
}

#[test]
fn smooth_metal_is_schlicks() {
    let color = Vec3::new(0.9, 0.5, 0.1);
    let metal = Closure { base_color: color, roughness: 0.0, metallic: 1.0, ..WHITE };
    for_each_device(|device| {
        for cosine in [1.0f32, 0.6, 0.1] {
            let expected = color + (1.0 - color) * (1.0 - cosine).powi(5);
            for s in spread(&device, &metal, incident(cosine)) {
                assert!(s.delta && (s.weight - expected).abs().max_element() < 1e-5, "{}: {s:?}", device.label);
            }
        }
    });
}

#[test]
fn smooth_sheets_do_not_bend() {
    let sheet = Closure { roughness: 0.0, transmission: 1.0, thin_walled: true, ..WHITE };
    for_each_device(|device| {
        let wo = incident(0.4);
        let samples = spread(&device, &sheet, wo);
        let through: Vec<_> = samples.iter().filter(|s| s.transmitted).collect();
        assert!(through.len() > 800, "{}: {} pass", device.label, through.len());
        assert!(through.iter().all(|s| (s.wi + wo).length() < 1e-6 && (s.weight - 1.0).length() < 1e-5));
    });
}

/// Diffuse light without specular reflection is Lambert's, on both sides.
#[test]
fn diffuse_light_is_lamberts() {
    let leaf = Closure {
        base_color: Vec3::new(0.8, 0.4, 0.2),
        specular: 0.0,
        diffuse_transmission: 0.25,
        diffuse_transmission_color: Vec3::new(0.1, 0.9, 0.3),
        thin_walled: true,
        ..WHITE
    };
    for_each_device(|device| {
        let mut random = Pcg::new(3);
        let pairs: Vec<_> = (0..1000).map(|_| (incident(0.6), random.direction().as_vec3())).collect();
        for ((_, wi), (value, _)) in pairs.iter().zip(leaf.eval(&device, &pairs)) {
            let color = if wi.z > 0.0 { 0.75 * leaf.base_color } else { 0.25 * leaf.diffuse_transmission_color };
            let expected = color * wi.z.abs() * FRAC_1_PI as f32;
            assert!((value - expected).abs().max_element() < 1e-5, "{}: {wi}: {value}", device.label);
        }
    });
}

/// Compares directions above the surface with what double precision says of them.
fn assert_brdf(what: &str, closure: &Closure, expected: &dyn Fn(DVec3, DVec3) -> f64) {
    for_each_device(|device| {
        let mut random = Pcg::new(4);
        let mut upward = || {
            let w = random.direction().as_vec3();
            w.with_z(w.z.abs().max(0.02)).normalize()
        };
        let pairs: Vec<_> = (0..5000).map(|_| (upward(), upward())).collect();
        for ((wo, wi), (value, _)) in pairs.iter().zip(closure.eval(&device, &pairs)) {
            let expected = expected(wo.as_dvec3().normalize(), wi.as_dvec3().normalize());
            let near = (value.as_dvec3() - expected).abs().max_element() <= 2e-4 * expected.max(1e-3);
            assert!(near, "{}: {what} from {wo} to {wi}: {value} instead of {expected}", device.label);
        }
    });
}

/// Reflection by microfacets: F D G / 4 cos, heights correlated.
fn reflection(facets: Facets, eta: f64, wo: DVec3, wi: DVec3) -> f64 {
    let m = (wo + wi).normalize();
    let lambda = |w: DVec3| 1.0 / facets.masking(w) - 1.0;
    let both = 1.0 / (1.0 + lambda(wo) + lambda(wi));
    fresnel(wo.dot(m), eta) * facets.distribution(m) * both / (4.0 * wo.z)
}

#[test]
fn black_plastic_is_its_microfacets() {
    for (roughness, anisotropy) in [(0.3, 0.0), (1.0, 0.0), (0.4, 0.7)] {
        let plastic = Closure { base_color: Vec3::ZERO, roughness, anisotropy, ..WHITE };
        let facets = Facets { alpha: plastic.alpha().map(f64::from) };
        let eta = f64::from(plastic.eta);
        assert_brdf("black plastic", &plastic, &|wo, wi| reflection(facets, eta, wo, wi));
    }
}

#[test]
fn coat_over_nothing_is_its_microfacets() {
    let coat = Closure { base_color: Vec3::ZERO, specular: 0.0, clearcoat: 0.7, clearcoat_roughness: 0.5, ..WHITE };
    let facets = Facets { alpha: [0.25; 2] };
    assert_brdf("coat", &coat, &|wo, wi| 0.7 * reflection(facets, 1.0 / 1.5, wo, wi));
}

/// Sheen has the distribution and masking of KHR_materials_sheen.
#[test]
fn sheen_over_nothing_is_charlies() {
    let alpha = f64::from(0.6f32).powi(2);
    let k = (1.0 - alpha).powi(2);
    let mix = |low: f64, high: f64| low + (high - low) * k;
    let curve = |x: f64| {
        let b = 1.0 + mix(3.82987, 3.32435) * x.powf(mix(0.19823, 0.16801));
        mix(21.5473, 25.3245) / b + mix(-1.97760, -1.27393) * x + mix(-4.32054, -4.85967)
    };
    let lambda = |c: f64| if c < 0.5 { curve(c).exp() } else { (2.0 * curve(0.5) - curve(1.0 - c)).exp() };
    let velvet =
        Closure { base_color: Vec3::ZERO, specular: 0.0, sheen_color: Vec3::ONE, sheen_roughness: 0.6, ..WHITE };
    assert_brdf("sheen", &velvet, &|wo, wi| {
        let m = (wo + wi).normalize();
        let distribution = (2.0 + 1.0 / alpha) * (1.0 - m.z * m.z).powf(0.5 / alpha) / TAU;
        distribution / (4.0 * wo.z * (1.0 + lambda(wo.z) + lambda(wi.z)))
    });
}

/// Reflectance of a film on metal: all its reflections by Airy's formula, wavelength by wavelength, and then what the
/// eye makes of it. The eye's Gaussians and the reflectances of the two boundaries are those of
/// KHR_materials_iridescence.
fn airy(f0: f64, ior: f64, thickness: f64, cosine: f64, channel: usize) -> f64 {
    let schlick = |r: f64, c: f64| r + (1.0 - r) * (1.0 - c).powi(5);
    let boundary = |ratio: f64| ((ratio - 1.0) / (ratio + 1.0)).powi(2);
    let inside = (1.0 - (1.0 - cosine * cosine) / (ior * ior)).sqrt();
    let root = (f0 + 1e-4).sqrt();
    let base = (1.0 + root) / (1.0 - root);
    let (upper, lower) = (schlick(boundary(ior), cosine), schlick(boundary(base / ior), inside));
    let shift = PI + if base < ior { PI } else { 0.0 };

    // `steady` is the mean over phases; each wave number (per metre) has something beyond it.
    let steady = upper + (1.0 - upper).powi(2) * lower / (1.0 - upper * lower);
    let amplitude = (upper * lower).sqrt();
    let beyond = |wave_number: f64| {
        let phase = (TAU * 2.0 * ior * thickness * 1e-9 * inside * wave_number + shift).cos();
        let turned = 1.0 + amplitude * amplitude - 2.0 * amplitude * phase;
        1.0 - (1.0 - upper) * (1.0 - lower) / turned - steady
    };
    // The Gaussians of X (two), Y and Z have a height, a place and a width each.
    let gaussians = [
        (0, 5.4856e-13, 1.6810e6, 4.3278e9),
        (0, 9.7470e-14, 2.2399e6, 4.5282e9),
        (1, 4.4201e-13, 1.7953e6, 9.3046e9),
        (2, 5.2481e-13, 2.2084e6, 6.6121e9),
    ];
    let mut xyz = DVec3::ZERO;
    for (i, height, place, width) in gaussians {
        let step = 200.0;
        for k in -5000..5000 {
            let x = f64::from(k) * step;
            let gaussian = height / 2f64.sqrt() * (-x * x / (4.0 * width)).exp();
            xyz[i] += gaussian * beyond(place + x) * step / 1.0685e-7;
        }
    }
    let rgb = DMat3::from_cols_array(&[
        3.2404542, -0.9692660, 0.0556434, -1.5371385, 1.8760108, -0.2040259, -0.4985314, 0.0415560, 1.0572252,
    ]) * xyz;
    (steady + rgb[channel]).clamp(0.0, 1.0)
}

#[test]
fn films_on_metal_are_airys() {
    // All channels have a larger index than the films, so that every channel has one shift of phase.
    let color = Vec3::new(0.6, 0.3, 0.15);
    for_each_device(|device| {
        let mut colors: Vec<Vec3> = vec![];
        for (ior, thickness) in [(1.3, 400.0), (1.3, 150.0), (1.6, 300.0), (1.9, 550.0)] {
            let metal = Closure {
                base_color: color,
                metallic: 1.0,
                roughness: 0.0,
                iridescence: 1.0,
                iridescence_ior: ior,
                iridescence_thickness: thickness,
                ..WHITE
            };
            for cosine in [1.0f32, 0.7, 0.3] {
                let found = spread(&device, &metal, incident(cosine))[0].weight;
                let airy = |channel: usize| {
                    let (ior, thickness) = (f64::from(ior), f64::from(thickness));
                    airy(f64::from(color[channel]), ior, thickness, f64::from(cosine), channel) as f32
                };
                let expected = Vec3::from_array([0, 1, 2].map(airy));
                // The kernels' sum ends after the second order: the third is the cube of the amplitude.
                let what = format!("{}: index {ior}, {thickness} nm, cosine {cosine}", device.label);
                assert!((found - expected).abs().max_element() < 0.03, "{what}: {found} instead of {expected}");
                colors.push(found);
            }
        }
        let spread = |c: usize| {
            let values = colors.iter().map(|color| color[c]);
            values.clone().fold(0f32, f32::max) - values.fold(1f32, f32::min)
        };
        assert!((0..3).all(|c| spread(c) > 0.2), "{}: films have no colours: {colors:?}", device.label);
    });
}
