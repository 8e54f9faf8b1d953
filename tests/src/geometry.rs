//! Rays and shapes in double precision, with bounds on what single precision may make of them.
//!
//! A single-precision intersection is right when it is that of a ray and a shape moved by a few roundings of the
//! numbers involved. Where such a move decides between hit and miss, or between two faces, both answers are right: a
//! reference is therefore a list of [`Event`]s, some of which are certain.

use glam::{DMat3, DVec3, Vec3};
use raggio_scene::Geometry;

/// Relative error of one rounding to single precision, 2^-24.
pub const EPSILON: f64 = 5.960_464_477_539_063e-8;
/// Number of roundings on the longest way through any of the formulas. Measured errors reach about a third of what this
/// allows.
const ROUNDINGS: f64 = 8.0;

/// A ray; `direction` is a unit vector up to single-precision rounding.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Point at which the ray starts.
    pub origin: DVec3,
    /// Direction in which the ray goes.
    pub direction: DVec3,
    /// Distance from `origin` at which the device may have started the ray instead.
    pub origin_error: f64,
}

/// A crossing of a ray with the surface of a shape.
#[derive(Clone, Copy, Debug)]
pub struct Event {
    /// Distance along the ray.
    pub distance: f64,
    /// Difference of the distance that single precision may make.
    pub tolerance: f64,
    /// Normal of the surface, outward.
    pub normal: DVec3,
    /// Difference of a component of the normal that single precision may make.
    pub normal_tolerance: f64,
    /// Whether rounding cannot make the ray miss here.
    pub certain: bool,
}

/// Answer of a device to a ray.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Distance along the ray.
    pub distance: f64,
    /// Position of the hit.
    pub position: DVec3,
    /// Normal of the surface, outward.
    pub normal: DVec3,
}

/// Distance of an answer from the reference.
#[derive(Clone, Copy, Debug)]
pub struct Agreement {
    /// Error of the distance over its tolerance.
    pub ratio: f64,
    /// Whether single precision had no choice between hit and miss.
    pub certain: bool,
}

impl Ray {
    /// Point at `distance` along the ray.
    pub fn at(&self, distance: f64) -> DVec3 {
        self.origin + distance * self.direction
    }
}

/// Lists all crossings of `ray` with `shape`, in no order, also behind its origin.
pub fn events(shape: &Geometry, ray: &Ray) -> Vec<Event> {
    match *shape {
        Geometry::Mesh { .. } => unreachable!("meshes are compared with trial of every triangle"),
        Geometry::Sphere { center, radius } => sphere(center.as_dvec3(), f64::from(radius), ray),
        Geometry::Plane { point, normal } => plane(point.as_dvec3(), normal.as_dvec3(), ray).into_iter().collect(),
        Geometry::Rectangle { corner, edge_u, edge_v } => {
            rectangle(corner.as_dvec3(), edge_u.as_dvec3(), edge_v.as_dvec3(), ray).into_iter().collect()
        }
        Geometry::Disk { center, normal, radius } => {
            disk(center.as_dvec3(), normal.as_dvec3(), f64::from(radius), ray).into_iter().collect()
        }
        Geometry::Cylinder { base, top, radius, capped } => Frustum::new([base, top], [radius; 2]).events(capped, ray),
        Geometry::Cone { base, top, radius, top_radius, capped } => {
            Frustum::new([base, top], [radius, top_radius]).events(capped, ray)
        }
        Geometry::Box { center, size, rotation_degrees } => {
            turned_box(center.as_dvec3(), 0.5 * size.as_dvec3(), rotation(rotation_degrees.as_dvec3()), ray)
        }
    }
}

/// Finds the nearest crossing in front of `ray`, rounding aside.
pub fn nearest(shape: &Geometry, ray: &Ray) -> Option<Event> {
    let ahead = events(shape, ray).into_iter().filter(|event| event.distance > 0.0);
    ahead.min_by(|a, b| a.distance.total_cmp(&b.distance))
}

