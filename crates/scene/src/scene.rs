//! The scene, once it has been read and checked.

use std::ops::Range;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, EulerRot, Vec3};
use raggio_choice::choice;
use raggio_images::Bitmap;
use raggio_models::{Light, LightKind, Mesh, Part, Principled};

use crate::sky::Sky;

/// A checked scene: every number is finite, every index is in range.
///
/// Lengths are in the scene's own unit, angles in degrees, light in linear radiance.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Size and quality of the picture.
    pub render: RenderSettings,
    /// Viewpoint of the picture.
    pub camera: Camera,
    /// The light that comes from outside.
    pub environment: Environment,
    /// Medium that fills the scene around all bodies.
    pub air: Option<Medium>,
    /// Materials in the order of the file; after them those that came with models.
    pub materials: Vec<Material>,
    /// Shapes in the order of the file; a model may become many.
    pub shapes: Vec<Shape>,
    /// Results of each `[[shapes]]` of the file, in its order.
    pub entries: Vec<Entry>,
    /// Lights that are no surfaces: those of `light_entries`, after them those that came with models, and last the sky's sun.
    pub lights: Vec<Light>,
    /// Each `[[lights]]` of the file, in its order.
    pub light_entries: Vec<LightEntry>,
    /// Warnings of things that are allowed but probably not meant, each as `file:line:column: sentence`.
    pub warnings: Vec<String>,
}

impl Scene {
    /// Shapes that the `[[shapes]]` of number `entry` in the file became; none where the file has no such entry.
    pub fn shapes_of(&self, entry: usize) -> &[Shape] {
        self.entries.get(entry).and_then(|entry| self.shapes.get(entry.shapes.clone())).unwrap_or_default()
    }
}

/// Size and quality of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Width of the picture in pixels, 1 to 65536.
    pub width: u32,
    /// Height of the picture in pixels, 1 to 65536.
    pub height: u32,
    /// Number of samples of each pixel, 1 to 2^31 - 1.
    pub samples: u32,
    /// Most rays along one path, the camera's ray included, 1 to 65535; 0 sets no limit.
    pub max_depth: u32,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Source of the random numbers.
    pub sampler: Sampler,
    /// Filter that makes a pixel's value from the samples.
    pub filter: Filter,
    /// Largest channel of a sample that counts; the excess is taken off. `None` leaves samples as they are.
    pub clamp: Option<f32>,
    /// Whether what the camera sees behind everything is left out of the picture, which gets a coverage in its place.
    pub alpha: bool,
    /// Whether rays start slightly off the surface they leave; without it a surface shadows itself.
    pub surface_offset: bool,
    /// Algorithm of light transport; the program's choice, not the file's.
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
            alpha: false,
            surface_offset: true,
            integrator: Integrator::Path,
        }
    }
}

choice! {
    /// Algorithms of light transport, which all arrive at one picture.
    pub enum Integrator: "integrator" {
        /// Lights are looked for at each surface, and light met by chance of scattering is weighed against that.
        Path = "path",
        /// Chance alone finds lights: slow, and simple enough to be believed.
        Reference = "reference",
    }
}

choice! {
    /// Source of the random numbers of a pixel's samples.
    pub enum Sampler: "sampler" {
        /// Scrambled Sobol' points, which spread evenly: less noise.
        Sobol = "sobol",
        /// Independent numbers of a hash.
        Pcg = "pcg",
    }
}

choice! {
    /// Reconstruction filter: weights with which the picture around a pixel's centre makes its value.
    pub enum Filter: "filter" {
        /// Box over the pixel's area, with equal weights.
        Box = "box",
        /// Blackman-Harris window, a smooth bell 3 pixels wide: the softest.
        BlackmanHarris = "blackman-harris",
        /// Mitchell and Netravali's filter, 4 pixels wide, with negative lobes: the sharpest.
        Mitchell = "mitchell",
        /// Value of the pixel's centre alone, which shows aliasing.
        Point = "point",
    }
}

/// Viewpoint of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Position of the pinhole, or of the lens's centre.
    pub position: Vec3,
    /// Point in the middle of the picture, never equal to `position`; intrinsics may put it elsewhere.
    pub look_at: Vec3,
    /// Direction upwards, not zero and not parallel to the viewing direction, but of any length and not at a right
    /// angle to it.
    pub up: Vec3,
    /// Projection of what is seen onto the picture.
    pub projection: Projection,
    /// Radius of the lens; 0 is a pinhole, and a panorama has no other.
    pub aperture_radius: f32,
    /// Distance from `position`, along the viewing direction, of the plane in focus; positive.
    pub focus_distance: f32,
}

