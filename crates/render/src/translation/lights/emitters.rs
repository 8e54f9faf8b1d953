//! Lists what gives off light, as kernels sample it.

use glam::Vec3;
use raggio_kernels::{
    Emitter, EmitterKind, Instance, Light, LightKind, NO_TEXTURE, NONE, PrincipledTexture, ROUND_BOTTOM, ROUND_SIDE,
    ROUND_TOP, Round, SceneBuffers, ShapeKind, ShapeReference,
};

use super::bounds::LightBounds;
use super::luminance;
use crate::translation::textures::mean;

/// Emitters, and bounds of each.
#[derive(Default)]
pub(super) struct Listed {
    pub emitters: Vec<Emitter>,
    pub bounds: Vec<LightBounds>,
}

impl Listed {
    fn push(&mut self, kind: EmitterKind, shape: usize, part: usize, bounds: LightBounds) {
        self.emitters.push(Emitter { kind: kind as u32, shape: shape as u32, part: part as u32, leaf: 0 });
        self.bounds.push(bounds);
    }
}

/// The luminous surfaces of a scene, at most `limit`; each shape comes to know which are its own.
pub(super) fn surfaces(buffers: &mut SceneBuffers, limit: usize) -> Listed {
    let radiance: Vec<f32> = (0..buffers.materials.len()).map(|material| radiance(buffers, material)).collect();
    let mut listed = Listed::default();
    let mut order = buffers.order.to_vec();
    for (place, shape) in order.iter_mut().enumerate() {
        let first = listed.emitters.len();
        list_shape(buffers, place, shape, &radiance, &mut listed);
        if listed.emitters.len() > limit {
            listed.emitters.truncate(first);
            listed.bounds.truncate(first);
        }
        shape.first_emitter = first as u32;
        shape.emitters = (listed.emitters.len() - first) as u32;
    }
    buffers.order = order.into();
    listed
}

/// The luminance that a material gives off, where textures have their mean; 0 also of those that refract.
fn radiance(buffers: &SceneBuffers, material: usize) -> f32 {
    let material = &buffers.materials[material];
    if material.refractive_index > 0.0 {
        return 0.0;
    }
    let found = match buffers.principled.get(material.principled as usize) {
        None => luminance(material.emission),
        Some(principled) => {
            let factor = principled.emissive;
            let mean = match principled.textures[PrincipledTexture::Emissive as usize] {
                _ if factor == [0.0; 3] => [0.0; 3],
                NO_TEXTURE => [1.0; 3],
                texture => mean(&buffers.textures[texture as usize], &buffers.texels),
            };
            luminance([0, 1, 2].map(|i| factor[i] * mean[i]))
        }
    };
    if found.is_finite() { found } else { f32::MAX }
}

fn list_shape(buffers: &SceneBuffers, place: usize, shape: &ShapeReference, radiance: &[f32], listed: &mut Listed) {
    let index = shape.index as usize;
    let is = |kind: ShapeKind| shape.kind == kind as u32;
    if is(ShapeKind::Sphere) {
        let sphere = &buffers.spheres[index];
        let (center, radius) = (Vec3::from(sphere.center), Vec3::splat(sphere.radius));
        let power = radiance[sphere.material as usize] * std::f32::consts::PI * sphere.radius * sphere.radius;
        if power > 0.0 {
            listed.push(EmitterKind::Sphere, place, 0, LightBounds::round(center - radius, center + radius, power));
        }
    } else if is(ShapeKind::Rectangle) {
        let rectangle = &buffers.rectangles[index];
        let [corner, u, v] = [rectangle.corner, rectangle.edge_u, rectangle.edge_v].map(Vec3::from);
        let bounds = parallelogram(corner, u, v, radiance[rectangle.material as usize], true);
        if bounds.power > 0.0 {
            listed.push(EmitterKind::Rectangle, place, 0, bounds);
        }
    } else if is(ShapeKind::Box) {
        let cuboid = &buffers.boxes[index];
        let center = Vec3::from(cuboid.center);
        let half =
            [0, 1, 2].map(|i| cuboid.half_size[i] * Vec3::from([cuboid.axis_x, cuboid.axis_y, cuboid.axis_z][i]));
        if radiance[cuboid.material as usize] > 0.0 {
            for face in 0..6 {
                let [n, u, v] = [0, 1, 2].map(|i| half[(face / 2 + i) % 3]);
                // Two edges whose product points outward.
                let (n, u) = if face % 2 == 1 { (n, u) } else { (-n, -u) };
                let corner = center + n - u - v;
                let bounds = parallelogram(corner, 2.0 * u, 2.0 * v, radiance[cuboid.material as usize], false);
                listed.push(EmitterKind::BoxFace, place, face, bounds);
            }
        }
    } else if is(ShapeKind::Round) {
        let round = &buffers.rounds[index];
        list_round(place, round, radiance[round.material as usize], listed);
    } else if is(ShapeKind::Instance) {
        list_triangles(buffers, place, &buffers.instances[index], radiance, listed);
    }
}

