//! Shapes: one geometry each, a material that exists, right angles where they are needed.

use glam::{DAffine3, DVec3};
use raggio_models::Light;

use super::meshes::placed;
use super::transform::transformed;
use super::{Builder, dvec3, vec3};
use crate::fault::{Fault, Kind, Step, place, steps, subject};
use crate::file::{
    BoxFile, ConeFile, CylinderFile, DiskFile, Materials, PlaneFile, Point, RectangleFile, ShapeFile, SphereFile,
};
use crate::names;
use crate::number::SMALLEST;
use crate::scene::{Contents, Entry, Geometry, Shape, Transform};

/// Largest cosine of the angle between a rectangle's edges; files round their numbers.
const PERPENDICULAR: f64 = 1e-4;

/// Most shapes of a scene: groups of groups would make any number of a short text.
const MOST_SHAPES: usize = 1 << 22;

/// Result of one table of the file, be it one of the `[[shapes]]` or of a group.
pub(super) struct Piece {
    pub contents: Contents,
    pub transform: Transform,
    /// Material that the file names.
    pub material: Option<usize>,
    pub parts: Parts,
}

/// Shapes, each with its material, and lights of models.
#[derive(Clone, Default)]
pub(super) struct Parts {
    pub shapes: Vec<(usize, Geometry)>,
    pub lights: Vec<Light>,
}

impl Parts {
    /// What becomes of them by a transform, which is at `at` in the file.
    fn transformed(self, map: &DAffine3, at: &[Step]) -> Result<Self, Fault> {
        let place = |(material, geometry): (usize, Geometry)| Ok((material, transformed(&geometry, map, at)?));
        let shapes = self.shapes.into_iter().map(place).collect::<Result<_, Fault>>()?;
        Ok(Self { shapes, lights: self.lights.iter().map(|light| placed(light, map)).collect() })
    }
}

impl Builder<'_, '_> {
    /// Adds a shape; `index` is its place in the file. Faults are noted but for the one that is returned.
    pub(super) fn add(&mut self, index: usize, file: &ShapeFile) -> Result<(), Fault> {
        let at = steps!["shapes", index];
        let piece = self.piece(&at, file)?;
        let first = self.scene.shapes.len();
        if first + piece.parts.shapes.len() > MOST_SHAPES {
            let message = format!("with {} the scene has more than {MOST_SHAPES} shapes", subject(&at));
            return Err(Fault::value(at, message));
        }
        let shape = |(material, geometry)| Shape { entry: index, material, geometry };
        self.scene.shapes.extend(piece.parts.shapes.into_iter().map(shape));
        self.scene.lights.extend(piece.parts.lights);
        let Piece { contents, transform, material, .. } = piece;
        self.scene.entries.push(Entry { shapes: first..self.scene.shapes.len(), material, contents, transform });
        Ok(())
    }

    /// Reads the groups that no shape names, whose faults would be told by nobody.
    pub(super) fn check_groups(&mut self) {
        let groups = self.groups;
        for (name, _) in &groups.0 {
            if !self.known_groups.contains_key(name) {
                let parts = self.group(name, &["groups".into(), name.as_str().into()]);
                self.files.review.accept(parts.map(drop));
            }
        }
    }