/// Projection of what a camera sees onto its picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Rays set out from one point; the angle between the picture's top and bottom edges is between 0 and 180 exclusive.
    Perspective {
        /// Angle between the picture's top and bottom edges.
        vertical_fov_degrees: f32,
    },
    /// Rays set out from one point, as those of a camera whose intrinsics are known.
    Calibrated(Intrinsics),
    /// Rays are parallel.
    Orthographic {
        /// Height of the picture in the scene's units, positive.
        height: f32,
    },
    /// Rays set out from one point in all directions.
    Panoramic(Panorama),
}

choice! {
    /// Layouts of pictures of all directions.
    pub enum Panorama: "panorama" {
        /// The whole sphere: longitude from left to right, latitude from bottom to top, the viewing direction in the middle.
        LatitudeLongitude = "latitude-longitude",
    }
}

/// Intrinsics of a pinhole camera, in pixels of a picture of `size`. A point x to the right, y down and z forward of the
/// camera is seen at (`focal.x` x / z + `skew` y / z + `principal_point.x`, `focal.y` y / z + `principal_point.y`), counted
/// from the top left corner of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intrinsics {
    /// Focal lengths across and down, both positive.
    pub focal: [f32; 2],
    /// Point of the picture that lies straight ahead.
    pub principal_point: [f32; 2],
    /// Skew of the axes, 0 where pixels are rectangles.
    pub skew: f32,
    /// Width and height of the picture.
    pub size: [u32; 2],
}

impl Intrinsics {
    /// Intrinsics of the same camera for a picture of another size. Its height shows what it did before: where the
    /// proportions are others there is more or less to the left and to the right.
    pub fn resized(&self, width: u32, height: u32) -> Self {
        if self.size == [width, height] {
            return *self;
        }
        let [old_width, old_height] = self.size.map(f64::from);
        let scale = f64::from(height) / old_height;
        let scaled = |x: f32| (f64::from(x) * scale) as f32;
        let [x, y] = self.principal_point.map(f64::from);
        Self {
            focal: self.focal.map(scaled),
            principal_point: [((x - old_width / 2.0) * scale + f64::from(width) / 2.0) as f32, (y * scale) as f32],
            skew: scaled(self.skew),
            size: [width, height],
        }
    }
}

impl Camera {
    /// Half of the picture's height in the scene's units: at the distance 1, or anywhere where rays are parallel. That of a
    /// panorama is along the sphere.
    pub fn half_height(&self) -> f64 {
        match self.projection {
            Projection::Perspective { vertical_fov_degrees } => {
                (f64::from(vertical_fov_degrees).to_radians() / 2.0).tan()
            }
            Projection::Calibrated(Intrinsics { focal, size, .. }) => f64::from(size[1]) / 2.0 / f64::from(focal[1]),
            Projection::Orthographic { height } => f64::from(height) / 2.0,
            Projection::Panoramic(_) => std::f64::consts::FRAC_PI_2,
        }
    }

    /// Height of the picture in the scene's units, where rays are parallel.
    pub fn orthographic_height(&self) -> Option<f32> {
        match self.projection {
            Projection::Orthographic { height } => Some(height),
            _ => None,
        }
    }

    /// Whether the picture shows all directions.
    pub fn is_panoramic(&self) -> bool {
        matches!(self.projection, Projection::Panoramic(_))
    }
}

/// Radiance that arrives from infinitely far away; black when the file has no `[environment]`.
#[derive(Clone, Debug, PartialEq)]
pub enum Environment {
    /// Radiance that is equal from everywhere.
    Constant(Vec3),
    /// Gradient `mix(horizon, zenith, 0.5 (y + 1))`, with y of the ray's unit direction.
    Gradient {
        /// Radiance seen straight below.
        horizon: Vec3,
        /// Radiance seen straight above.
        zenith: Vec3,
    },
    /// A latitude-longitude image: its centre is seen along -Z, its right along +X, its top along +Y.
    Image {
        /// Image, shared with whoever else shows it.
        image: Arc<Bitmap>,
        /// Angle by which the image is turned about the y axis, counter-clockwise seen from above.
        rotation_degrees: f32,
        /// Factor of the image's radiance.
        intensity: f32,
    },
    /// A sky by day.
    Sky(Sky),
}