/// Compares an answer with the reference; the error says how they contradict each other.
pub fn check(shape: &Geometry, ray: &Ray, found: Option<Found>) -> Result<Agreement, String> {
    let events = events(shape, ray);
    let ahead = || events.iter().filter(|e| e.distance > -e.tolerance);
    let certain = ahead().filter(|e| e.certain && e.distance > e.tolerance);
    let limit = certain.map(|e| e.distance + e.tolerance).fold(f64::INFINITY, f64::min);
    // Each crossing here may be the nearest.
    let candidates: Vec<_> = ahead().filter(|e| e.distance - e.tolerance <= limit).collect();
    let choice = candidates.iter().any(|e| !(e.certain && e.distance > e.tolerance));
    let Some(found) = found else {
        return if limit.is_infinite() {
            Ok(Agreement { ratio: 0.0, certain: candidates.is_empty() })
        } else {
            Err(format!("missed what it must hit: {candidates:?}"))
        };
    };
    let size = extent(shape) + ray.origin.abs().max_element();
    let ratio = |e: &&Event| {
        // Lateral errors are roundings of the position's own numbers, whatever the angle.
        let position_tolerance = e.tolerance + ROUNDINGS * EPSILON * (size + e.distance.abs());
        let position = (found.position - ray.at(e.distance)).length() / position_tolerance;
        let normal = (found.normal - e.normal).abs().max_element() / e.normal_tolerance;
        ((found.distance - e.distance).abs() / e.tolerance).max(position).max(normal)
    };
    let ratio = candidates.iter().map(ratio).fold(f64::INFINITY, f64::min);
    if ratio <= 1.0 {
        Ok(Agreement { ratio, certain: !choice })
    } else {
        Err(format!("found {found:?}, {ratio:.3} times as far as allowed from any of {candidates:?}"))
    }
}

/// Largest of the numbers that describe a shape.
fn extent(shape: &Geometry) -> f64 {
    match *shape {
        Geometry::Mesh { .. } => unreachable!("meshes are compared with trial of every triangle"),
        Geometry::Sphere { center, radius } | Geometry::Disk { center, radius, .. } => {
            center.as_dvec3().abs().max_element() + f64::from(radius)
        }
        Geometry::Cylinder { base, top, radius, .. } | Geometry::Cone { base, top, radius, .. } => {
            let [base, top] = [base, top].map(|center| center.as_dvec3());
            base.abs().max_element() + (top - base).length() + 2.0 * f64::from(radius)
        }
        Geometry::Plane { point, .. } => point.as_dvec3().abs().max_element(),
        Geometry::Rectangle { corner, edge_u, edge_v } => {
            [corner, edge_u, edge_v].map(|v| v.as_dvec3().abs().max_element()).iter().sum()
        }
        Geometry::Box { center, size, .. } => center.as_dvec3().abs().max_element() + size.as_dvec3().element_sum(),
    }
}

fn sphere(center: DVec3, radius: f64, ray: &Ray) -> Vec<Event> {
    let from_center = ray.origin - center;
    let direction = ray.direction.normalize();
    let b = -from_center.dot(direction);
    let to_line = from_center + b * direction;
    // The line may pass this much nearer to the centre or farther from it.
    let moved = ROUNDINGS * EPSILON * (from_center.length() + radius) + ray.origin_error;
    let chord2 = radius * radius - to_line.length_squared();
    let chord2_tolerance = 2.0 * to_line.length().max(radius) * moved + moved * moved;
    if chord2 < -chord2_tolerance {
        return vec![];
    }
    let half_chord = chord2.max(0.0).sqrt();
    let certain = chord2 > chord2_tolerance;
    let chord_tolerance = if certain { chord2_tolerance / half_chord } else { (2.0 * chord2_tolerance).sqrt() };
    let tolerance = moved + chord_tolerance;
    let scale = center.abs().max_element() + ray.origin.abs().max_element();
    let event = |distance: f64| {
        let normal = (ray.at(distance) - center) / radius;
        let normal_tolerance = (tolerance + ROUNDINGS * EPSILON * (scale + distance.abs())) / radius;
        Event { distance, tolerance, normal, normal_tolerance, certain }
    };
    vec![event(b - half_chord), event(b + half_chord)]
}

