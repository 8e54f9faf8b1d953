//! What a scene is, once it has been read and checked.

use std::ops::Range;
use std::sync::Arc;

use glam::{DAffine3, DMat3, EulerRot, Vec3};
use raggio_images::Bitmap;
use raggio_models::{Light, Mesh, Part, Principled};

/// A checked scene: every number is finite, every index is in range.
///
/// Lengths are in the scene's own unit, angles in degrees, light in linear radiance.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// How large and how well to render.
    pub render: RenderSettings,
    /// Where the picture is taken from.
    pub camera: Camera,
    /// The light that comes from outside.
    pub environment: Environment,
    /// In the order of the file; after them those that came with models.
    pub materials: Vec<Material>,
    /// In the order of the file; a model may become many.
    pub shapes: Vec<Shape>,
    /// Each `[[shapes]]` of the file.
    pub entries: Vec<Entry>,
    /// Lights without size, which came with models.
    pub lights: Vec<Light>,
    /// What is allowed but probably not meant, each as `file:line:column: sentence`.
    pub warnings: Vec<String>,
}

impl Scene {
    /// What the `[[shapes]]` of this place in the file became; nothing where the file has none there.
    pub fn shapes_of(&self, entry: usize) -> &[Shape] {
        self.entries.get(entry).and_then(|entry| self.shapes.get(entry.shapes.clone())).unwrap_or_default()
    }
}

/// Size and quality of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Pixels across, 1 to 65536.
    pub width: u32,
    /// Pixels down, 1 to 65536.
    pub height: u32,
    /// Samples of each pixel, 1 to 2^31 - 1.
    pub samples: u32,
    /// Most rays along one path, the camera's ray included, 1 to 65535; 0 sets no limit.
    pub max_depth: u32,
    /// Chooses the random numbers.
    pub seed: u32,
    /// Where the random numbers come from.
    pub sampler: Sampler,
    /// What a pixel's value is the mean of.
    pub filter: Filter,
    /// The largest channel of a sample that counts; what exceeds it is taken off. `None` leaves samples what they are.
    pub clamp: Option<f32>,
    /// Whether rays start slightly off the surface they leave; without it a surface shadows itself.
    pub surface_offset: bool,
    /// How light is followed; the program's choice, not the file's.
    pub integrator: Integrator,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            width: 1280,
            height: 720,
            samples: 256,
            max_depth: 10,
            seed: 0,
            sampler: Sampler::Sobol,
            filter: Filter::Box,
            clamp: None,
            surface_offset: true,
            integrator: Integrator::default(),
        }
    }
}

/// How light is followed. All arrive at the same picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integrator {
    /// Lights are looked for at each surface, and what scatters toward them by chance is weighed against that.
    #[default]
    Path,
    /// Chance alone finds lights: slow, and simple enough to be believed.
    Reference,
}

/// Where the random numbers of a pixel's samples come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampler {
    /// Scrambled Sobol' points, which spread evenly: less noise.
    Sobol,
    /// Independent numbers of a hash.
    Pcg,
}

/// The reconstruction filter: with which weights the picture around a pixel's centre makes its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// All of the pixel's area alike.
    Box,
    /// A smooth bell 3 pixels wide: the softest.
    BlackmanHarris,
    /// Mitchell and Netravali's, 4 pixels wide, with negative lobes: the sharpest.
    Mitchell,
    /// The pixel's centre alone, which shows aliasing.
    Point,
}

/// A pinhole, or a thin lens when `aperture_radius` is positive.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// The pinhole, or the lens's centre.
    pub position: Vec3,
    /// The point in the middle of the picture, never equal to `position`.
    pub look_at: Vec3,
    /// Not zero and not parallel to the viewing direction, but of any length and not at a right angle to it.
    pub up: Vec3,
    /// Angle between the picture's top and bottom edges, between 0 and 180 exclusive.
    pub vertical_fov_degrees: f32,
    /// 0 is a pinhole.
    pub aperture_radius: f32,
    /// Distance from `position`, along the viewing direction, of the plane in focus; positive.
    pub focus_distance: f32,
}

/// Radiance that arrives from infinitely far away; black when the file has no `[environment]`.
#[derive(Clone, Debug, PartialEq)]
pub enum Environment {
    /// The same from everywhere.
    Constant(Vec3),
    /// `mix(horizon, zenith, 0.5 (y + 1))` for the unit direction of the ray.
    Gradient {
        /// Seen straight below.
        horizon: Vec3,
        /// Seen straight above.
        zenith: Vec3,
    },
    /// A latitude-longitude image: its centre is seen along -Z, its right along +X, its top along +Y.
    Image {
        /// Shared with whoever else shows it.
        image: Arc<Bitmap>,
        /// Turns it about the y axis, counter-clockwise seen from above.
        rotation_degrees: f32,
        /// Multiplies it.
        intensity: f32,
    },
}

impl Environment {
    /// Whether no light at all comes from outside.
    pub fn is_black(&self) -> bool {
        match self {
            Self::Constant(color) => *color == Vec3::ZERO,
            Self::Gradient { horizon, zenith } => *horizon == Vec3::ZERO && *zenith == Vec3::ZERO,
            Self::Image { intensity, .. } => *intensity == 0.0,
        }
    }
}