    /// What a table at `at` of the file says.
    fn piece(&mut self, at: &[Step], file: &ShapeFile) -> Result<Piece, Fault> {
        let material = file.material.as_ref().map(|name| self.material(at, name));
        refuse_two(at, file)?;
        let of_transform = file.transform.as_ref().map(|transform| (transform, below(at, "transform")));
        let transform = of_transform.as_ref().map(|(file, at)| super::transform::transform(file, at)).transpose()?;
        let (contents, parts) = if let Some(mesh) = &file.mesh {
            let (placement, parts) = self.model(at, mesh, material)?;
            (Contents::Model(placement), parts)
        } else if let Some(name) = &file.group {
            let mut parts = self.group(name, &below(at, "group"))?;
            if let Some(material) = material {
                parts.shapes.iter_mut().for_each(|shape| paint(shape, material));
            }
            (Contents::Group(name.clone()), parts)
        } else {
            if material.is_none() {
                self.files.review.object(Fault::new(Kind::MissingKey("material")).below(at.to_vec()));
            }
            let geometry = geometry(at, file)?;
            let shapes = vec![(material.unwrap_or_default(), geometry.clone())];
            (Contents::Geometry(geometry), Parts { shapes, lights: vec![] })
        };
        let (transform, parts) = match (transform, of_transform) {
            (Some((transform, map)), Some((_, at))) => (transform, parts.transformed(&map, &at)?),
            _ => (Transform::IDENTITY, parts),
        };
        Ok(Piece { contents, transform, material, parts })
    }

    /// All of the group called `name`, which is named at `at` of the file. A group is read once, and what is wrong in it is
    /// told once.
    fn group(&mut self, name: &str, at: &[Step]) -> Result<Parts, Fault> {
        match self.known_groups.get(name) {
            Some(Some(parts)) => return Ok(parts.clone()),
            Some(None) => {
                let message = format!("group {} contains itself: leave it out here", names::quoted(name));
                return Err(Fault::value(at.to_vec(), message));
            }
            None => {}
        }
        let groups = self.groups;
        let Some((_, group)) = groups.0.iter().find(|(known, _)| known == name) else {
            let known: Vec<&str> = groups.0.iter().map(|(name, _)| name.as_str()).collect();
            let hint = if known.is_empty() {
                format!("the scene has no groups, so add [[groups.{}]]", names::key(name))
            } else {
                names::hint(name, &known)
            };
            let message = format!("unknown group {} {}: {hint}", names::quoted(name), place(&at[..at.len() - 1]));
            return Err(Fault::value(at.to_vec(), message));
        };
        self.known_groups.insert(name.to_string(), None);
        let mut all = Parts::default();
        for (index, file) in group.0.iter().enumerate() {
            let piece = self.piece(&["groups".into(), name.into(), index.into()], file);
            let Some(Piece { parts, .. }) = self.files.review.accept(piece) else { continue };
            all.shapes.extend(parts.shapes);
            all.lights.extend(parts.lights);
            if all.shapes.len() > MOST_SHAPES {
                self.known_groups.insert(name.to_string(), Some(Parts::default()));
                let message = format!("group {} has more than {MOST_SHAPES} shapes", names::quoted(name));
                return Err(Fault::value(steps!["groups", name], message));
            }
        }
        self.known_groups.insert(name.to_string(), Some(all.clone()));
        Ok(all)
    }

    /// Index of the material of that name, and of the first where there is no such name.
    fn material(&self, at: &[Step], name: &str) -> usize {
        if let Some(material) = self.indices.get(name) {
            return *material;
        }
        // Where a whole section is unknown or wrong, the materials may be in it.
        if !self.files.review.has(|place| place.len() == 1) {
            self.files.review.object(unknown_material(at, name, self.materials));
        }
        0
    }
}

/// Makes all of a shape of one material.
fn paint((material, geometry): &mut (usize, Geometry), new: usize) {
    *material = new;
    if let Geometry::Mesh { first_material, .. } = geometry {
        *first_material = None;
    }
}

fn unknown_material(at: &[Step], name: &str, materials: &Materials) -> Fault {
    let known: Vec<&str> = materials.0.iter().map(|(name, _)| name.as_str()).collect();
    let hint = if known.is_empty() {
        format!("the scene has no materials, so add [materials.{}]", names::key(name))
    } else {
        names::hint(name, &known)
    };
    let message = format!("unknown material {} {}: {hint}", names::quoted(name), place(at));
    Fault::value(below(at, "material"), message)
}