fn plane(point: DVec3, normal: DVec3, ray: &Ray) -> Option<Event> {
    let cosine = normal.dot(ray.direction);
    let cosine_tolerance = ROUNDINGS * EPSILON;
    if cosine == 0.0 {
        return None;
    }
    let distance = normal.dot(point - ray.origin) / cosine;
    let moved = ROUNDINGS * EPSILON * (point.abs().max_element() + ray.origin.abs().max_element());
    let tolerance = (moved + cosine_tolerance * distance.abs()) / cosine.abs();
    let certain = cosine.abs() > 2.0 * cosine_tolerance;
    Some(Event { distance, tolerance, normal, normal_tolerance: ROUNDINGS * EPSILON, certain })
}

fn rectangle(corner: DVec3, edge_u: DVec3, edge_v: DVec3, ray: &Ray) -> Option<Event> {
    let mut event = plane(corner, edge_u.cross(edge_v).normalize(), ray)?;
    let inside = ray.at(event.distance) - corner;
    let size = ray.origin.abs().max_element() + corner.abs().max_element() + edge_u.length() + edge_v.length();
    let margin = event.tolerance + ROUNDINGS * EPSILON * (size + event.distance.abs());
    let room = |edge: DVec3| {
        let along = inside.dot(edge) / edge.length();
        along.min(edge.length() - along)
    };
    let room = room(edge_u).min(room(edge_v));
    event.certain &= room > margin;
    (room > -margin).then_some(event)
}

fn disk(center: DVec3, normal: DVec3, radius: f64, ray: &Ray) -> Option<Event> {
    let mut event = plane(center, normal, ray)?;
    let size = ray.origin.abs().max_element() + center.abs().max_element() + radius;
    let margin = event.tolerance + ROUNDINGS * EPSILON * (size + event.distance.abs());
    let room = radius - ray.at(event.distance).distance(center);
    event.certain &= room > margin;
    (room > -margin).then_some(event)
}

/// The part of a cone between two circles, of which a cylinder is one.
struct Frustum {
    base: DVec3,
    /// Unit, from the first circle to the second.
    axis: DVec3,
    height: f64,
    radii: [f64; 2],
}

/// Where a line is inside of a cone without ends: the roots, each with its answer to whether it is entered there, `None` if the
/// line is inside nowhere or everywhere.
type Roots = Option<Vec<(f64, bool)>>;

impl Frustum {
    fn new(centers: [Vec3; 2], radii: [f32; 2]) -> Self {
        let [base, top] = centers.map(|center| center.as_dvec3());
        let height = (top - base).length();
        Self { base, axis: (top - base) / height, height, radii: radii.map(f64::from) }
    }

    fn slope(&self) -> f64 {
        (self.radii[1] - self.radii[0]) / self.height
    }

    /// Place along the axis, and the vector from the axis.
    fn local(&self, v: DVec3) -> (f64, DVec3) {
        let z = v.dot(self.axis);
        (z, v - z * self.axis)
    }

    /// Roots on this side of the apex where the radii are larger by `more`, and their squares by as much as that is of the first:
    /// roundings of squares grow no smaller toward an apex.
    fn roots(&self, ray: &Ray, more: f64) -> Roots {
        // Distances count from where the ray passes the middle, or roundings of a far origin would show.
        let middle = self.base + 0.5 * self.height * self.axis;
        let direction = ray.direction.normalize();
        let shift = (middle - ray.origin).dot(direction);
        let (z, across) = self.local(ray.origin + shift * direction - self.base);
        let (rise, drift) = self.local(direction);
        let (width, growth) = (self.radii[0] + more + self.slope() * z, self.slope() * rise);
        let a = drift.length_squared() - growth * growth;
        let b = drift.dot(across) - growth * width;
        let c = across.length_squared() - width * width - more * self.radii[0];
        let root = (b * b - a * c).sqrt();
        let [first, second] =
            if b < 0.0 { [(root - b) / a, c / (root - b)] } else { [-(b + root) / a, -c / (b + root)] };
        let (near, far) = (shift + first.min(second), shift + first.max(second));
        match () {
            () if a > 0.0 && near <= far => Some(vec![(near, true), (far, false)]),
            () if a < 0.0 && near <= far => Some(vec![if growth > 0.0 { (far, true) } else { (near, false) }]),
            // With larger radii there is a way through where the apex is.
            () if a < 0.0 => Some(vec![]),
            () => None,
        }
    }

