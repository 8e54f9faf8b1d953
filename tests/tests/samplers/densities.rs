//! Densities in double precision, derived anew, and charts on which they have no poles.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use glam::DVec3;
use raggio_kernels::SamplerKind;

use crate::samplers::frame;
use crate::samplers::microfacets::Facets;

/// A sampler with its arguments.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub kind: SamplerKind,
    pub n: DVec3,
    pub wo: DVec3,
    pub smoothness: f64,
    /// Detail that [`SamplerKind`] explains: of rough surfaces alpha along y, or eta.
    pub detail: f64,
}

/// Coordinates (h, phi) of the sphere or the disk: h in `range`, phi a whole turn.
pub struct Chart {
    axes: [DVec3; 3],
    pub range: (f64, f64),
    form: Form,
}

/// Meaning of h.
enum Form {
    /// The cosine to the axis: equal areas.
    Cosine,
    /// The root of 1 - cosine: fine about the axis, where the densities of grazing light end abruptly.
    Root,
    /// The squared radius in the unit disk, halved in its measure.
    Disk,
    /// The root in the density of the interpolated mirror, for smoothness over 1/2: see [`Case::chart`].
    Cone(f64),
    /// The cosine in the space where the microfacets are a hemisphere; of normals, or of what they reflect.
    Facets { facets: Facets, wo: DVec3, reflected: bool },
}

impl Chart {
    pub fn point(&self, h: f64, phi: f64) -> DVec3 {
        let (sin, cos) = phi.sin_cos();
        if let Form::Disk = self.form {
            return h.sqrt() * DVec3::new(cos, sin, 0.0);
        }
        if let Form::Facets { facets, wo, reflected } = self.form {
            let m = facets.squeezed(h, phi).normalize();
            let w = if reflected { 2.0 * wo.dot(m) * m - wo } else { m };
            let [x, y, z] = self.axes;
            return w.x * x + w.y * y + w.z * z;
        }
        let cosine = match self.form {
            Form::Root => 1.0 - h * h,
            Form::Cone(s) => ((h * h + 2.0 * s - 1.0).sqrt() / s).min(1.0),
            _ => h,
        };
        let [x, y, z] = self.axes;
        (1.0 - cosine * cosine).max(0.0).sqrt() * (cos * x + sin * y) + cosine * z
    }

    /// Coordinates (h, phi) of a sample; h may leave the range where rounding takes it.
    pub fn coordinates(&self, w: DVec3) -> (f64, f64) {
        if let Form::Disk = self.form {
            return (w.length_squared(), w.y.atan2(w.x).rem_euclid(TAU));
        }
        let [x, y, z] = self.axes.map(|axis| axis.dot(w));
        if let Form::Facets { facets, wo, reflected } = self.form {
            let w = DVec3::new(x, y, z);
            let m = facets.stretched(if reflected { w + wo } else { w });
            return (m.z, m.y.atan2(m.x).rem_euclid(TAU));
        }
        let h = match self.form {
            Form::Root => (1.0 - z).max(0.0).sqrt(),
            Form::Cone(s) => (s * s * z * z - (2.0 * s - 1.0)).max(0.0).sqrt(),
            _ => z,
        };
        (h, y.atan2(x).rem_euclid(TAU))
    }

    /// Area of the sphere (or the disk) for a unit of h and of phi.
    pub fn measure(&self, h: f64, phi: f64) -> f64 {
        match self.form {
            Form::Facets { facets, wo, reflected } => {
                let m = facets.squeezed(h, phi);
                let solid_angle = facets.alpha[0] * facets.alpha[1] / m.length().powi(3);
                if reflected { 4.0 * wo.dot(m.normalize()).abs() * solid_angle } else { solid_angle }
            }
            Form::Cosine => 1.0,
            Form::Root => 2.0 * h,
            Form::Disk => 0.5,
            // The cosine is sqrt(h^2 + 2s - 1) / s.
            Form::Cone(s) => h / (s * (h * h + 2.0 * s - 1.0).sqrt()),
        }
    }
}

impl Case {
    pub fn mirror(&self) -> DVec3 {
        2.0 * self.n.dot(self.wo) * self.n - self.wo
    }