fn refuse_two(at: &[Step], file: &ShapeFile) -> Result<(), Fault> {
    let mut given = file.geometries().filter(|(_, is_given)| *is_given).map(|(key, _)| key);
    let (Some(first), Some(second)) = (given.next(), given.next()) else {
        return Ok(());
    };
    let list = match at {
        [Step::Key(groups), Step::Key(name), ..] if groups == "groups" => format!("groups.{}", names::key(name)),
        _ => "shapes".to_string(),
    };
    let message = format!("{} has both `{first}` and `{second}`: write a `[[{list}]]` for each", subject(at));
    Err(Fault::key(below(at, second), message))
}

fn geometry(at: &[Step], file: &ShapeFile) -> Result<Geometry, Fault> {
    let key = |key: &str| below(at, key);
    if let Some(sphere) = &file.sphere {
        Ok(self::sphere(sphere))
    } else if let Some(plane) = &file.plane {
        self::plane(plane, key("plane"))
    } else if let Some(rectangle) = &file.rectangle {
        self::rectangle(rectangle, key("rectangle"))
    } else if let Some(disk) = &file.disk {
        self::disk(disk, key("disk"))
    } else if let Some(cylinder) = &file.cylinder {
        self::cylinder(cylinder, key("cylinder"))
    } else if let Some(cone) = &file.cone {
        self::cone(cone, key("cone"))
    } else if let Some(cuboid) = &file.cuboid {
        Ok(self::cuboid(cuboid))
    } else {
        let keys: Vec<_> = file.geometries().map(|(key, _)| format!("`{key}`")).collect();
        let message = format!("{} has no geometry: give it one of {}", subject(at), keys.join(", "));
        Err(Fault::value(at.to_vec(), message))
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

fn disk(file: &DiskFile, at: Vec<Step>) -> Result<Geometry, Fault> {
    let normal = not_zero(dvec3(file.normal), &at, "normal")?;
    Ok(Geometry::Disk { center: vec3(file.center), normal: normal.normalize().as_vec3(), radius: file.radius.0 as f32 })
}

fn cylinder(file: &CylinderFile, at: Vec<Step>) -> Result<Geometry, Fault> {
    has_height(file.base, file.top, &at)?;
    let CylinderFile { base, top, radius, capped } = file;
    Ok(Geometry::Cylinder { base: vec3(*base), top: vec3(*top), radius: radius.0 as f32, capped: *capped })
}

fn cone(file: &ConeFile, at: Vec<Step>) -> Result<Geometry, Fault> {
    has_height(file.base, file.top, &at)?;
    let (radius, top_radius) = (file.radius.0, file.top_radius.0);
    if top_radius > radius {
        let message = format!(
            "`top_radius` {} is {top_radius}, and must not be more than `radius`, which is {radius}: `base` is the wide end",
            place(&at)
        );
        return Err(Fault::value(below(&at, "top_radius"), message));
    }
    let (base, top) = (vec3(file.base), vec3(file.top));
    let (radius, top_radius) = (radius as f32, top_radius as f32);
    Ok(Geometry::Cone { base, top, radius, top_radius, capped: file.capped })
}

/// Checks that there is a way from `base` to `top`, also in 32 bits.
fn has_height(base: Point, top: Point, at: &[Step]) -> Result<(), Fault> {
    if (vec3(top).as_dvec3() - vec3(base).as_dvec3()).length() >= SMALLEST {
        return Ok(());
    }
    let message = format!("`top` {} is the same point as `base`: without a height it is a `disk`", place(at));
    Err(Fault::value(below(at, "top"), message))
}

fn cuboid(file: &BoxFile) -> Geometry {
    Geometry::Box { center: vec3(file.center), size: vec3(file.size), rotation_degrees: vec3(file.rotation_degrees) }
}

pub(super) fn below(at: &[Step], key: &str) -> Vec<Step> {
    [at, &[Step::from(key)]].concat()
}

/// The vector itself, unless 32-bit arithmetic could not tell it from zero.
pub(super) fn not_zero(vector: DVec3, at: &[Step], key: &str) -> Result<DVec3, Fault> {
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
