//! Calls the kernels that were compiled for the CPU.

#![allow(unsafe_code)] // The call itself; all that it relies on is checked here.

mod counts;
mod wide;
#[cfg(target_arch = "x86_64")]
mod x86;

use std::sync::Arc;

pub use counts::{Counts, StageCounts};
use wide::{TraversalWords, WideScene};

use crate::{
    BLOCK, BrokenScene, Comparison, EntryPoint, FILM_WORD, FilmPixel, INPUT_WORD, OUTPUT_WORD, PixelFilter, Probe,
    RESTING_WORD, SCENE_WORD, SCENE_WORDS, SceneBuffers, WORK_WORD, Work,
};

/// Levels of instruction set that kernels are compiled for; all give the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InstructionSet {
    /// x86-64-v4: AVX-512.
    X86V4,
    /// x86-64-v3: AVX2.
    X86V3,
    /// x86-64-v2: SSE4.2.
    X86V2,
    /// Instructions that every processor of the architecture has.
    Baseline,
    /// Least of the architecture's levels with bounds checks, for tests: a read outside a buffer ends the program.
    /// Builds contain it where `RAGGIO_KERNEL_LEVELS` asks for it.
    Checked,
}

impl InstructionSet {
    /// Most capable level that this build contains and this processor has; `None` on processors too old for any. Bounds
    /// checks are never the best.
    pub fn best() -> Option<Self> {
        Self::available().into_iter().find(|set| *set != Self::Checked)
    }

    /// All levels that this build contains and this processor has, the most capable first.
    pub fn available() -> Vec<Self> {
        BUILT.iter().copied().filter(|set| set.supported()).collect()
    }

    /// Number of paths that the path tracer follows at once.
    pub fn lanes(self) -> u32 {
        lanes(self)
    }

    /// Whether rays can walk through nodes of eight children: `cpp/traversal.h` takes AVX2.
    fn walks_wide(self) -> bool {
        matches!(self, Self::X86V4 | Self::X86V3)
    }

    /// Usual name of the level.
    pub fn name(self) -> &'static str {
        match self {
            Self::X86V4 => "x86-64-v4",
            Self::X86V3 => "x86-64-v3",
            Self::X86V2 => "x86-64-v2",
            Self::Baseline => std::env::consts::ARCH,
            Self::Checked => "checked",
        }
    }

    #[cfg(target_arch = "x86_64")]
    fn supported(self) -> bool {
        match self {
            Self::X86V4 => x86::level() >= 4,
            Self::X86V3 => x86::level() >= 3,
            Self::X86V2 | Self::Checked => x86::level() >= 2,
            Self::Baseline => true,
        }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn supported(self) -> bool {
        matches!(self, Self::Baseline | Self::Checked)
    }
}

type Kernel = unsafe extern "C" fn(*const [u32; 3], *const u64);
type WalkFunction = unsafe extern "C" fn(*const u64, *const TracedRay, *mut TracedHit, u32);

/// A ray as hand-written code passes it: `TracedRay` of `cpp/rays.h`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracedRay {
    /// Where it sets out.
    pub origin: [f32; 3],
    /// Unit vector along it.
    pub direction: [f32; 3],
    /// Decision about surfaces that let part of the light pass: `kernels/coverage.slang`.
    pub key: u32,
    /// Whether any surface will do.
    pub any: bool,
}

/// Surface that a ray has found: `TracedHit` of `cpp/rays.h`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracedHit {
    /// Distance along the ray; before, that within which it looks.
    pub distance: f32,
    /// Place of the shape in the scene's order, or [`NOTHING`](Self::NOTHING)'s.
    pub shape: u32,
    /// Place of the triangle in the scene's list.
    pub triangle: u32,
    /// Weights of the triangle's second and third corner.
    pub barycentrics: [f32; 2],
}

impl TracedHit {
    /// Nothing so far, however far the ray goes.
    pub const NOTHING: Self =
        Self { distance: f32::INFINITY, shape: u32::MAX, triangle: u32::MAX, barycentrics: [0.0; 2] };
}

/// Follows `rays` through the bounded shapes of `scene`, as the path tracer does, and puts what they find into `hits`: for
/// those who measure this alone. Nobody is asked here who takes samples.
///
/// # Panics
/// A panic if there are not as many hits as rays, this build or this processor lacks the level `set`, or the scene was made
/// for others.
pub fn follow(set: InstructionSet, scene: &CpuScene, rays: &[TracedRay], hits: &mut [TracedHit]) {
    assert_eq!(rays.len(), hits.len());
    if scene.buffers.nodes.is_empty() {
        return;
    }
    scene.check_level(set);
    let walk = walk_function(set).filter(|_| InstructionSet::available().contains(&set));
    let walk = walk.unwrap_or_else(|| panic!("there is no {} code for this processor here", set.name()));
    let (work, block) = (Work::default(), scene.block());
    let traversal = scene.traversal();
    let globals = globals(&block, &work, traversal.as_ref());
    for (rays, hits) in rays.chunks(MOST_FOLLOWED).zip(hits.chunks_mut(MOST_FOLLOWED)) {
        // SAFETY: rays and hits are as many as are told, and laid out as in `cpp/rays.h`; all else as in `dispatch`.
        unsafe { walk(globals.as_ptr(), rays.as_ptr(), hits.as_mut_ptr(), rays.len() as u32) };
    }
}