    /// Chart around the normal, or around the mirror direction. Past a smoothness of 1/2 all directions lie in a cone
    /// about that, and their density grows without bound toward its rim, as one over a root: with the root for a
    /// coordinate the measure takes the pole away.
    pub fn chart(&self) -> Chart {
        let s = self.smoothness;
        match self.kind {
            SamplerKind::UniformSphere => Chart { axes: frame(self.n), range: (-1.0, 1.0), form: Form::Cosine },
            SamplerKind::VisibleNormal | SamplerKind::RoughMirror => {
                let reflected = self.kind as u32 == SamplerKind::RoughMirror as u32;
                let form = Form::Facets { facets: self.facets(), wo: self.local(self.wo), reflected };
                Chart { axes: basis(self.n), range: (0.0, 1.0), form }
            }
            SamplerKind::RoughGlass => Chart { axes: basis(self.n), range: (-1.0, 1.0), form: Form::Cosine },
            // Fine about the axis of the lobe.
            SamplerKind::HenyeyGreenstein => {
                let axis = if s < 0.0 { self.wo } else { -self.wo };
                Chart { axes: frame(axis), range: (0.0, 2f64.sqrt()), form: Form::Root }
            }
            SamplerKind::UniformDisk => Chart { axes: frame(self.n), range: (0.0, 1.0), form: Form::Disk },
            SamplerKind::InterpolatedMirror if s > 0.5 => {
                Chart { axes: frame(self.mirror()), range: (0.0, 1.0 - s), form: Form::Cone(s) }
            }
            SamplerKind::InterpolatedMirror => {
                Chart { axes: frame(self.mirror()), range: (0.0, 2f64.sqrt()), form: Form::Root }
            }
            _ => Chart { axes: frame(self.n), range: (0.0, 1.0), form: Form::Cosine },
        }
    }

    /// Density of the direction w, per steradian, or of the point w, per area of the disk.
    pub fn density(&self, w: DVec3) -> f64 {
        let cosine = self.n.dot(w);
        match self.kind {
            SamplerKind::UniformSphere => 1.0 / (4.0 * PI),
            SamplerKind::UniformHemisphere => {
                if cosine > 0.0 {
                    1.0 / TAU
                } else {
                    0.0
                }
            }
            SamplerKind::CosineHemisphere => cosine.max(0.0) * FRAC_1_PI,
            SamplerKind::UniformDisk => {
                if w.length_squared() <= 1.0 {
                    FRAC_1_PI
                } else {
                    0.0
                }
            }
            SamplerKind::InterpolatedMirror => self.interpolated(w),
            SamplerKind::VisibleNormal => self.facets().visible(self.local(self.wo), self.local(w)),
            SamplerKind::RoughMirror => self.facets().reflected(self.local(self.wo), self.local(w)),
            SamplerKind::RoughGlass => self.facets().dielectric(self.local(self.wo), self.local(w), self.detail),
            SamplerKind::HenyeyGreenstein => {
                let g = self.smoothness;
                let cosine = -self.wo.dot(w.normalize());
                (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5))
            }
        }
    }

    pub fn facets(&self) -> Facets {
        let dielectric = self.kind as u32 == SamplerKind::RoughGlass as u32;
        Facets { alpha: [self.smoothness, if dielectric { self.smoothness } else { self.detail }] }
    }

    fn local(&self, w: DVec3) -> DVec3 {
        DVec3::from_array(basis(self.n).map(|axis| axis.dot(w)))
    }

    /// Whether some of the light ends between facets.
    pub fn loses(&self) -> bool {
        self.kind as u32 == SamplerKind::RoughGlass as u32
    }

    /// Density of interpolated directions: w goes through normalize((1-s) d + s m) for the unit vectors d at which the
    /// line along w crosses the sphere of radius 1-s about s m. In the plane of w and m, with a the angle between them,
    /// sin(b) = s sin(a) / (1-s) is the angle at which it crosses; a small patch of the sphere of d is seen
    /// foreshortened by cos(b), at distance r.
    fn interpolated(&self, w: DVec3) -> f64 {
        let (s, m) = (self.smoothness, self.mirror());
        let sine = s * w.cross(m).length() / (1.0 - s);
        if sine >= 1.0 {
            return 0.0;
        }
        let cosine = (1.0 - sine * sine).sqrt();
        let to_middle = s * w.dot(m);
        [-1.0, 1.0]
            .into_iter()
            .map(|side| {
                let r = to_middle + side * (1.0 - s) * cosine;
                let d = (r * w - s * m) / (1.0 - s);
                let patch = r * r / ((1.0 - s) * (1.0 - s) * cosine);
                if r > 0.0 { self.n.dot(d).max(0.0) * FRAC_1_PI * patch } else { 0.0 }
            })
            .sum()
    }

    /// Error that single precision may make in the density at w, relative to it and absolutely: the root and the cosine
    /// to the normal are differences of numbers up to 1, whose roundings (eight of them) weigh more the smaller the
    /// difference.
    pub fn tolerance(&self, w: DVec3) -> f64 {
        let eight = 8.0 * 2f64.powi(-24);
        if self.kind as u32 == SamplerKind::HenyeyGreenstein as u32 {
            // The denominator, whose directions are rounded, stands there to the power of 3/2.
            let g = self.smoothness.abs();
            let cosine = -self.wo.dot(w) * self.smoothness.signum();
            let off = (2.0 - 2.0 * cosine).max(0.0).sqrt() + eight;
            let condition = 1.0 + 2.0 * g * off / ((1.0 - g).powi(2) + g * off * off);
            return 2.0 * eight * condition * self.density(w) + 1e-12;
        }
        if self.kind as u32 >= SamplerKind::VisibleNormal as u32 {
            let eta = match self.kind {
                SamplerKind::VisibleNormal => None,
                SamplerKind::RoughGlass if self.n.dot(w) < 0.0 => Some(self.detail),
                _ => Some(1.0),
            };
            return eight
                * self.facets().condition(
                    self.local(self.wo),
                    self.local(w),
                    eta,
                    self.loses().then_some(self.detail),
                );
        }
        if self.kind as u32 != SamplerKind::InterpolatedMirror as u32 {
            return eight;
        }
        let s = self.smoothness;
        let root2 = (s * w.dot(self.mirror())).powi(2) - (2.0 * s - 1.0);
        let rounding = eight / (root2 * (1.0 - s)).max(1e-12);
        let scale = 1.0 / ((1.0 - s).powi(2) * root2.max(1e-12).sqrt());
        rounding * (self.density(w) + scale)
    }
}