impl Environment {
    /// Whether no light at all comes from outside.
    pub fn is_black(&self) -> bool {
        match self {
            Self::Constant(color) => *color == Vec3::ZERO,
            Self::Gradient { horizon, zenith } => *horizon == Vec3::ZERO && *zenith == Vec3::ZERO,
            Self::Image { intensity, .. } | Self::Sky(Sky { intensity, .. }) => *intensity == 0.0,
        }
    }
}

/// A homogeneous medium, which absorbs and scatters light on its way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Medium {
    /// Absorption coefficients of red, green and blue, per unit of length, 0 or more.
    pub absorption: Vec3,
    /// Scattering coefficients of red, green and blue, per unit of length, 0 or more.
    pub scattering: Vec3,
    /// Mean cosine of the angle by which light is scattered, the g of Henyey and Greenstein, -0.999 to 0.999.
    pub anisotropy: f32,
}

/// Reflection, transmission and emission of light at a surface, and what is behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name of the material, the key under `[materials]`.
    pub name: String,
    /// Part of the arriving light that is reflected or transmitted, each component 0 to 1.
    pub color: Vec3,
    /// Colour of the emitted light; times `emission_strength` it is the emitted radiance. Components are 0 or more.
    pub emission_color: Vec3,
    /// Strength of the emission; 0 emits nothing.
    pub emission_strength: f32,
    /// Smoothness from 0, diffuse, to 1, a mirror; a dielectric ignores it.
    pub smoothness: f32,
    /// Refractive index of a dielectric; `None` is opaque.
    pub refractive_index: Option<f32>,
    /// Rule by which a dielectric shares light between reflection and refraction.
    pub reflection: Reflection,
    /// Rank among overlapping dielectrics: the highest wins.
    pub priority: i32,
    /// Principled material. If there is one, everything above but the name is without meaning.
    pub principled: Option<Arc<Principled>>,
    /// Medium that fills bodies of the material. With neither a refractive index nor a principled material these have no
    /// surface.
    pub medium: Option<Medium>,
    /// Whether the material came with a model and is not in the scene file.
    pub imported: bool,
}

impl Default for Material {
    /// Material without any key in a scene file: a light grey, diffuse and opaque.
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
            medium: None,
            imported: false,
        }
    }
}

impl Material {
    /// Whether the material emits any light.
    pub fn is_emissive(&self) -> bool {
        if let Some(principled) = &self.principled {
            return principled.emissive != [0.0; 3];
        }
        self.emission_strength > 0.0 && self.emission_color != Vec3::ZERO
    }

    /// Whether light passes into the material's bodies, bent by a refractive index or, where they have no surface, not bent.
    pub fn is_dielectric(&self) -> bool {
        match &self.principled {
            Some(principled) => principled.transmission > 0.0 && !principled.thin_walled,
            None => self.refractive_index.is_some() || self.medium.is_some(),
        }
    }

    /// Whether the material's bodies have no surface, but only a medium.
    pub fn is_seamless(&self) -> bool {
        self.principled.is_none() && self.refractive_index.is_none() && self.medium.is_some()
    }
}

/// Choice of a dielectric between reflection and refraction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reflection {
    /// Fresnel's equations, from the angle of incidence.
    Fresnel,
    /// Probability of reflection, 0 to 1, at every angle.
    Probability(f32),
}

/// A piece of geometry with its material.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Index of its `[[shapes]]` in the file.
    pub entry: usize,
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// Geometry, in world space.
    pub geometry: Geometry,
}

impl Shape {
    /// Material of a part of the shape's mesh, as an index into [`Scene::materials`].
    pub fn material_of(&self, part: &Part) -> usize {
        match (&self.geometry, part.material) {
            (Geometry::Mesh { first_material: Some(first), .. }, Some(own)) => first + own,
            _ => self.material,
        }
    }
}

/// Result of one `[[shapes]]` of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Range of [`Scene::shapes`], empty for a model without triangles.
    pub shapes: Range<usize>,
    /// Index of the material that the file names; a model or a group may go without.
    pub material: Option<usize>,
    /// What the file says there is.
    pub contents: Contents,
    /// Transform of that into the world.
    pub transform: Transform,
}

impl Entry {
    /// Placement of a model.
    pub fn placement(&self) -> Option<&Placement> {
        match &self.contents {
            Contents::Model(placement) => Some(placement),
            _ => None,
        }
    }

