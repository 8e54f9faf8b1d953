//! Rough surfaces: their densities in double precision, and what light they return.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use raggio_kernels::SamplerKind;
use raggio_render::{Probe, Question};
use raggio_tests::{Pcg, TestDevice, for_each_device};

use crate::samplers::anywhere;

/// Distribution of GGX in its local frame, by the textbook.
#[derive(Clone, Copy, Debug)]
pub struct Facets {
    pub alpha: [f64; 2],
}

impl Facets {
    /// Normal squeezed from the hemisphere that the facets are stretched to; not normalised.
    pub fn squeezed(&self, h: f64, phi: f64) -> DVec3 {
        let r = (1.0 - h * h).max(0.0).sqrt();
        DVec3::new(self.alpha[0] * r * phi.cos(), self.alpha[1] * r * phi.sin(), h)
    }

    pub fn stretched(&self, m: DVec3) -> DVec3 {
        DVec3::new(m.x / self.alpha[0], m.y / self.alpha[1], m.z).normalize()
    }

    pub fn distribution(&self, m: DVec3) -> f64 {
        let [ax, ay] = self.alpha;
        let slopes = (m.x / m.z / ax).powi(2) + (m.y / m.z / ay).powi(2);
        if m.z <= 0.0 { 0.0 } else { 1.0 / (PI * ax * ay * m.z.powi(4) * (1.0 + slopes).powi(2)) }
    }

    pub fn masking(&self, w: DVec3) -> f64 {
        let tangent2 = ((self.alpha[0] * w.x).powi(2) + (self.alpha[1] * w.y).powi(2)) / (w.z * w.z);
        2.0 / (1.0 + (1.0 + tangent2).sqrt())
    }

    pub fn visible(&self, wo: DVec3, m: DVec3) -> f64 {
        self.distribution(m) * self.masking(wo) * wo.dot(m).max(0.0) / wo.z
    }

    pub fn reflected(&self, wo: DVec3, wi: DVec3) -> f64 {
        let m = (wo + wi).normalize();
        self.visible(wo, m) / (4.0 * wo.dot(m))
    }

    /// Density by Walter's half vectors and Jacobians, with indices eta on the side of wo and 1 on the other.
    pub fn dielectric(&self, wo: DVec3, wi: DVec3, eta: f64) -> f64 {
        if wi.z == 0.0 {
            return 0.0;
        }
        let across = if wi.z > 0.0 { wo + wi } else { eta * wo + wi };
        let m = across.normalize() * across.z.signum();
        let (o, i) = (wo.dot(m), wi.dot(m));
        if o <= 0.0 || (i > 0.0) != (wi.z > 0.0) {
            return 0.0;
        }
        if wi.z > 0.0 {
            fresnel(o, eta) * self.visible(wo, m) / (4.0 * o)
        } else {
            (1.0 - fresnel(o, eta)) * self.visible(wo, m) * i.abs() / (i + eta * o).powi(2)
        }
    }

    /// Change of the density of wi (`eta` 1: reflected) or of a normal (none) by a rounding, absolutely: the normal is
    /// a difference where the light is bent little, and the distribution as steep as alpha is small.
    pub fn condition(&self, wo: DVec3, w: DVec3, eta: Option<f64>, dielectric: Option<f64>) -> f64 {
        let across = eta.map_or(w, |eta| eta * wo + w);
        let amplified = 1.0 / across.length().max(1e-9);
        let m = across * amplified * across.z.signum();
        // Facets here are on edge: there are some on one side, and none on the other.
        if m.z.abs() < 1e-5 * amplified.max(1.0) {
            return f64::INFINITY;
        }
        let steepness = 4.0 + 4.0 * amplified / self.alpha[0].min(self.alpha[1]) + 1.0 / wo.z;
        let (o, i) = (wo.dot(m), w.dot(m));
        let fresnel = match eta {
            None => return steepness * self.visible(wo, m) + self.distribution(m) / wo.z,
            Some(_) if dielectric.is_none() => return steepness * self.reflected(wo, w),
            // Near the critical angle what is reflected hangs on a difference.
            Some(1.0) => {
                let inner2 = 1.0 - dielectric.unwrap_or(1.0).powi(2) * (1.0 - o * o);
                40.0 * amplified / inner2.abs().max(1e-7)
            }
            Some(_) => 40.0 * amplified / (i * i).max(1e-9),
        };
        let scale =
            self.distribution(m) * self.masking(wo) / wo.z * if eta == Some(1.0) { 1.0 } else { amplified.powi(2) };
        (steepness + fresnel) * scale * o.abs().max(1e-3)
    }
}

