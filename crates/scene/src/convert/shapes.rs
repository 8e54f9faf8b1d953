//! Shapes: one geometry each, a material that exists, right angles where they are needed.

use glam::DVec3;

use super::{Builder, dvec3, vec3};
use crate::fault::{Fault, Kind, Step, place, steps, subject};
use crate::file::{BoxFile, Materials, PlaneFile, RectangleFile, ShapeFile, SphereFile};
use crate::names;
use crate::number::SMALLEST;
use crate::scene::{Entry, Geometry, Shape};

/// Largest cosine of the angle between a rectangle's edges; files round their numbers.
const PERPENDICULAR: f64 = 1e-4;

impl Builder<'_, '_> {
    /// Adds a shape; `index` is its place in the file. Faults are noted but for the one that is returned.
    pub(super) fn add(&mut self, index: usize, file: &ShapeFile, materials: &Materials) -> Result<(), Fault> {
        let material = file.material.as_ref().map(|name| self.material(index, name, materials));
        refuse_two(index, file)?;
        let first = self.scene.shapes.len();
        let placement = match &file.mesh {
            Some(mesh) => Some(self.add_model(index, mesh, material)?),
            None => self.add_other(index, file, material).map(|()| None)?,
        };
        self.scene.entries.push(Entry { shapes: first..self.scene.shapes.len(), material, placement });
        Ok(())
    }

    /// Index of the material of that name, and of the first where there is no such name.
    fn material(&self, index: usize, name: &str, materials: &Materials) -> usize {
        if let Some(material) = self.indices.get(name) {
            return *material;
        }
        // Where a whole section is unknown or wrong, the materials may be in it.
        if !self.files.review.has(|place| place.len() == 1) {
            self.files.review.object(unknown_material(index, name, materials));
        }
        0
    }

    fn add_other(&mut self, index: usize, file: &ShapeFile, material: Option<usize>) -> Result<(), Fault> {
        if material.is_none() {
            self.files.review.object(Fault::new(Kind::MissingKey("material")).below(steps!["shapes", index]));
        }
        let geometry = geometry(index, file)?;
        self.scene.shapes.push(Shape { entry: index, material: material.unwrap_or_default(), geometry });
        Ok(())
    }
}

fn unknown_material(index: usize, name: &str, materials: &Materials) -> Fault {
    let known: Vec<&str> = materials.0.iter().map(|(name, _)| name.as_str()).collect();
    let hint = if known.is_empty() {
        format!("the scene has no materials, so add [materials.{}]", names::key(name))
    } else {
        names::hint(name, &known)
    };
    let message = format!("unknown material {} in shape {}: {hint}", names::quoted(name), index + 1);
    Fault::value(steps!["shapes", index, "material"], message)
}

fn refuse_two(index: usize, file: &ShapeFile) -> Result<(), Fault> {
    let mut given = file.geometries().filter(|(_, is_given)| *is_given).map(|(key, _)| key);
    let (Some(first), Some(second)) = (given.next(), given.next()) else {
        return Ok(());
    };
    let message = format!("shape {} has both `{first}` and `{second}`: write a `[[shapes]]` for each", index + 1);
    Err(Fault::key(steps!["shapes", index, second], message))
}

fn geometry(index: usize, file: &ShapeFile) -> Result<Geometry, Fault> {
    let at = |key: &str| steps!["shapes", index, key];
    if let Some(sphere) = &file.sphere {
        Ok(self::sphere(sphere))
    } else if let Some(plane) = &file.plane {
        self::plane(plane, at("plane"))
    } else if let Some(rectangle) = &file.rectangle {
        self::rectangle(rectangle, at("rectangle"))
    } else if let Some(cuboid) = &file.cuboid {
        Ok(self::cuboid(cuboid))
    } else {
        let keys: Vec<_> = file.geometries().map(|(key, _)| format!("`{key}`")).collect();
        let message = format!("shape {} has no geometry: give it one of {}", index + 1, keys.join(", "));
        Err(Fault::value(steps!["shapes", index], message))
    }
}

fn sphere(file: &SphereFile) -> Geometry {
    Geometry::Sphere { center: vec3(file.center), radius: file.radius.0 as f32 }
}

fn plane(file: &PlaneFile, at: Vec<Step>) -> Result<Geometry, Fault> {
    let normal = not_zero(dvec3(file.normal), &at, "normal")?;
    Ok(Geometry::Plane { point: vec3(file.point), normal: normal.normalize().as_vec3() })
}

fn rectangle(file: &RectangleFile, at: Vec<Step>) -> Result<Geometry, Fault> {
    let edge_u = not_zero(dvec3(file.edge_u), &at, "edge_u")?;
    let edge_v = not_zero(dvec3(file.edge_v), &at, "edge_v")?;
    let cosine = edge_u.normalize().dot(edge_v.normalize());
    if cosine.abs() > PERPENDICULAR {
        let message = not_perpendicular(edge_u, edge_v, &at);
        return Err(Fault::value(below(&at, "edge_v"), message));
    }
    Ok(Geometry::Rectangle { corner: vec3(file.corner), edge_u: edge_u.as_vec3(), edge_v: edge_v.as_vec3() })
}

fn cuboid(file: &BoxFile) -> Geometry {
    Geometry::Box { center: vec3(file.center), size: vec3(file.size), rotation_degrees: vec3(file.rotation_degrees) }
}

fn below(at: &[Step], key: &str) -> Vec<Step> {
    [at, &[Step::from(key)]].concat()
}

/// The vector itself, unless 32-bit arithmetic could not tell it from zero.
fn not_zero(vector: DVec3, at: &[Step], key: &str) -> Result<DVec3, Fault> {
    if vector.length() >= SMALLEST {
        return Ok(vector);
    }
    let at = below(at, key);
    let wrong = if vector == DVec3::ZERO {
        "must not be zero: it gives a direction"
    } else {
        "is too short: it must be at least 1e-15 long"
    };
    let message = format!("{} {wrong}", subject(&at));
    Err(Fault::value(at, message))
}

/// Message that says the angle, and the edge nearest to the given one that would be right.
fn not_perpendicular(edge_u: DVec3, edge_v: DVec3, at: &[Step]) -> String {
    let place = place(at);
    let degrees = edge_u.angle_between(edge_v).to_degrees();
    let angle = tidy(degrees);
    let right = edge_v - edge_u * (edge_u.dot(edge_v) / edge_u.length_squared());
    // Edges all but parallel leave only rounding errors to suggest.
    let advice = if right.length() > 1e-6 * edge_v.length() {
        let [x, y, z] = right.to_array().map(tidy);
        format!("`edge_v = [{x}, {y}, {z}]` would be perpendicular")
    } else {
        "point `edge_v` another way".to_string()
    };
    format!("`edge_u` and `edge_v` {place} meet at {angle} degrees, not at 90: {advice}")
}

/// The number rounded to six digits.
fn tidy(x: f64) -> f64 {
    // Adding zero turns -0 into 0.
    format!("{x:.5e}").parse().unwrap_or(x) + 0.0
}
