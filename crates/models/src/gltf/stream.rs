//! Vertices that primitives name: accessors or compressed geometry, whole or only those that are used.

use super::asset::Asset;
use super::document::{Attributes, Draco, Primitive};
use super::draco::Geometry;
use super::fault::at;
use crate::error::Fault;

/// Vertices that the primitives of a mesh share because they name the same accessors.
pub(super) struct Stream<'a> {
    /// Path of the first of these primitives.
    pub path: String,
    pub attributes: &'a Attributes,
    pub targets: &'a [Attributes],
    draco: Option<(&'a Draco, Geometry)>,
    /// Vertices that triangles use, ascending, where they are but a part of all.
    pub used: Option<Vec<u32>>,
    /// Index in the mesh of the first of these vertices.
    pub first: usize,
}

impl<'a> Stream<'a> {
    pub(super) fn new(asset: &Asset<'_>, primitive: &'a Primitive, path: String) -> Result<Self, Fault> {
        let draco = primitive.extensions.draco.as_ref();
        let draco = draco.map(|draco| Ok((draco, Geometry::decode(asset, draco, &path)?))).transpose()?;
        let (attributes, targets) = (&primitive.attributes, &primitive.targets[..]);
        let stream = Self { path, attributes, targets, draco, used: None, first: 0 };
        stream.check_counts(asset)?;
        Ok(stream)
    }

    /// Key that primitives which share their vertices have in common; compressed ones share with none.
    pub(super) fn key(primitive: &Primitive) -> Option<(&Attributes, &[Attributes])> {
        primitive.extensions.draco.is_none().then_some((&primitive.attributes, &primitive.targets))
    }

    /// Checks that attributes have an element for each vertex; compressed geometry has its own number of vertices.
    fn check_counts(&self, asset: &Asset<'_>) -> Result<(), Fault> {
        let vertices = self.source_vertices(asset);
        let attributes = self.attributes.iter().filter(|(name, _)| self.compressed(name).is_none());
        let mut all = attributes.chain(self.targets.iter().flatten()).map(|(_, accessor)| *accessor);
        let Some(stray) = all.find(|accessor| asset.accessor(*accessor).count != vertices) else { return Ok(()) };
        let count = asset.accessor(stray).count;
        Err(at(&self.path, format!("accessor {stray} has {count} elements: there are {vertices} vertices")))
    }

    /// Number of vertices before unused ones are left out.
    pub(super) fn source_vertices(&self, asset: &Asset<'_>) -> usize {
        match (&self.draco, self.attributes.get("POSITION")) {
            (Some((_, geometry)), _) => geometry.vertices(),
            (None, Some(positions)) => asset.accessor(*positions).count,
            (None, None) => 0,
        }
    }

    /// Number of vertices that come into the mesh.
    pub(super) fn vertices(&self, asset: &Asset<'_>) -> usize {
        self.used.as_ref().map_or_else(|| self.source_vertices(asset), Vec::len)
    }

    /// The triangles that are part of compressed geometry.
    pub(super) fn compressed_triangles(&self) -> Option<Vec<[u32; 3]>> {
        self.draco.as_ref().map(|(_, geometry)| geometry.triangles())
    }

    /// Leaves out the vertices that `triangles` do not use if they are more than half of them.
    pub(super) fn keep_used(&mut self, asset: &Asset<'_>, triangles: &[&[[u32; 3]]]) {
        let corners: usize = triangles.iter().map(|list| 3 * list.len()).sum();
        if self.draco.is_some() || corners > self.source_vertices(asset) / 2 {
            return;
        }
        let mut used: Vec<u32> = triangles.iter().flat_map(|list| list.as_flattened()).copied().collect();
        used.sort_unstable();
        used.dedup();
        self.used = Some(used);
    }

    /// The number in the mesh of a vertex that is in use.
    pub(super) fn renumbered(&self, vertex: u32) -> usize {
        self.first + self.used.as_ref().map_or(vertex as usize, |used| used.partition_point(|other| *other < vertex))
    }

    /// Number of components that a vertex has in the attribute.
    pub(super) fn width(&self, asset: &Asset<'_>, name: &str) -> usize {
        match self.compressed(name) {
            Some((geometry, id)) => geometry.width(id),
            None => self.attributes.get(name).map_or(0, |accessor| asset.accessor(*accessor).kind.width()),
        }
    }

    fn compressed(&self, name: &str) -> Option<(&Geometry, u32)> {
        let (draco, geometry) = self.draco.as_ref()?;
        Some((geometry, *draco.attributes.get(name)?))
    }

    /// An attribute of all vertices in use. Integers are scaled as the accessor says, but colours always.
    pub(super) fn floats<const N: usize>(&self, asset: &Asset<'_>, name: &str) -> Result<Option<Vec<[f32; N]>>, Fault> {
        let Some(number) = self.attributes.get(name) else { return Ok(None) };
        let path = format!("{}.attributes.{name}", self.path);
        let normalized = asset.accessor(*number).normalized || name.starts_with("COLOR_");
        let Some((geometry, id)) = self.compressed(name) else {
            return asset.floats(*number, self.used.as_deref(), normalized, &path).map(Some);
        };
        asset.budget.take(geometry.vertices(), size_of::<[f32; N]>(), &path)?;
        let mut values = geometry.floats::<N>(id);
        let largest = asset.accessor(*number).component_type.largest();
        if normalized && largest != 1.0 {
            values.as_flattened_mut().iter_mut().for_each(|value| *value = (*value / largest).max(-1.0));
        }
        Ok(Some(values))
    }

    /// An attribute of unsigned integers of all vertices in use.
    pub(super) fn integers(&self, asset: &Asset<'_>, name: &str) -> Result<Option<Vec<[u32; 4]>>, Fault> {
        if self.compressed(name).is_some() {
            let values = self.floats::<4>(asset, name)?;
            return Ok(values.map(|values| values.iter().map(|value| value.map(|x| x as u32)).collect()));
        }
        let Some(number) = self.attributes.get(name) else { return Ok(None) };
        let path = format!("{}.attributes.{name}", self.path);
        asset.integers(*number, self.used.as_deref(), &path).map(Some)
    }
}