pub fn fresnel(cosine: f64, eta: f64) -> f64 {
    let sine2 = eta * eta * (1.0 - cosine * cosine);
    if sine2 >= 1.0 {
        return 1.0;
    }
    let inner = (1.0 - sine2).sqrt();
    let s = (eta * cosine - inner) / (eta * cosine + inner);
    let p = (cosine - eta * inner) / (cosine + eta * inner);
    (s * s + p * p) / 2.0
}

/// Facets of the principled material, of metal or of glass.
#[derive(Clone, Copy, Debug)]
struct Lobe {
    metal: bool,
    alpha: [f32; 2],
    /// Reflectance at normal incidence of a mirror, or eta of a dielectric.
    detail: f32,
}

impl Lobe {
    fn metal(alpha: [f32; 2], detail: f32) -> Self {
        Self { metal: true, alpha, detail }
    }

    fn glass(alpha: f32, detail: f32) -> Self {
        Self { metal: false, alpha: [alpha; 2], detail }
    }

    fn question(&self, wo: Vec3, wi: Vec3) -> Question {
        let parameters = [self.alpha[0], self.alpha[1], self.detail, 0.0];
        [[f32::from(u8::from(self.metal)), wi.x, wi.y, wi.z], parameters, wo.extend(0.0).to_array()]
    }

    /// (value, pdf) of each pair, without the squared ratio of indices.
    fn ask(&self, device: &TestDevice, pairs: &[(Vec3, Vec3)]) -> Vec<[f64; 2]> {
        let questions: Vec<_> = pairs.iter().map(|(wo, wi)| self.question(*wo, *wi)).collect();
        let answers = device.ask(&anywhere(), Probe::Facets, &questions);
        answers.iter().map(|a| [a[0][0], a[0][1]].map(f64::from)).collect()
    }

    /// Weight of a sample in direction wi: the light that facets reflect or let through, as far as both directions see them.
    fn weight(&self, wo: DVec3, wi: DVec3) -> f64 {
        let facets = Facets { alpha: self.alpha.map(f64::from) };
        let (there, back) = (1.0 / facets.masking(wo) - 1.0, 1.0 / facets.masking(wi) - 1.0);
        let seen = (1.0 + there) / (1.0 + if wi.z > 0.0 { there + back } else { there.max(back) });
        match self.metal {
            true if wi.z < 0.0 => 0.0,
            true => {
                let (f0, cosine) = (f64::from(self.detail), wo.dot((wo + wi).normalize()));
                seen * (f0 + (1.0 - f0) * (1.0 - cosine).powi(5))
            }
            false => seen,
        }
    }

    /// Draws directions with stratified numbers; zero vectors where none was found.
    fn sample(&self, device: &TestDevice, wo: Vec3) -> Vec<Vec3> {
        const SIDE: u32 = 128;
        let mut random = Pcg::new(7);
        let (kind, detail) = match self.metal {
            true => (SamplerKind::RoughMirror, self.alpha[1]),
            false => (SamplerKind::RoughGlass, self.detail),
        };
        let mut question = |i: u32| -> Question {
            let place = |cell: u32, random: &mut Pcg| (cell as f32 + random.unit()) / SIDE as f32;
            let (x, y) = (place(i % SIDE, &mut random), place(i / SIDE, &mut random).min(0.999_999));
            let parameters = [kind as u32 as f32, x.min(0.999_999), y, self.alpha[0]];
            [parameters, [0.0, 0.0, 1.0, random.unit()], wo.extend(detail).to_array()]
        };
        let questions: Vec<_> = (0..SIDE * SIDE).map(&mut question).collect();
        let answers = device.ask(&anywhere(), Probe::Sample, &questions);
        answers.iter().map(|a| Vec3::from_slice(&a[0])).collect()
    }
}

fn incident(cosine: f32) -> Vec3 {
    let across = (1.0 - cosine * cosine).sqrt();
    Vec3::new(0.8 * across, 0.6 * across, cosine)
}

fn upward(random: &mut Pcg) -> Vec3 {
    let w = random.direction().as_vec3();
    w.with_z(w.z.abs().max(0.01)).normalize()
}