/// How a surface reflects, transmits and emits light.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The key under `[materials]`.
    pub name: String,
    /// Reflected (or transmitted) part of the light that arrives, each component 0 to 1.
    pub color: Vec3,
    /// Multiplied by `emission_strength` it is the emitted radiance; components 0 or more.
    pub emission_color: Vec3,
    /// 0 emits nothing.
    pub emission_strength: f32,
    /// 0 diffuse to 1 mirror; a dielectric ignores it.
    pub smoothness: f32,
    /// `None` is opaque, `Some` a dielectric of that index.
    pub refractive_index: Option<f32>,
    /// How a dielectric shares light between reflection and refraction.
    pub reflection: Reflection,
    /// Where dielectrics overlap the higher one wins.
    pub priority: i32,
    /// If there is one it alone says what the surface does, and everything above but the name is of no meaning.
    pub principled: Option<Arc<Principled>>,
    /// It came with a model, and is not in the scene file.
    pub imported: bool,
}

impl Default for Material {
    /// What a scene file means by a material without any key: a light grey, diffuse and opaque.
    fn default() -> Self {
        Self {
            name: String::new(),
            color: Vec3::splat(0.8),
            emission_color: Vec3::ONE,
            emission_strength: 0.0,
            smoothness: 0.0,
            refractive_index: None,
            reflection: Reflection::Fresnel,
            priority: 0,
            principled: None,
            imported: false,
        }
    }
}

impl Material {
    /// Whether it emits any light.
    pub fn is_emissive(&self) -> bool {
        if let Some(principled) = &self.principled {
            return principled.emissive != [0.0; 3];
        }
        self.emission_strength > 0.0 && self.emission_color != Vec3::ZERO
    }

    /// Whether light passes into its bodies, bent by a refractive index.
    pub fn is_dielectric(&self) -> bool {
        match &self.principled {
            Some(principled) => principled.transmission > 0.0 && !principled.thin_walled,
            None => self.refractive_index.is_some(),
        }
    }
}

/// How a dielectric chooses between reflection and refraction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reflection {
    /// By Fresnel's equations.
    Fresnel,
    /// Reflects with this probability, 0 to 1, at every angle.
    Probability(f32),
}

/// A piece of geometry with its material.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// The place of its `[[shapes]]` in the file.
    pub entry: usize,
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// Where and what it is.
    pub geometry: Geometry,
}

impl Shape {
    /// The material of a part of its mesh, as an index into [`Scene::materials`].
    pub fn material_of(&self, part: &Part) -> usize {
        match (&self.geometry, part.material) {
            (Geometry::Mesh { first_material: Some(first), .. }, Some(own)) => first + own,
            _ => self.material,
        }
    }
}

/// What one `[[shapes]]` of the file became.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Which of [`Scene::shapes`]; a model without triangles is none of them.
    pub shapes: Range<usize>,
    /// The material that the file names; a model may go without.
    pub material: Option<usize>,
    /// Where a model stands; other shapes say themselves where they are.
    pub placement: Option<Placement>,
}

/// Which model stands where: p becomes `translation` + rotation * `scale` * p.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// As the scene file names it.
    pub file: String,
    /// Moves it, last.
    pub translation: Vec3,
    /// As [`rotation`] has it.
    pub rotation_degrees: Vec3,
    /// No component is 0.
    pub scale: Vec3,
}

/// The kinds of geometry.
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry {
    /// A sphere of positive radius.
    Sphere {
        /// Its centre.
        center: Vec3,
        /// Positive.
        radius: f32,
    },
    /// An endless plane.
    Plane {
        /// Any point of it.
        point: Vec3,
        /// Of unit length.
        normal: Vec3,
    },
    /// Both sides reflect and emit.
    Rectangle {
        /// One of its corners.
        corner: Vec3,
        /// From the corner along one side, not zero.
        edge_u: Vec3,
        /// From the corner along the other side, at a right angle to `edge_u`.
        edge_v: Vec3,
    },
    /// A box that may be turned.
    Box {
        /// Its centre, about which it turns.
        center: Vec3,
        /// Lengths of its sides, all positive.
        size: Vec3,
        /// About the fixed x axis first, then y, then z.
        rotation_degrees: Vec3,
    },
    /// Triangles. Both sides reflect and emit; as a dielectric the mesh is a closed body.
    Mesh {
        /// Shared among its instances: the same allocation is the same mesh.
        mesh: Arc<Mesh>,
        /// Any affine map that can be undone.
        world_from_mesh: DAffine3,
        /// Where the materials that the mesh's parts name begin in [`Scene::materials`]. Parts without a material, and
        /// all parts where this is `None`, have the shape's.
        first_material: Option<usize>,
    },
}

/// What `rotation_degrees` means: turns about the world's axes, x first, then y, then z. Its columns are the turned axes.
pub fn rotation(degrees: Vec3) -> DMat3 {
    let radians = degrees.as_dvec3() * (std::f64::consts::PI / 180.0);
    DMat3::from_euler(EulerRot::ZYX, radians.z, radians.y, radians.x)
}
