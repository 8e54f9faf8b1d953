//! The principled material: its lobes alone and mixed, on every device.

mod closed_forms;
mod densities;
mod furnace;
mod reciprocity;

use glam::Vec3;
use raggio_render::{Answer, Probe, Question};
use raggio_tests::TestDevice;

use crate::samplers::anywhere;

/// Arguments of a material at a point, `PrincipledClosure` of the kernels.
#[derive(Clone, Copy, Debug)]
pub struct Closure {
    base_color: Vec3,
    metallic: f32,
    /// Perceptual roughness.
    roughness: f32,
    anisotropy: f32,
    specular: f32,
    specular_color: Vec3,
    /// Refractive index on the side of wo over the other side's.
    eta: f32,
    transmission: f32,
    thin_walled: bool,
    outside: bool,
    diffuse_transmission: f32,
    diffuse_transmission_color: Vec3,
    clearcoat: f32,
    clearcoat_roughness: f32,
    clearcoat_normal: Vec3,
    sheen_color: Vec3,
    sheen_roughness: f32,
    iridescence: f32,
    iridescence_ior: f32,
    iridescence_thickness: f32,
}

/// Closure of white plastic.
const WHITE: Closure = Closure {
    base_color: Vec3::ONE,
    metallic: 0.0,
    roughness: 0.5,
    anisotropy: 0.0,
    specular: 1.0,
    specular_color: Vec3::ONE,
    eta: 1.0 / 1.5,
    transmission: 0.0,
    thin_walled: false,
    outside: true,
    diffuse_transmission: 0.0,
    diffuse_transmission_color: Vec3::ONE,
    clearcoat: 0.0,
    clearcoat_roughness: 0.0,
    clearcoat_normal: Vec3::Z,
    sheen_color: Vec3::ZERO,
    sheen_roughness: 0.5,
    iridescence: 0.0,
    iridescence_ior: 1.3,
    iridescence_thickness: 400.0,
};

/// Result of `PrincipledClosure.sample`.
#[derive(Clone, Copy, Debug)]
struct Sample {
    wi: Vec3,
    weight: Vec3,
    pdf: f32,
    transmitted: bool,
    delta: bool,
}

impl Sample {
    /// Whether light goes on at all.
    fn found(&self) -> bool {
        self.weight != Vec3::ZERO
    }
}

impl Closure {
    /// Widths of the slopes along x and y, as glTF has them.
    fn alpha(&self) -> [f32; 2] {
        let alpha = self.roughness * self.roughness;
        [alpha + (1.0 - alpha) * self.anisotropy * self.anisotropy, alpha]
    }

    fn questions(&self) -> [Question; 3] {
        let flag = |b: bool| f32::from(u8::from(b));
        let [x, y] = self.alpha();
        let alpha_of_coat = self.clearcoat_roughness * self.clearcoat_roughness;
        [
            [
                self.base_color.extend(self.metallic).to_array(),
                [x, y, self.specular, self.eta],
                self.specular_color.extend(self.transmission).to_array(),
            ],
            [
                [flag(self.thin_walled), flag(self.outside), self.diffuse_transmission, self.clearcoat],
                self.diffuse_transmission_color.extend(alpha_of_coat).to_array(),
                self.clearcoat_normal.extend(self.sheen_roughness).to_array(),
            ],
            [
                self.sheen_color.extend(self.iridescence).to_array(),
                [self.iridescence_ior, self.iridescence_thickness, 0.0, 0.0],
                [0.0; 4],
            ],
        ]
    }

    fn ask(&self, device: &TestDevice, probe: Probe, questions: impl Iterator<Item = Question>) -> Vec<Answer> {
        let all: Vec<_> = self.questions().into_iter().chain(questions).collect();
        assert!(all.len() < 1 << 18, "the closure is read from the head of one batch");
        device.ask(&anywhere(), probe, &all)[3..].to_vec()
    }

    /// Evaluates (BSDF x cosine, density) of each pair (wo, wi).
    fn eval(&self, device: &TestDevice, pairs: &[(Vec3, Vec3)]) -> Vec<(Vec3, f32)> {
        let questions = pairs.iter().map(|(wo, wi)| [wo.extend(0.0).to_array(), wi.extend(0.0).to_array(), [0.0; 4]]);
        let answers = self.ask(device, Probe::PrincipledEval, questions);
        answers.iter().map(|a| (Vec3::from_slice(&a[0]), a[0][3])).collect()
    }