/// Light goes both ways alike: f(wo, wi) = f(wi, wo), each over the squared index on the side where light arrives. Whole
/// materials squeeze radiance, so theirs are over that on the side where it leaves.
#[test]
fn rough_surfaces_are_reciprocal() {
    let lobes = [
        Lobe::metal([0.0025; 2], 0.9),
        Lobe::metal([0.3; 2], 0.04),
        Lobe::metal([0.1, 0.7], 0.5),
        Lobe::glass(0.09, 1.5),
        Lobe::glass(0.3, 1.0 / 1.5),
        Lobe::glass(1.0, 1.33),
    ];
    for_each_device(|device| {
        for lobe in lobes {
            let mut random = Pcg::new(5);
            let mut nonzero = 0;
            for below in [false, true] {
                if below && lobe.metal {
                    continue;
                }
                let flip = |w: Vec3| if below { w.with_z(-w.z) } else { w };
                let pairs: Vec<_> = (0..20_000).map(|_| (upward(&mut random), flip(upward(&mut random)))).collect();
                let back: Vec<_> = pairs.iter().map(|(wo, wi)| (flip(*wi), flip(*wo))).collect();
                let (scale, other) = if below {
                    (f64::from(lobe.detail).powi(2), Lobe { detail: 1.0 / lobe.detail, ..lobe })
                } else {
                    (1.0, lobe)
                };
                let answers = lobe.ask(&device, &pairs);
                for (((wo, wi), there), back) in pairs.iter().zip(&answers).zip(other.ask(&device, &back)) {
                    let (there, back) = (scale * there[0] / f64::from(wi.z.abs()), back[0] / f64::from(wo.z));
                    // Near the critical angle what is transmitted hangs on a difference.
                    let m = if below { lobe.detail * *wo + *wi } else { *wo + *wi }.normalize();
                    let least = f64::from(wo.dot(m).abs().min(wi.dot(m).abs()));
                    let allowed = if below { 2e-3 + 2e-6 / (least * least) } else { 2e-3 };
                    let near = (there - back).abs() <= allowed * there.max(back).max(1e-4);
                    assert!(near, "{}: {lobe:?} from {wo} to {wi}: {there}, but back {back}", device.label);
                    nonzero += u32::from(there > 0.0);
                }
            }
            assert!(nonzero > 1000, "{}: {lobe:?} scatters nothing", device.label);
        }
    });
}

/// Value and density are apart by what facets do with light, and by how many of them both directions see.
#[test]
fn values_over_densities_are_weights() {
    for_each_device(|device| {
        for lobe in [
            Lobe::metal([0.0025; 2], 0.9),
            Lobe::metal([0.1, 0.7], 0.5),
            Lobe::metal([1.0; 2], 1.0),
            Lobe::glass(0.09, 1.5),
            Lobe::glass(0.5, 1.0 / 1.5),
        ] {
            for cosine in [1.0, 0.6, 0.05] {
                let wo = incident(cosine);
                let found = lobe.sample(&device, wo).into_iter().filter(|wi| wi.z != 0.0);
                let pairs: Vec<_> = found.map(|wi| (wo, wi)).collect();
                for ((_, wi), [value, pdf]) in pairs.iter().zip(lobe.ask(&device, &pairs)) {
                    let weight = lobe.weight(wo.as_dvec3(), wi.as_dvec3());
                    let near = (value - weight * pdf).abs() <= 1e-4 * value.max(1e-3);
                    assert!(near, "{}: {lobe:?}, {wo} to {wi}: {value} / {pdf} is not {weight}", device.label);
                }
            }
        }
    });
}

/// Rough glass makes no light, and loses little while it is smooth.
#[test]
fn rough_glass_makes_no_light() {
    for_each_device(|device| {
        for (alpha, least) in [(0.0025, 0.98), (0.09, 0.8), (0.5, 0.6), (1.0, 0.4)] {
            for eta in [1.5f32, 1.0 / 1.5, 1.33] {
                let lobe = Lobe::glass(alpha, eta);
                for cosine in [1.0, 0.7, 0.3, 0.05] {
                    let wo = incident(cosine);
                    let sampled = lobe.sample(&device, wo);
                    let pairs: Vec<_> = sampled.iter().filter(|wi| wi.z != 0.0).map(|wi| (wo, *wi)).collect();
                    let weights = lobe.ask(&device, &pairs).into_iter().map(|[value, pdf]| value / pdf);
                    let energy = weights.sum::<f64>() / sampled.len() as f64;
                    let what = format!("{}: alpha {alpha}, eta {eta}, cosine {cosine}", device.label);
                    assert!((least..1.0001).contains(&energy), "{what}: {energy} of the light goes on");
                }
            }
        }
    });
}
