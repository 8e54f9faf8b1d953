//! Normals of smoothing groups.
//!
//! The faces of a group that meet in a vertex share one normal there, the mean of theirs, each counted by the angle of its
//! corner. So Blender has it, which writes these groups, and unlike weights by area the mean does not depend on how a
//! polygon is cut into triangles. Where groups meet there is a crease, and so there is around the faces of no group.

use std::collections::hash_map::Entry;

use foldhash::HashMap;
use glam::DVec3;

/// The smoothing group at hand, and the normals of all groups so far.
#[derive(Default)]
pub(super) struct Smoothing {
    /// Number of the group; 0 for flat faces.
    group: i64,
    numbers: HashMap<(u32, i64), u32>,
    sums: Vec<DVec3>,
}

impl Smoothing {
    /// Begins the faces of a group; 0 stands for flat ones.
    pub(super) fn begin(&mut self, group: i64) {
        self.group = group;
    }

    /// The normal that corners at a position have in the group at hand.
    pub(super) fn of(&mut self, position: u32) -> super::Normal {
        if self.group == 0 {
            return super::Normal::Flat;
        }
        match self.numbers.entry((position, self.group)) {
            Entry::Occupied(entry) => super::Normal::Smooth(*entry.get()),
            Entry::Vacant(entry) => {
                // There are at most as many as corners, whose number the reader of faces checks.
                let number = self.sums.len() as u32;
                self.sums.push(DVec3::ZERO);
                super::Normal::Smooth(*entry.insert(number))
            }
        }
    }

    /// Adds a face of `count` corners to the normals that `smooth` gives for them.
    pub(super) fn add(
        &mut self,
        count: usize,
        position: impl Fn(usize) -> [f32; 3],
        smooth: impl Fn(usize) -> Option<u32>,
    ) {
        if self.group == 0 || count < 3 {
            return;
        }
        let at = |i: usize| DVec3::from(position(i % count).map(f64::from));
        let from_first = |i: usize| at(i) - at(0);
        // Newell's normal, relative to the first corner to keep the digits of faces far from the origin.
        let normal = (0..count).map(|i| from_first(i).cross(from_first(i + 1))).sum::<DVec3>().normalize_or_zero();
        // Faces with a corner that is not finite are left out of the mesh, and so they are here.
        if !normal.is_finite() || normal == DVec3::ZERO {
            return;
        }
        for i in 0..count {
            let Some(number) = smooth(i) else { continue };
            let (back, onward) = (at(i + count - 1) - at(i), at(i + 1) - at(i));
            let angle = back.cross(onward).length().atan2(back.dot(onward));
            self.sums[number as usize] += normal * angle;
        }
    }

    /// The unit normals; zero, which is flat, where the faces of a vertex cancel each other out.
    pub(super) fn into_normals(self) -> Vec<[f32; 3]> {
        self.sums.into_iter().map(|sum| sum.normalize_or_zero().as_vec3().to_array()).collect()
    }
}