    /// Geometry of a single shape, as it is before its transform.
    pub fn geometry(&self) -> Option<&Geometry> {
        match &self.contents {
            Contents::Geometry(geometry) => Some(geometry),
            _ => None,
        }
    }

    /// Key in the scene file, which is also the name of the kind.
    pub fn key(&self) -> &'static str {
        match &self.contents {
            Contents::Geometry(geometry) => geometry.key(),
            Contents::Model(_) => "mesh",
            Contents::Group(_) => "group",
        }
    }
}

/// What a `[[shapes]]` of the file says there is.
#[derive(Clone, Debug, PartialEq)]
pub enum Contents {
    /// A shape that is no model.
    Geometry(Geometry),
    /// All of a model.
    Model(Placement),
    /// All shapes of the group of this name.
    Group(String),
}

/// Transform of a shape: p becomes `translation` + rotation * `scale` * p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// Translation, applied last.
    pub translation: Vec3,
    /// Angles of turns about the axes in degrees, as [`rotation`] takes them.
    pub rotation_degrees: Vec3,
    /// Factors along the axes; no component is 0.
    pub scale: Vec3,
}

impl Transform {
    /// Transform that changes nothing.
    pub const IDENTITY: Self = Self { translation: Vec3::ZERO, rotation_degrees: Vec3::ZERO, scale: Vec3::ONE };
}

/// A `[[lights]]` of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightEntry {
    /// Kind of the light, where it is, and where it shines.
    pub place: LightPlace,
    /// Colour of the light, linear; components are 0 or more.
    pub color: Vec3,
    /// Radiant intensity of points and spots, irradiance of directional lights on what faces them, which `color` multiplies.
    pub intensity: f32,
}

/// Kind of a light that is no surface, where it is, and where it shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightPlace {
    /// A point that shines in all directions.
    Point {
        /// Position of the light.
        position: Vec3,
    },
    /// A point that shines into a cone.
    Spot {
        /// Position of the light.
        position: Vec3,
        /// Direction of the cone's axis, of unit length.
        direction: Vec3,
        /// Angle from the axis within which all the light is seen, at least 0.
        inner_degrees: f32,
        /// Angle from the axis beyond which none is, at least the inner one and at most 90.
        outer_degrees: f32,
    },
    /// Light from infinitely far away.
    Directional {
        /// Direction in which the light shines, of unit length.
        direction: Vec3,
        /// Width of the disk that it comes from: 0, or 0.01 to 180.
        angle_degrees: f32,
    },
}

impl LightPlace {
    /// Key in the scene file, which is also the name of the kind.
    pub fn key(&self) -> &'static str {
        match self {
            Self::Point { .. } => "point",
            Self::Spot { .. } => "spot",
            Self::Directional { .. } => "directional",
        }
    }
}

impl LightEntry {
    /// Whether no light comes from it.
    pub fn is_black(&self) -> bool {
        self.intensity == 0.0 || self.color == Vec3::ZERO
    }

    /// The light itself.
    pub fn light(&self) -> Light {
        let radians = |degrees: f32| f64::from(degrees).to_radians() as f32;
        let (position, direction, kind) = match self.place {
            LightPlace::Point { position } => (position, Vec3::NEG_Y, LightKind::Point),
            LightPlace::Spot { position, direction, inner_degrees, outer_degrees } => {
                let kind = LightKind::Spot { inner: radians(inner_degrees), outer: radians(outer_degrees) };
                (position, direction, kind)
            }
            LightPlace::Directional { direction, angle_degrees: 0.0 } => {
                (Vec3::ZERO, direction, LightKind::Directional)
            }
            LightPlace::Directional { direction, angle_degrees } => {
                (Vec3::ZERO, direction, LightKind::Sun { half_angle: radians(0.5 * angle_degrees) })
            }
        };
        Light {
            name: String::new(),
            intensity: (self.color * self.intensity).to_array(),
            position: position.as_dvec3(),
            direction: direction.as_dvec3().normalize(),
            kind,
        }
    }
}

/// Placement of a model: p becomes `translation` + rotation * `scale` * p.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Name of the model's file, as the scene file gives it.
    pub file: String,
    /// Translation, applied last.
    pub translation: Vec3,
    /// Angles of turns about the axes in degrees, as [`rotation`] takes them.
    pub rotation_degrees: Vec3,
    /// Factors along the axes; no component is 0.
    pub scale: Vec3,
}

