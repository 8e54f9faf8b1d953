//! Counts that kernels keep of their own work, for those who measure it without a clock.

use std::ops::AddAssign;

/// Calls of a stage of the path tracer: `StageCounts` of `cpp/rays.h`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageCounts {
    /// Calls, each for as many paths as the level of instruction set has [lanes](super::InstructionSet::lanes).
    pub calls: u64,
    /// Paths in all calls together.
    pub paths: u64,
}

impl StageCounts {
    /// Part of the lanes that had a path, 0 to 1; 0 where nothing was called, more than 1 where one call was for several
    /// vectors.
    pub fn occupancy(&self, lanes: u32) -> f64 {
        self.paths as f64 / (self.calls * u64::from(lanes)).max(1) as f64
    }
}

/// Work that the path tracer has done: `Counts` of `cpp/rays.h`. It depends on scene and work alone, but for the stages, which
/// depend on the number of lanes too.
///
/// Single paths have no stages, and rays in binary nodes and those that try all shapes meet no nodes of eight children.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Nodes of eight children that rays were tested against.
    pub nodes: u64,
    /// Blocks of up to four triangles that rays were tested against.
    pub triangle_blocks: u64,
    /// Blocks of up to four spheres, rectangles or boxes that rays were tested against.
    pub shape_blocks: u64,
    /// Paths that set out.
    pub renew: StageCounts,
    /// Paths whose rays are traced.
    pub find: StageCounts,
    /// Paths with a shadow ray, in calls of `find` with any.
    pub shadow: StageCounts,
    /// Paths that have met a surface.
    pub shade: StageCounts,
    /// Rays that walk through a hierarchy, those that take turns in one call.
    pub walk: StageCounts,
}

impl AddAssign for StageCounts {
    fn add_assign(&mut self, other: Self) {
        self.calls += other.calls;
        self.paths += other.paths;
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.nodes += other.nodes;
        self.triangle_blocks += other.triangle_blocks;
        self.shape_blocks += other.shape_blocks;
        self.renew += other.renew;
        self.find += other.find;
        self.shadow += other.shadow;
        self.shade += other.shade;
        self.walk += other.walk;
    }
}