    /// Crossings of the side as if it had no ends, each with whether it is entered, and whether all of them are certain. `None`: the
    /// line passes it by.
    fn side(&self, ray: &Ray) -> Option<(Vec<(Event, bool)>, bool)> {
        let size = ray.origin.abs().max_element() + self.base.abs().max_element();
        let moved = (ROUNDINGS * EPSILON * (size + self.height + 2.0 * self.radii[0]) + ray.origin_error)
            * (1.0 + self.slope().abs());
        let (inner, outer) = (self.roots(ray, -moved), self.roots(ray, moved)?);
        let nominal = self.roots(ray, 0.0);
        let certain = inner.is_some();
        // Rays that graze the side, or nearly run along it, meet it anywhere between these.
        let roots = nominal.unwrap_or_else(|| {
            let middle = outer.iter().map(|root| root.0).sum::<f64>() / outer.len() as f64;
            outer.iter().map(|root| (middle, root.1)).collect()
        });
        let spread = |of: &Roots, distance: f64| {
            let nearest = of.iter().flatten().map(|root| (root.0 - distance).abs());
            nearest.fold(f64::INFINITY, f64::min)
        };
        let outer = Some(outer);
        let event = |(distance, enters): (f64, bool)| {
            let inner_spread = if certain { spread(&inner, distance) } else { 0.0 };
            let has_outer = outer.iter().flatten().next().is_some();
            let outer_spread = if has_outer { spread(&outer, distance) } else { 3.0 * inner_spread };
            let tolerance = moved + outer_spread.max(inner_spread);
            let (z, across) = self.local(ray.at(distance) - self.base);
            let radius = (self.radii[0] + self.slope() * z).abs();
            let normal = (across.normalize_or_zero() - self.slope() * self.axis).normalize();
            let normal_tolerance = 2.0 * (tolerance + moved) / radius.max(1e-30) + ROUNDINGS * EPSILON;
            (Event { distance, tolerance, normal, normal_tolerance, certain }, enters)
        };
        Some((roots.into_iter().map(event).collect(), certain))
    }

    /// Crossings of the planes of both ends.
    fn ends(&self, ray: &Ray) -> [Option<(Event, bool)>; 2] {
        [(self.base, -self.axis), (self.base + self.height * self.axis, self.axis)].map(|(center, normal)| {
            // A ray along the planes meets them far away, on its side of them.
            let tilted = Ray { direction: ray.direction + 1e-30 * self.axis, ..*ray };
            let event = plane(center, normal, &tilted)?;
            Some((event, normal.dot(tilted.direction) < 0.0))
        })
    }

    /// Bound on the error of a place along the axis.
    fn margin(&self, event: &Event, ray: &Ray) -> f64 {
        let size = ray.origin.abs().max_element() + self.base.abs().max_element() + self.height + 2.0 * self.radii[0];
        event.tolerance + ROUNDINGS * EPSILON * (size + event.distance.abs())
    }

    fn events(&self, capped: bool, ray: &Ray) -> Vec<Event> {
        let (side, certain) = match self.side(ray) {
            Some(side) => side,
            // A line along the axis is inside everywhere.
            None if capped => {
                let (_, across) = self.local(ray.origin - self.base);
                let (_, drift) = self.local(ray.direction);
                if across.length() > self.radii[0] || drift.length() > 1e-6 {
                    return vec![];
                }
                (vec![], true)
            }
            None => return vec![],
        };
        if !capped {
            let place = |event: &Event| self.local(ray.at(event.distance) - self.base).0;
            let room = |event: &Event| place(event).min(self.height - place(event));
            let near = side.into_iter().map(|(event, _)| event);
            let near = near.filter(|event| room(event) > -self.margin(event, ray));
            return near.map(|e| Event { certain: e.certain && room(&e) > self.margin(&e, ray), ..e }).collect();
        }
        let crossings: Vec<_> = side.into_iter().chain(self.ends(ray).into_iter().flatten()).collect();
        convex(&crossings, certain)
    }
}