fn list_round(place: usize, round: &Round, radiance: f32, listed: &mut Listed) {
    if radiance <= 0.0 {
        return;
    }
    let [base, axis] = [round.base, round.axis_z].map(Vec3::from);
    let top = base + round.height * axis;
    // A circle reaches along an axis as far as the sine of its own axis' angle with that.
    let across = Vec3::new(axis.y.hypot(axis.z), axis.z.hypot(axis.x), axis.x.hypot(axis.y));
    let circle = |center: Vec3, radius: f32| (center - radius * across, center + radius * across);
    let area = |radius: f32| std::f32::consts::PI * radius * radius;
    let flat = |center: Vec3, radius: f32, normal: Vec3, two_sided: bool| {
        let (lower, upper) = circle(center, radius);
        LightBounds::flat(lower, upper, (radiance * area(radius)).clamp(f32::MIN_POSITIVE, f32::MAX), normal, two_sided)
    };
    if round.height == 0.0 {
        listed.push(EmitterKind::Round, place, ROUND_SIDE as usize, flat(base, round.radius, axis, true));
        return;
    }
    let closed = round.capped != 0;
    let ((a, b), (c, d)) = (circle(base, round.radius), circle(top, round.top_radius));
    let stretch = (1.0 + round.slope * round.slope).sqrt();
    // Mean area of its outline: what a closed one shows to all sides is a quarter of its surface.
    let power = radiance * (round.radius + round.top_radius) * round.height * stretch;
    let power = power.clamp(f32::MIN_POSITIVE, f32::MAX);
    // Normals lean toward the narrow end, all by one angle.
    let toward = if round.slope > 0.0 { -axis } else { axis };
    let spread = (round.slope.abs() / stretch).acos();
    let side = LightBounds { spread, ..LightBounds::flat(a.min(c), b.max(d), power, toward, !closed) };
    listed.push(EmitterKind::Round, place, ROUND_SIDE as usize, side);
    if closed {
        listed.push(EmitterKind::Round, place, ROUND_BOTTOM as usize, flat(base, round.radius, -axis, false));
        if round.top_radius > 0.0 {
            listed.push(EmitterKind::Round, place, ROUND_TOP as usize, flat(top, round.top_radius, axis, false));
        }
    }
}

fn parallelogram(corner: Vec3, u: Vec3, v: Vec3, radiance: f32, two_sided: bool) -> LightBounds {
    let across = u.cross(v);
    let zero = Vec3::ZERO;
    let (lower, upper) = (corner + u.min(zero) + v.min(zero), corner + u.max(zero) + v.max(zero));
    let power = radiance * across.length();
    LightBounds::flat(lower, upper, power.min(f32::MAX), across.normalize_or(Vec3::Z), two_sided)
}

fn list_triangles(buffers: &SceneBuffers, place: usize, instance: &Instance, radiance: &[f32], listed: &mut Listed) {
    let mesh = &buffers.meshes[instance.mesh as usize];
    let material = |own: u32| match (instance.first_material, own) {
        (NONE, _) | (_, NONE) => instance.material as usize,
        (first, own) => (first + own) as usize,
    };
    let named = (0..mesh.materials).chain([NONE]);
    if !named.map(material).any(|material| radiance[material] > 0.0) {
        return;
    }
    let rows = instance.world_from_mesh;
    let map = |p: [f32; 4]| Vec3::from(rows.map(|[x, y, z, w]| x * p[0] + y * p[1] + z * p[2] + w));
    for index in mesh.first_triangle as usize..(mesh.first_triangle + mesh.triangles) as usize {
        let radiance = radiance[material(buffers.triangle_materials[index])];
        if radiance <= 0.0 {
            continue;
        }
        let triangle = &buffers.triangles[index];
        let [a, b, c] = [triangle.a, triangle.b, triangle.c].map(map);
        let across = (b - a).cross(c - a);
        let power = (0.5 * radiance * across.length()).min(f32::MAX);
        // A triangle without area cannot be sampled, and is not seen.
        if power > 0.0 {
            let normal = instance.handedness * across.normalize_or(Vec3::Z);
            let bounds = LightBounds::flat(a.min(b).min(c), a.max(b).max(c), power, normal, true);
            listed.push(EmitterKind::Triangle, place, index, bounds);
        }
    }
}

/// Adds the lights that are no surfaces.
pub(super) fn lights(buffers: &SceneBuffers, listed: &mut Listed) {
    for (place, light) in buffers.lights.iter().enumerate() {
        let power = luminance(light.intensity).min(f32::MAX);
        if light.kind == LightKind::Sun as u32 {
            listed.push(EmitterKind::Sun, place, 0, sun_bounds(light, power));
        } else if power > 0.0 {
            listed.push(EmitterKind::Light, place, 0, light_bounds(light, power));
        }
    }
}

/// Bounds of a sun of this radiance: its offset is 1 - cosine of the angle to its rim.
fn sun_bounds(sun: &Light, radiance: f32) -> LightBounds {
    let half_angle = 2.0 * (0.5 * sun.angle_offset).sqrt().min(1.0).asin();
    // However dim, it is listed.
    let irradiance = (radiance * std::f32::consts::PI * half_angle.sin().powi(2)).max(f32::MIN_POSITIVE);
    LightBounds { spread: half_angle, ..LightBounds::distant(-Vec3::from(sun.direction), irradiance) }
}

fn light_bounds(light: &Light, power: f32) -> LightBounds {
    let [position, direction] = [light.position, light.direction].map(Vec3::from);
    if light.kind == LightKind::Directional as u32 {
        return LightBounds::distant(-direction, power);
    }
    if light.kind == LightKind::Point as u32 {
        return LightBounds::round(position, position, power);
    }
    // The outer angle is where the fading cosine is 0.
    let outer = (-light.angle_offset / light.angle_scale).clamp(-1.0, 1.0).acos();
    LightBounds::spot(position, power, direction, outer)
}