/// Parameters of the kernels: addresses of the scene's block, the work and, behind them, what hand-written code walks through,
/// and a null for what it counts. They are good as long as these are.
fn globals(block: &[u64], work: &Work, traversal: Option<&TraversalWords>) -> [u64; COUNTS_WORD + 1] {
    let mut globals = [0; COUNTS_WORD + 1];
    globals[TRAVERSAL_WORD] = traversal.map_or(0, |words| words.as_ptr() as u64);
    globals[SCENE_WORD] = block.as_ptr() as u64;
    globals[WORK_WORD] = std::ptr::from_ref(work) as u64;
    globals
}

/// Most rays that one call follows.
const MOST_FOLLOWED: usize = 1 << 20;

include!(concat!(env!("OUT_DIR"), "/cpu_table.rs"));

/// Way through the hierarchies. All find the same hits, bit for bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Walk {
    /// Through nodes of eight children, where processor and scene have them: `cpp/traversal.h`. In large scenes rays that
    /// come together take turns, so that they wait for memory together.
    #[default]
    Wide,
    /// Through nodes of eight children, in turn whatever the size of the scene.
    InTurn,
    /// Through binary nodes, as on other devices: `kernels/walk.slang`.
    Portable,
}

/// Most shapes that rays try one by one, many rays at once.
const FEW_SHAPES: usize = 32;

/// Scene whose indices have been checked, ready for [`dispatch`].
#[derive(Debug)]
pub struct CpuScene {
    buffers: SceneBuffers,
    walk: Walk,
    /// Whether rays may walk through nodes of eight children.
    walks_wide: bool,
    wide: Option<WideScene>,
    /// Whether the meshes' binary nodes were given up.
    is_settled: bool,
}

impl CpuScene {
    /// Checks the scene in `buffers`, through which rays are to go as `walk` says, in kernels of the level `set`; fails if an
    /// index in them points nowhere. Works on all threads of the pool that it is called in.
    pub fn new(buffers: SceneBuffers, set: InstructionSet, walk: Walk) -> Result<Self, BrokenScene> {
        buffers.check()?;
        let walks_wide = set.walks_wide() && walk != Walk::Portable;
        let mut scene = Self { buffers, walk, walks_wide, wide: None, is_settled: false };
        scene.widen();
        Ok(scene)
    }

    /// Chooses which shapes rays try one by one, and makes what the wide walk reads.
    fn widen(&mut self) {
        let tries_all = self.walk != Walk::Portable && self.buffers.try_all(FEW_SHAPES);
        // Rays that try all shapes walk through no hierarchy.
        let is_built = self.walks_wide && !tries_all;
        self.wide = if is_built { WideScene::new(&self.buffers, self.wide.as_ref()) } else { None };
    }

    /// Gives up what only [`renew`](Self::renew) could need again, which should not follow: binary nodes of meshes that no
    /// ray walks through.
    pub fn settle(&mut self) {
        if self.wide.is_some() {
            self.buffers.mesh_nodes = Arc::default();
            self.is_settled = true;
        }
    }

    /// Number of shapes that rays try one by one.
    pub fn tried(&self) -> u32 {
        self.buffers.constants().counts.tried
    }

    /// Bytes of all that kernels read of the scene.
    pub fn bytes(&self) -> usize {
        let lists: usize = self.buffers.bytes().iter().map(|list| list.bytes.len()).sum();
        lists + self.wide.as_ref().map_or(0, WideScene::bytes)
    }

    /// # Panics
    /// If kernels of the level `set` would read binary nodes that were given up.
    fn check_level(&self, set: InstructionSet) {
        assert!(set.walks_wide() || !self.is_settled, "the scene was made for other levels than {}", set.name());
    }

    /// Takes another scene in place of this one; what both share is not checked again. Fails if an index in it points
    /// nowhere, and keeps this scene then.
    pub fn renew(&mut self, buffers: SceneBuffers) -> Result<(), BrokenScene> {
        buffers.check_after(&self.buffers)?;
        self.buffers = buffers;
        self.is_settled = false;
        self.widen();
        Ok(())
    }

    /// Buffers that the scene was made from.
    pub fn buffers(&self) -> &SceneBuffers {
        &self.buffers
    }

    /// `Traversal` of `cpp/traversal.h`, if rays walk through wide nodes.
    fn traversal(&self) -> Option<TraversalWords> {
        Some(self.wide.as_ref()?.words(&self.buffers, self.walk == Walk::InTurn))
    }