fn turned_box(center: DVec3, half: DVec3, axes: DMat3, ray: &Ray) -> Vec<Event> {
    let origin = axes.transpose() * (ray.origin - center);
    let direction = axes.transpose() * ray.direction;
    let moved =
        ROUNDINGS * EPSILON * (ray.origin.abs().max_element() + center.abs().max_element() + half.max_element());
    let mut crossings = vec![];
    for axis in 0..3 {
        let d = if direction[axis] == 0.0 { 1e-30 } else { direction[axis] };
        for side in [-1.0, 1.0] {
            let distance = (side * half[axis] - origin[axis]) / d;
            let tolerance = (moved + ROUNDINGS * EPSILON * distance.abs()) / d.abs();
            let event = Event {
                distance,
                tolerance,
                normal: side * axes.col(axis),
                normal_tolerance: ROUNDINGS * EPSILON,
                certain: true,
            };
            crossings.push((event, side * d < 0.0));
        }
    }
    convex(&crossings, true)
}

/// Surfaces of a convex body, from the crossings of all its sides, each as if it had no end, with whether it is entered there.
fn convex(crossings: &[(Event, bool)], certain: bool) -> Vec<Event> {
    let of = |entering: bool| crossings.iter().filter(move |(_, e)| *e == entering).map(|(event, _)| *event);
    let (near, far) = (boundary(of(true).map(flipped).collect()), boundary(of(false).collect()));
    let near = near.into_iter().map(flipped);
    // The last side to be entered must be entered before the first is left.
    let bounds = |sign: f64| {
        let entered = near.clone().map(|e| e.distance + sign * e.tolerance).fold(f64::NEG_INFINITY, f64::max);
        let left = far.iter().map(|e| e.distance - sign * e.tolerance).fold(f64::INFINITY, f64::min);
        entered < left
    };
    let (certain, possible) = (certain && bounds(1.0), bounds(-1.0));
    let surfaces = near.chain(far.clone()).map(|e| Event { certain, ..e });
    if possible { surfaces.collect() } else { vec![] }
}

/// Keeps those crossings of a body's sides that may come first.
fn boundary(mut events: Vec<Event>) -> Vec<Event> {
    let first = events.iter().map(|e| e.distance + e.tolerance).fold(f64::INFINITY, f64::min);
    events.retain(|e| e.distance - e.tolerance <= first);
    events
}

/// Reverses time: the last entry is the first exit.
fn flipped(event: Event) -> Event {
    Event { distance: -event.distance, ..event }
}

/// Rotation about the fixed x axis first, then y, then z: a product of the three textbook matrices.
pub fn rotation(degrees: DVec3) -> DMat3 {
    let [x, y, z] = degrees.to_array().map(f64::to_radians);
    DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x)
}

/// Snell's law: the refracted direction of a unit vector `d` at a surface with unit normal `n`, for `eta` = index
/// before over index after; `None` under total internal reflection.
pub fn refracted(d: DVec3, n: DVec3, eta: f64) -> Option<DVec3> {
    let n = if d.dot(n) < 0.0 { n } else { -n };
    let cosine = -d.dot(n);
    let sine2 = eta * eta * (1.0 - cosine * cosine);
    (sine2 < 1.0).then(|| eta * d + (eta * cosine - (1.0 - sine2).sqrt()) * n)
}

/// Fresnel's unpolarised reflectance from the angle of incidence, in its textbook form of sines and tangents.
pub fn fresnel(radians: f64, eta: f64) -> f64 {
    if radians == 0.0 {
        return ((eta - 1.0) / (eta + 1.0)).powi(2);
    }
    let sine = eta * radians.sin();
    if sine >= 1.0 {
        return 1.0;
    }
    let refracted = sine.asin();
    let perpendicular = (radians - refracted).sin() / (radians + refracted).sin();
    let parallel = (radians - refracted).tan() / (radians + refracted).tan();
    0.5 * (perpendicular * perpendicular + parallel * parallel)
}