/// Kinds of geometry.
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry {
    /// A sphere of positive radius.
    Sphere {
        /// Centre of the sphere.
        center: Vec3,
        /// Radius of the sphere, positive.
        radius: f32,
    },
    /// An endless plane.
    Plane {
        /// Any point of the plane.
        point: Vec3,
        /// Normal of the plane, of unit length.
        normal: Vec3,
    },
    /// A rectangle, both sides of which reflect and emit.
    Rectangle {
        /// One corner of the rectangle.
        corner: Vec3,
        /// Edge from the corner along one side, not zero.
        edge_u: Vec3,
        /// Edge from the corner along the other side, at a right angle to `edge_u`.
        edge_v: Vec3,
    },
    /// A disk, both sides of which reflect and emit.
    Disk {
        /// Centre of the disk.
        center: Vec3,
        /// Normal of the disk, of unit length.
        normal: Vec3,
        /// Radius of the disk, positive.
        radius: f32,
    },
    /// A cylinder. Open, both its sides reflect and emit.
    Cylinder {
        /// Centre of one end.
        base: Vec3,
        /// Centre of the other end, elsewhere.
        top: Vec3,
        /// Radius of the cylinder, positive.
        radius: f32,
        /// Whether disks close both ends.
        capped: bool,
    },
    /// A cone, which may be cut off. Open, both its sides reflect and emit.
    Cone {
        /// Centre of the wide end.
        base: Vec3,
        /// The apex, or the centre of the end where it is cut off; not `base`.
        top: Vec3,
        /// Radius at `base`, positive.
        radius: f32,
        /// Radius at `top`, 0 or more; 0 for an apex.
        top_radius: f32,
        /// Whether disks close both ends.
        capped: bool,
    },
    /// A box that may be turned.
    Box {
        /// Centre of the box, about which it turns.
        center: Vec3,
        /// Lengths of the box's sides, all positive.
        size: Vec3,
        /// Angles in degrees of turns about the fixed x axis first, then y, then z.
        rotation_degrees: Vec3,
    },
    /// Triangles. Both sides reflect and emit; as a dielectric the mesh is a closed body.
    Mesh {
        /// Mesh, shared among its instances: one allocation is one mesh.
        mesh: Arc<Mesh>,
        /// Transform of the mesh, any affine map that can be undone.
        world_from_mesh: DAffine3,
        /// Index in [`Scene::materials`] of the first of the materials that the mesh's parts name. Parts without a
        /// material, and all parts where this is `None`, have the shape's.
        first_material: Option<usize>,
    },
}

impl Geometry {
    /// Key in the scene file, which is also the name of the kind.
    pub fn key(&self) -> &'static str {
        match self {
            Self::Sphere { .. } => "sphere",
            Self::Plane { .. } => "plane",
            Self::Rectangle { .. } => "rectangle",
            Self::Disk { .. } => "disk",
            Self::Cylinder { .. } => "cylinder",
            Self::Cone { .. } => "cone",
            Self::Box { .. } => "box",
            Self::Mesh { .. } => "mesh",
        }
    }

    /// Whether there is no inside, so that a dielectric fills all that lies behind.
    pub fn is_sheet(&self) -> bool {
        match self {
            Self::Rectangle { .. } | Self::Disk { .. } => true,
            Self::Cylinder { capped, .. } | Self::Cone { capped, .. } => !capped,
            Self::Sphere { .. } | Self::Plane { .. } | Self::Box { .. } | Self::Mesh { .. } => false,
        }
    }
}

/// Axes of what lies around the unit vector `axis`, itself the last: images on it have the first to the right and the second
/// upward. They are those of `Frame` in `kernels/frame.slang` [duff2017basis].
pub fn axes_around(axis: DVec3) -> [DVec3; 3] {
    let sign = if axis.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + axis.z);
    let b = axis.x * axis.y * a;
    let x = DVec3::new(1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x);
    let y = DVec3::new(b, sign + axis.y * axis.y * a, -axis.y);
    [x, y, axis]
}

/// Rotation by `rotation_degrees` about the world's axes, x first, then y, then z. Its columns are the turned axes.
pub fn rotation(degrees: Vec3) -> DMat3 {
    let radians = degrees.as_dvec3() * (std::f64::consts::PI / 180.0);
    DMat3::from_euler(EulerRot::ZYX, radians.z, radians.y, radians.x)
}