    /// Parameter block of the kernels: the address and length of each buffer, where the reflection puts them.
    fn block(&self) -> Vec<u64> {
        let bytes = self.buffers.bytes();
        let mut block = empty_block();
        for (buffer, word) in bytes.iter().zip(SCENE_WORDS) {
            block[word] = buffer.bytes.as_ptr() as u64;
            block[word + 1] = buffer.count as u64;
        }
        block
    }
}

/// Parameter block of a scene without any buffers.
fn empty_block() -> Vec<u64> {
    vec![0; SCENE_WORDS.iter().max().map_or(0, |last| last + 2)]
}

/// Memory that a kernel reads and writes besides the scene; leave empty what it does not touch.
#[derive(Default)]
pub struct Buffers<'a> {
    /// Film of the rows of the work: `width` times `rows` pixels.
    pub film: &'a mut [FilmPixel],
    /// Displayable pixels, or answers.
    pub output: &'a mut [u32],
    /// Questions, or the reference image.
    pub input: &'a [[f32; 4]],
    /// A bit for each block of the image; see `kernels/buffers.slang`.
    pub resting: &'a [u32],
    /// Counts of the path tracer so far, if it is to count: that takes a little time.
    pub counts: Option<&'a mut Counts>,
}

/// Number of words that hold a bit for each block of the work's image.
fn resting_words(work: &Work) -> usize {
    let blocks = work.width.div_ceil(BLOCK) as usize * work.height.div_ceil(BLOCK) as usize;
    blocks.div_ceil(32)
}

/// Runs one kernel over `work` on the calling thread. The kernels of display and means and [`Probe::ToneMap`] need no scene.
///
/// # Panics
/// If the buffers are smaller than the work, `set` is not one of [`InstructionSet::available`], or the scene was made for
/// others.
pub fn dispatch(set: InstructionSet, entry: EntryPoint, scene: Option<&CpuScene>, work: &Work, buffers: Buffers<'_>) {
    assert!(set.supported(), "this processor lacks {}", set.name());
    if let Some(scene) = scene {
        scene.check_level(set);
    }
    let simple = scene.is_some_and(|scene| scene.buffers.is_simple());
    let media = scene.is_some_and(|scene| scene.buffers.has_media());
    let kernel = entry_point(set, entry, simple, media).expect("this build has kernels for every level it lists");
    let first = work.first_row.checked_sub(work.band_row).expect("the work begins inside its band");
    let pixels = work.width as usize * (first as usize + work.rows as usize);
    let large_enough = match entry {
        EntryPoint::Display => {
            let image = work.width as usize * (work.first_row as usize + work.rows as usize);
            let referred = work.comparison == Comparison::Off as u32 || buffers.input.len() >= image;
            buffers.film.len() >= pixels && buffers.output.len() >= image && referred
        }
        EntryPoint::Means => {
            let image = work.width as usize * (work.first_row as usize + work.rows as usize);
            buffers.film.len() >= pixels && buffers.output.len() >= 4 * image
        }
        EntryPoint::Probe => {
            let count = work.count as usize;
            buffers.input.len() >= 3 * count && buffers.output.len() >= 12 * count
        }
        // All others add samples to the film.
        _ => buffers.film.len() >= pixels && (work.adaptive == 0 || buffers.resting.len() >= resting_words(work)),
    };
    assert!(large_enough, "the buffers are smaller than the work");

    let maps_tones = entry == EntryPoint::Probe && work.probe == Probe::ToneMap as u32;
    let does_without = maps_tones || matches!(entry, EntryPoint::Display | EntryPoint::Means);
    assert!(
        scene.is_some() || does_without,
        "only the kernels of display and means and the tone mapper's probe do without a scene"
    );
    let drawn =
        |scene: &CpuScene| work.filter != PixelFilter::Tabulated as u32 || !scene.buffers.filter_table.is_empty();
    assert!(scene.is_none_or(drawn), "the scene has no table of the work's filter");
    let block = scene.map_or_else(empty_block, CpuScene::block);
    let traversal = scene.and_then(CpuScene::traversal);
    let mut globals = globals(&block, work, traversal.as_ref());
    for (word, address, count) in [
        (FILM_WORD, buffers.film.as_mut_ptr() as u64, buffers.film.len()),
        (OUTPUT_WORD, buffers.output.as_mut_ptr() as u64, buffers.output.len()),
        (INPUT_WORD, buffers.input.as_ptr() as u64, buffers.input.len()),
        (RESTING_WORD, buffers.resting.as_ptr() as u64, buffers.resting.len()),
    ] {
        globals[word] = address;
        globals[word + 1] = count as u64;
    }
    globals[COUNTS_WORD] = buffers.counts.map_or(0, |counts| std::ptr::from_mut(counts) as u64);

    let groups = entry.groups(work);
    // SAFETY: `globals` and `block` have the layout that slangc's reflection gives; every address in them is of a live
    // slice or of counts, exclusively borrowed where the kernel writes; the work stays inside the slices (asserted above)
    // and every index in the scene stays inside its buffer (checked by `CpuScene::new`), but for binary nodes that were
    // given up, which no kernel of this level reads (asserted too).
    unsafe { kernel(&groups, globals.as_ptr()) };
}