    fn ask_samples(&self, device: &TestDevice, wo: Vec3, numbers: &[[f32; 4]]) -> Vec<Sample> {
        let questions = numbers.iter().map(|u| [wo.extend(0.0).to_array(), *u, [0.0; 4]]);
        let answers = self.ask(device, Probe::PrincipledSample, questions);
        answers
            .iter()
            .map(|[a, b, _]| Sample {
                wi: Vec3::from_slice(a),
                weight: Vec3::from_slice(b),
                pdf: a[3],
                transmitted: b[3] % 2.0 == 1.0,
                delta: b[3] >= 2.0,
            })
            .collect()
    }

    /// Part of the light from each `wo` that goes on, and its standard error: of 16 lattices of `count` samples.
    fn energies(&self, device: &TestDevice, wos: &[Vec3], count: u32) -> Vec<(Vec3, f32)> {
        const LATTICES: usize = 16;
        let lattices = |wo: &Vec3| {
            let wo = wo.extend(0.0).to_array();
            (0..LATTICES).map(move |seed| [wo, [seed as f32, count as f32, 0.0, 0.0], [0.0; 4]])
        };
        let answers = self.ask(device, Probe::PrincipledEnergy, wos.iter().flat_map(lattices));
        let estimate = |answers: &[Answer]| {
            let means = answers.iter().map(|a| Vec3::from_slice(&a[0]));
            let mean = means.clone().sum::<Vec3>() / LATTICES as f32;
            let spread = means.map(|m| (m - mean).length_squared() / 3.0).sum::<f32>() / (LATTICES - 1) as f32;
            (mean, (spread / LATTICES as f32).sqrt())
        };
        answers.chunks(LATTICES).map(estimate).collect()
    }
}

/// Direction at this cosine to the normal, at an angle to both tangents.
fn incident(cosine: f32) -> Vec3 {
    let across = (1.0 - cosine * cosine).sqrt();
    Vec3::new(0.8 * across, 0.6 * across, cosine)
}

/// Closures of every lobe alone, and of mixtures.
fn closures() -> Vec<(&'static str, Closure)> {
    let colored = Vec3::new(0.9, 0.5, 0.2);
    let glass = Closure { transmission: 1.0, ..WHITE };
    let mixture = Closure {
        base_color: colored,
        metallic: 0.3,
        anisotropy: 0.5,
        specular: 0.7,
        specular_color: Vec3::new(1.0, 0.6, 2.0),
        transmission: 0.5,
        diffuse_transmission: 0.4,
        diffuse_transmission_color: Vec3::new(0.2, 0.9, 0.4),
        clearcoat: 0.6,
        clearcoat_roughness: 0.3,
        clearcoat_normal: Vec3::new(0.2, -0.1, 1.0).normalize(),
        sheen_color: Vec3::new(0.3, 0.5, 0.7),
        iridescence: 0.5,
        ..WHITE
    };
    vec![
        ("plastic", Closure { base_color: colored, roughness: 0.3, ..WHITE }),
        ("metal", Closure { base_color: colored, metallic: 1.0, ..WHITE }),
        ("brushed metal", Closure { metallic: 1.0, roughness: 0.4, anisotropy: 0.8, ..WHITE }),
        ("glass", glass),
        ("glass from inside", Closure { eta: 1.5, outside: false, ..glass }),
        ("very rough glass", Closure { roughness: 1.0, eta: 1.0 / 1.8, base_color: colored, ..glass }),
        ("sheet", Closure { thin_walled: true, base_color: colored, ..glass }),
        ("leaf", Closure { thin_walled: true, diffuse_transmission: 0.6, base_color: colored, ..WHITE }),
        ("coat", Closure { clearcoat: 1.0, clearcoat_roughness: 0.4, base_color: colored, ..WHITE }),
        ("velvet", Closure { sheen_color: Vec3::ONE, sheen_roughness: 0.4, ..WHITE }),
        ("soap", Closure { iridescence: 1.0, thin_walled: true, ..glass }),
        ("oil", Closure { iridescence: 1.0, iridescence_ior: 1.8, ..WHITE }),
        ("mixture", mixture),
        ("sheet of the mixture", Closure { thin_walled: true, ..mixture }),
        ("mixture from inside", Closure { eta: 1.4, outside: false, ..mixture }),
    ]
}