/// Basis of the kernels, z = n (Duff et al. 2017).
fn basis(n: DVec3) -> [DVec3; 3] {
    let sign = if n.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    let x = DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    [x, DVec3::new(b, sign + n.y * n.y * a, -n.y), n]
}

/// Lists all samplers, each with several normals and directions of incidence, from straight to grazing.
pub fn cases() -> Vec<Case> {
    let normals = [DVec3::Y, DVec3::new(0.3, -0.5, 0.8), DVec3::new(-0.9, 0.1, -0.2)];
    let mut cases = vec![];
    for (i, n) in normals.into_iter().enumerate() {
        // The normal that a device is given is a rounded one.
        let n = n.normalize().as_vec3().as_dvec3().normalize();
        let wo = |cosine: f64| {
            let [x, _, z] = frame(n);
            (cosine * z + (1.0 - cosine * cosine).sqrt() * x).normalize().as_vec3().as_dvec3().normalize()
        };
        let mut add = |kind, cosine, smoothness| cases.push(Case { kind, n, wo: wo(cosine), smoothness, detail: 0.0 });
        for kind in [SamplerKind::UniformSphere, SamplerKind::UniformHemisphere, SamplerKind::CosineHemisphere] {
            add(kind, 0.7, 0.0);
        }
        if i == 0 {
            add(SamplerKind::UniformDisk, 0.7, 0.0);
        }
        for smoothness in [0.0f32, 0.2, 0.5, 0.7, 0.95] {
            let cosine = [[1.0, 0.5, 0.03], [0.9, 0.3, 0.01], [0.6, 0.1, 0.05]][i];
            for cosine in if i == 0 { &cosine[..] } else { &cosine[1..] } {
                add(SamplerKind::InterpolatedMirror, *cosine, f64::from(smoothness));
            }
        }
        for g in [[0.0f32, 0.3, -0.6], [0.9, -0.95, 0.001], [0.95, 0.7, -0.2]][i] {
            let kind = SamplerKind::HenyeyGreenstein;
            cases.push(Case { kind, n, wo: wo(0.6), smoothness: f64::from(g), detail: 0.0 });
        }
        rough_cases(i, n, &wo, &mut cases);
    }
    cases
}

/// Adds cases of roughness 0.05, 0.3 and 1 (alpha is its square), stretched surfaces, and light from straight above to
/// grazing.
fn rough_cases(i: usize, n: DVec3, wo: &dyn Fn(f64) -> DVec3, cases: &mut Vec<Case>) {
    let cosines = [[1.0, 0.5, 0.03], [0.9, 0.3, 0.01], [0.6, 0.1, 0.05]][i];
    let mut add = |kind, cosine, alpha: f32, detail: f32| {
        cases.push(Case { kind, n, wo: wo(cosine), smoothness: f64::from(alpha), detail: f64::from(detail) });
    };
    for kind in [SamplerKind::VisibleNormal, SamplerKind::RoughMirror] {
        for alpha in [[0.0025, 0.0025], [0.09, 0.09], [1.0, 1.0], [0.1, 0.5], [0.6, 0.02]] {
            for cosine in if i == 0 { &cosines[..] } else { &cosines[1..] } {
                add(kind, *cosine, alpha[0], alpha[1]);
            }
        }
    }
    for (cosine, alpha, eta) in [(0.6, 0.09, 1.0 / 1.5), (0.5, 0.3, 1.5), (0.1, 0.3, 1.0 / 1.5), (0.9, 1.0, 1.33)] {
        add(SamplerKind::RoughGlass, cosine, alpha, eta);
    }
}
