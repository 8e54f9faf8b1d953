//! A Vulkan device.

#[cfg(target_os = "linux")]
mod noiseless;

use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;

#[cfg(target_os = "linux")]
use raggio_denoise::{Care, Denoiser};
use raggio_kernels::{
    BufferBytes, EntryPoint, FILM_BINDING, Feature, FilmPixel, INPUT_BINDING, OUTPUT_BINDING, Probe, RESTING_BINDING,
    SCENE_BINDINGS, SCENE_SET, SPIRV, SceneBuffers, Specialization, Spirv, Variant, Work,
};
use raggio_scene::Integrator;
use raggio_vulkan::{
    BindingSet, Buffer, Device as VulkanContext, DeviceKind, Lists, Location, Module, PhysicalDevice, Pipeline,
    SetLayout, VulkanError,
};
#[cfg(target_os = "linux")]
use raggio_vulkan::{CudaMemory, ExportedBuffer};

use crate::devices::adaptive::Blocks;
use crate::devices::device::{Answer, Device, DeviceError, Question, Session, sampling};
use crate::devices::films::Films;
use crate::devices::pipelines::{Ahead, Place, Store};
use crate::devices::structures::Structures;
use crate::devices::tracer::Tracer;
#[cfg(target_os = "linux")]
use crate::pictures::display::Denoised;
use crate::pictures::display::{Display, Pixels, reference_pixels};
use crate::pictures::film::Film;
use crate::pictures::linear_image::Image;
use crate::pictures::runs::copy;
use crate::translation::device_scene::{Boxed, DeviceScene};

#[cfg(target_os = "linux")]
const _: () = {
    assert!(size_of::<FilmPixel>() as u64 == raggio_vulkan::SUM_BYTES);
    assert!(std::mem::offset_of!(FilmPixel, samples) as u64 == raggio_vulkan::SAMPLES_OFFSET);
    assert!(std::mem::offset_of!(FilmPixel, red) == 0 && std::mem::offset_of!(FilmPixel, green) == 12);
    assert!(std::mem::offset_of!(FilmPixel, blue) == 24);
};

// `raggio devices` calls a device fit by this number.
const _: () = assert!(SCENE_BINDINGS.len() + 4 <= raggio_vulkan::STORAGE_BUFFERS as usize);

/// Descriptor set of what kernels write; the other set is the scene's.
const BUFFER_SET: u32 = 0;
/// Most bytes of film in one buffer: drivers allow at least 128 MiB, and a gigabyte in one piece may not be free.
const BAND_BYTES: u64 = 64 << 20;

/// A GPU, or a software Vulkan driver.
pub struct VulkanDevice {
    hardware: Arc<Hardware>,
}

/// A device, which is opened again where it was lost.
struct Hardware {
    kernels: Mutex<Arc<Kernels>>,
    /// Folder in which compiled kernels are kept.
    cache: Option<PathBuf>,
    ahead: Ahead,
}

/// Device and kernels, which all sessions share.
struct Kernels {
    context: Arc<VulkanContext>,
    spirv: Spirv,
    tracer: Tracer,
    /// Kernels of each variant, in the order of `Variant::ALL`.
    compiled: [Compiled; Variant::ALL.len()],
    store: Store,
    /// Whether kernels know all that scenes can have, instead of what a scene has.
    general: bool,
}

/// The kernels of a variant, each compiled when it is first needed.
#[derive(Default)]
struct Compiled {
    module: OnceLock<Arc<Module>>,
    /// Pipelines by entry point and by what they are specialised for.
    pipelines: Mutex<HashMap<(EntryPoint, Specialization), Arc<Place>>>,
}

impl VulkanDevice {
    /// Opens `physical`. Compiled kernels are kept in `cache`, a folder that need not be there yet; software has general ones
    /// for simple scenes if `general_in_software`.
    ///
    /// # Errors
    /// A [`DeviceError::Vulkan`] when the device cannot run the kernels, or a call of Vulkan fails; a
    /// [`DeviceError::NotFound`] when it lacks the hardware that `tracer` asks for.
    pub fn new(
        physical: &PhysicalDevice,
        tracer: Tracer,
        cache: Option<&Path>,
        general_in_software: bool,
    ) -> Result<Self, DeviceError> {
        if let Some(newer) = &physical.outdated {
            return Err(VulkanError::Unfit { name: physical.name.clone(), missing: newer.clone() }.into());
        }
        if tracer == Tracer::Hardware && !physical.has_ray_queries() {
            return Err(DeviceError::NotFound(format!(
                "{} does not trace rays by hardware (VK_KHR_ray_query): `--tracer auto` does without",
                physical.name
            )));
        }
        let open = if tracer.asks(physical) { VulkanContext::with_ray_queries } else { VulkanContext::new };
        let general = general_in_software && physical.kind == DeviceKind::Software;
        let device = Self::with_cache(open(physical)?, &SPIRV, tracer, cache, general)?;
        // A driver that refuses all kernels is refused at once. Others take seconds, and only scenes tell which are needed.
        device.hardware.kernels().pipeline(EntryPoint::Display, Variant::SIMPLE)?;
        Ok(device)
    }

    /// Compiles other kernels of the same layout for an open device; they are not kept. Hardware traces rays where the device was
    /// opened so.
    ///
    /// # Errors
    /// A [`DeviceError::Vulkan`] when the driver refuses the kernels.
    pub fn with_kernels(context: Arc<VulkanContext>, spirv: &Spirv) -> Result<Self, DeviceError> {
        let device = Self::with_cache(context, spirv, Tracer::Auto, None, false)?;
        // Kernels that the driver refuses are refused at once, and nobody waits for them later.
        device.hardware.kernels().pipeline(EntryPoint::Path, Variant::SIMPLE)?;
        Ok(device)
    }

    fn with_cache(
        context: Arc<VulkanContext>,
        spirv: &Spirv,
        tracer: Tracer,
        cache: Option<&Path>,
        general: bool,
    ) -> Result<Self, DeviceError> {
        let kernels = Mutex::new(Kernels::new(context, spirv, tracer, cache, general)?);
        let cache = cache.map(Path::to_path_buf);
        Ok(Self { hardware: Arc::new(Hardware { kernels, cache, ahead: Ahead::default() }) })
    }

    /// The open device, which windows share.
    pub fn context(&self) -> Arc<VulkanContext> {
        self.hardware.kernels().context.clone()
    }
}

impl Hardware {
    fn lock(&self) -> MutexGuard<'_, Arc<Kernels>> {
        self.kernels.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn kernels(&self) -> Arc<Kernels> {
        self.lock().clone()
    }

    /// Kernels on the device that is opened again, unless somebody else has done so since `lost` were in use.
    fn renew(&self, lost: &Arc<Kernels>) -> Result<Arc<Kernels>, DeviceError> {
        let mut kernels = self.lock();
        if Arc::ptr_eq(&kernels, lost) {
            let (tracer, cache) = (lost.tracer, self.cache.as_deref());
            *kernels = Kernels::new(lost.context.reopen()?, &lost.spirv, tracer, cache, lost.general)?;
        }
        Ok(kernels.clone())
    }

    fn load(self: &Arc<Self>, kernels: Arc<Kernels>, scene: &DeviceScene) -> Result<Box<dyn Session>, DeviceError> {
        let resident = kernels.upload(scene, None)?;
        let resting = kernels.resting(&[])?;
        let films = Films::new(kernels.film(&scene.work, &resting)?);
        let (work, integrator) = (scene.work, scene.settings.integrator);
        Ok(Box::new(VulkanSession {
            hardware: self.clone(),
            kernels,
            work,
            integrator,
            resident,
            films,
            resting,
            reference: None,
            output: None,
            accepts_general: false,
            is_edited: false,
            #[cfg(target_os = "linux")]
            noiseless: None,
        }))
    }
}

impl Device for VulkanDevice {
    fn name(&self) -> String {
        let context = self.context();
        let physical = context.physical();
        format!("{} (vulkan:{})", physical.name, physical.index)
    }

    fn validation_messages(&self) -> Vec<String> {
        self.context().physical().instance().validation_messages()
    }

    fn vulkan(&self) -> Option<Arc<VulkanContext>> {
        Some(self.context())
    }

    fn compile_ahead(&self, scene: &DeviceScene, features: &[Feature]) {
        let kernels = self.hardware.kernels();
        let variant = kernels.variant_of(scene);
        let special = kernels.specialization(&as_tried(&scene.buffers));
        let mut wanted: Vec<Kernel> = vec![];
        for feature in features {
            let kernel = Kernel::sampling(scene.settings.integrator, *feature, variant, special);
            if wanted.iter().all(|other| other.entry != kernel.entry) {
                wanted.push(kernel);
            }
        }
        kernels.compile_ahead(&self.hardware.ahead, wanted);
    }

    fn load(&self, scene: &DeviceScene) -> Result<Box<dyn Session>, DeviceError> {
        scene.buffers.check()?;
        let kernels = self.hardware.kernels();
        match self.hardware.load(kernels.clone(), scene) {
            Err(error) if error.is_lost() => self.hardware.load(self.hardware.renew(&kernels)?, scene),
            loaded => loaded,
        }
    }
}

impl Kernels {
    fn new(
        context: Arc<VulkanContext>,
        spirv: &Spirv,
        tracer: Tracer,
        cache: Option<&Path>,
        general: bool,
    ) -> Result<Arc<Self>, DeviceError> {
        let store = Store::new(&context, spirv, cache)?;
        let compiled = Default::default();
        Ok(Arc::new(Self { context, spirv: spirv.clone(), tracer, compiled, store, general }))
    }

    /// The kernels of `variant` and their layout. Layouts of variants that are not wide are one layout to Vulkan.
    fn module(&self, variant: Variant) -> Result<&Arc<Module>, DeviceError> {
        let place = &self.compiled[variant.index()].module;
        if let Some(module) = place.get() {
            return Ok(module);
        }
        let lists = if variant.is_wide() { Lists::Addresses } else { Lists::Buffers(SCENE_BINDINGS.to_vec()) };
        let scene = SetLayout { lists, structure: variant.structure_binding() };
        let mut sets = [scene.clone(), scene];
        let written = Lists::Buffers(vec![FILM_BINDING, OUTPUT_BINDING, INPUT_BINDING, RESTING_BINDING]);
        sets[BUFFER_SET as usize] = SetLayout { lists: written, structure: None };
        let module = Module::new(&self.context, self.spirv.code(variant), &sets, size_of::<Work>() as u32)?;
        Ok(place.get_or_init(|| module))
    }

    fn pipeline(&self, entry: EntryPoint, variant: Variant) -> Result<Arc<Pipeline>, DeviceError> {
        self.get(Kernel { entry, variant, special: Specialization::GENERAL })
    }

    fn get(&self, kernel: Kernel) -> Result<Arc<Pipeline>, DeviceError> {
        self.place(kernel).get(|| self.compile(kernel))
    }

    fn compile(&self, Kernel { entry, variant, special }: Kernel) -> Result<Pipeline, DeviceError> {
        let module = self.module(variant)?;
        Ok(self.store.compile(|cache| module.pipeline(entry.name(), bytemuck::cast_slice(&[special]), cache))?)
    }

    fn place(&self, kernel: Kernel) -> Arc<Place> {
        let pipelines = &self.compiled[kernel.variant.index()].pipelines;
        let mut pipelines = pipelines.lock().unwrap_or_else(PoisonError::into_inner);
        pipelines.entry((kernel.entry, kernel.special)).or_default().clone()
    }

    /// Has threads compile those of `wanted` that nobody has compiled. Their errors are for who needs them.
    fn compile_ahead(self: &Arc<Self>, ahead: &Ahead, wanted: impl IntoIterator<Item = Kernel>) {
        for kernel in wanted.into_iter().filter(|kernel| self.place(*kernel).is_idle()) {
            let kernels = self.clone();
            ahead.spawn(move || kernels.place(kernel).fill(|| kernels.compile(kernel)));
        }
    }

    /// Variant of the kernels that trace a scene of these lists.
    fn variant(&self, lists: &SceneLists) -> Variant {
        let limit = self.context.max_binding_bytes();
        let is_long = |list: &BufferBytes| list.bytes.len() as u64 > limit;
        let wide = self.context.has_addresses() && lists.bytes().iter().any(is_long);
        Variant::new(lists.buffers.is_simple(), wide, lists.queries)
    }

    /// Variant of the kernels that will trace `scene`, as far as can be told before it is uploaded.
    fn variant_of(&self, scene: &DeviceScene) -> Variant {
        let lists = SceneLists::new(scene, self.context.has_ray_queries());
        if lists.queries && self.room(&lists, Some(scene), None).is_ok() {
            return self.variant(&lists);
        }
        self.variant(&SceneLists { queries: self.tracer == Tracer::Hardware, ..lists })
    }

    /// What the kernels that trace `scene` are specialised for.
    fn specialization(&self, scene: &SceneBuffers) -> Specialization {
        if self.general && scene.is_simple() { Specialization::GENERAL } else { Specialization::of(scene) }
    }

    /// `kernel`, or while that is not compiled another that traces all that it does, if there is one.
    fn serving(&self, kernel: Kernel) -> Kernel {
        if self.place(kernel).is_filled() {
            return kernel;
        }
        let pipelines = &self.compiled[kernel.variant.index()].pipelines;
        let pipelines = pipelines.lock().unwrap_or_else(PoisonError::into_inner);
        let covers =
            |(entry, special): &(EntryPoint, Specialization)| *entry == kernel.entry && special.covers(&kernel.special);
        let found = pipelines.iter().find(|(known, place)| covers(known) && place.is_filled());
        found.map_or(kernel, |((_, special), _)| Kernel { special: *special, ..kernel })
    }

    /// Descriptor set of what kernels write, and read besides the scene.
    fn bind(&self, buffers: &[(u32, Arc<Buffer>)]) -> Result<BindingSet, DeviceError> {
        Ok(self.module(Variant::SIMPLE)?.bind(BUFFER_SET, buffers, None)?)
    }

    /// Makes `scene` resident; what it shares with `old` is there already. Where hardware may trace its rays and what that takes
    /// does not fit, software does, unless nobody wants it to.
    fn upload(&self, scene: &DeviceScene, old: Option<&Resident>) -> Result<Resident, DeviceError> {
        let with = |queries| self.upload_lists(SceneLists::new(scene, queries), Some(scene), old);
        if self.context.has_ray_queries() {
            match with(true) {
                Err(error) if self.tracer != Tracer::Hardware && error.does_not_fit() => {}
                made => return made,
            }
        }
        with(false)
    }

    /// Makes `lists` resident, and structures of the scene that they are of where hardware asks for them.
    fn upload_lists(
        &self,
        lists: SceneLists,
        scene: Option<&DeviceScene>,
        old: Option<&Resident>,
    ) -> Result<Resident, DeviceError> {
        self.context.check_room("this scene", self.room(&lists, scene, old)?)?;
        let buffers = SCENE_BINDINGS.iter().zip(lists.bytes()).enumerate().map(|(place, (&binding, list))| {
            let upload = || Buffer::with_bytes(&self.context, list.name, list.bytes).map(Arc::new);
            let kept = old.and_then(|old| old.buffer(place, &list));
            Ok((binding, kept.map_or_else(upload, Ok)?))
        });
        let buffers: Vec<_> = buffers.collect::<Result<_, DeviceError>>()?;
        let old = old.and_then(|old| old.structures.as_ref());
        let structures = match scene.filter(|_| lists.queries) {
            Some(scene) => Some(Structures::build(&self.context, scene, &buffers[lists.triangles()].1, old)?),
            None => None,
        };
        let variant = self.variant(&lists);
        let set = self.module(variant)?.bind(SCENE_SET, &buffers, structures.as_ref().map(Structures::scene))?;
        let special = self.specialization(&lists.buffers);
        Ok(Resident { lists, buffers, structures, variant, special, set })
    }

    /// Most bytes that `lists` and the structures of their scene take, but for what `old` has of them.
    fn room(
        &self,
        lists: &SceneLists,
        scene: Option<&DeviceScene>,
        old: Option<&Resident>,
    ) -> Result<u64, DeviceError> {
        let bytes = lists.bytes();
        let new = bytes.iter().enumerate().filter(|(i, list)| old.is_none_or(|old| old.buffer(*i, list).is_none()));
        let of_lists: u64 = new.map(|(_, list)| list.bytes.len() as u64).sum();
        let of_structures = match scene.filter(|_| lists.queries) {
            Some(scene) => Structures::room(&self.context, scene, old.and_then(|old| old.structures.as_ref()))?,
            None => 0,
        };
        Ok(of_lists + of_structures)
    }

    /// An empty film, in bands.
    fn film(&self, work: &Work, resting: &Arc<Buffer>) -> Result<Vec<Band>, DeviceError> {
        let row_bytes = u64::from(work.width) * size_of::<FilmPixel>() as u64;
        self.context.check_room("the film", row_bytes * u64::from(work.height))?;
        let band_rows = (BAND_BYTES / row_bytes).max(1).min(u64::from(work.height)) as u32;
        let bands = (0..work.height).step_by(band_rows as usize).map(|first| {
            let rows = first..work.height.min(first + band_rows);
            let film = Arc::new(Buffer::zeroed(&self.context, "film", row_bytes * rows.len() as u64)?);
            let set = self.band_set(&film, resting)?;
            Ok(Band { rows, film, set })
        });
        bands.collect()
    }

    fn band_set(&self, film: &Arc<Buffer>, resting: &Arc<Buffer>) -> Result<BindingSet, DeviceError> {
        let buffers = [(FILM_BINDING, film.clone()), (RESTING_BINDING, resting.clone())];
        self.bind(&buffers)
    }

    /// Buffer of the bits of blocks that rest; kernels name it, so there has to be one, be it empty.
    fn resting(&self, words: &[u32]) -> Result<Arc<Buffer>, DeviceError> {
        Ok(Arc::new(Buffer::with_bytes(&self.context, "resting blocks", bytemuck::cast_slice(words))?))
    }

    /// Displays the film in `bands` as `work` says.
    fn display(&self, work: &Work, bands: &[Band], output: &Output) -> Result<(), DeviceError> {
        let pipeline = self.pipeline(EntryPoint::Display, Variant::SIMPLE)?;
        Ok(self.context.run(|passes| {
            for (band, set) in bands.iter().zip(&output.sets) {
                let (first, rows) = (band.rows.start, band.rows.len() as u32);
                let work = Work { band_row: first, first_row: first, rows, ..*work };
                let groups = EntryPoint::Display.groups(&work);
                passes.compute(&pipeline, &[set], bytemuck::bytes_of(&work), groups);
            }
        })?)
    }

    /// Room for displayable pixels, and the sets that display each band into it.
    fn output(&self, work: &Work, bands: &[Band], reference: Option<&Arc<Buffer>>) -> Result<Output, DeviceError> {
        let bytes = u64::from(work.width) * u64::from(work.height) * 4;
        let pixels = Arc::new(Buffer::new(&self.context, "displayed pixels", bytes, Location::Device)?);
        // The kernel names a reference, so something has to be bound even if it is not read.
        let reference = match reference {
            Some(reference) => reference.clone(),
            None => Arc::new(Buffer::new(&self.context, "no reference", 0, Location::Device)?),
        };
        let sets = bands.iter().map(|band| {
            let (film, pixels, reference) = (band.film.clone(), pixels.clone(), reference.clone());
            let bindings = [(FILM_BINDING, film), (OUTPUT_BINDING, pixels), (INPUT_BINDING, reference)];
            self.bind(&bindings)
        });
        let sets = sets.collect::<Result<_, DeviceError>>()?;
        Ok(Output { pixels, sets })
    }
}

/// `scene`, with few shapes tried one by one: threads in step are then all at one shape.
fn as_tried(scene: &SceneBuffers) -> SceneBuffers {
    let mut scene = scene.clone();
    if !scene.constants.is_empty() {
        scene.try_all(FEW_SHAPES);
    }
    scene
}

/// Most shapes that rays try one by one.
const FEW_SHAPES: usize = 16;

/// Kernel of a variant, with what it is specialised for.
#[derive(Clone, Copy)]
struct Kernel {
    entry: EntryPoint,
    variant: Variant,
    special: Specialization,
}

impl Kernel {
    /// Kernel that adds samples to the film of `feature`, of scenes with these properties.
    fn sampling(integrator: Integrator, feature: Feature, variant: Variant, special: Specialization) -> Self {
        Self { entry: sampling(integrator, feature), variant, special }
    }
}

/// Lists of a scene as kernels read them, which may be shared with other scenes.
struct SceneLists {
    buffers: SceneBuffers,
    boxed: Arc<Boxed>,
    /// Whether the kernels ask hardware: they know nothing of hierarchies then, but of boxes.
    queries: bool,
}

impl SceneLists {
    fn new(scene: &DeviceScene, queries: bool) -> Self {
        Self { buffers: as_tried(&scene.buffers), boxed: scene.boxed().clone(), queries }
    }

    /// The lists in the order of [`SCENE_BINDINGS`].
    fn bytes(&self) -> [BufferBytes<'_>; SCENE_BINDINGS.len()] {
        let mut lists = self.buffers.bytes();
        for list in lists.iter_mut().filter(|_| self.queries) {
            match list.name {
                // `boxed` in kernels/scene.slang.
                "nodes" => {
                    list.bytes = bytemuck::cast_slice(&self.boxed.places);
                    list.count = self.boxed.places.len();
                    list.stride = size_of::<u32>();
                }
                "mesh_nodes" => {
                    list.bytes = &[];
                    list.count = 0;
                }
                _ => {}
            }
        }
        lists
    }

    /// Place of the list of triangles.
    fn triangles(&self) -> usize {
        self.buffers.bytes().iter().position(|list| list.name == "triangles").expect("scenes have one")
    }
}

/// A scene on the device.
struct Resident {
    lists: SceneLists,
    /// Buffers of the scene, each with its binding.
    buffers: Vec<(u32, Arc<Buffer>)>,
    /// Structures by which hardware traces its rays, if it does.
    structures: Option<Structures>,
    variant: Variant,
    special: Specialization,
    set: BindingSet,
}

impl Resident {
    /// Buffer of the list at `place`, if that is `list`: both are alive, so the same address is the same list.
    fn buffer(&self, place: usize, list: &BufferBytes<'_>) -> Option<Arc<Buffer>> {
        self.lists.bytes()[place].same(list).then(|| self.buffers[place].1.clone())
    }
}

/// A run of rows of the film, in a buffer of its own.
struct Band {
    rows: Range<u32>,
    film: Arc<Buffer>,
    set: BindingSet,
}

/// The film as it is displayed.
struct Output {
    pixels: Arc<Buffer>,
    /// Descriptor sets, one for each band.
    sets: Vec<BindingSet>,
}

struct VulkanSession {
    hardware: Arc<Hardware>,
    kernels: Arc<Kernels>,
    work: Work,
    integrator: Integrator,
    resident: Resident,
    films: Films<Vec<Band>>,
    resting: Arc<Buffer>,
    reference: Option<Arc<Buffer>>,
    /// Whether kernels that know more than the scene has may serve.
    accepts_general: bool,
    /// Whether the scene has been edited since the session began: it is more than another view.
    is_edited: bool,
    // The output is needed by who displays alone. It is bound to the film that is shown and to the reference.
    output: Option<Output>,
    /// Images that a denoiser shares, once one has been asked, of the size of the film.
    #[cfg(target_os = "linux")]
    noiseless: Option<noiseless::Noiseless>,
}

impl VulkanSession {
    /// Kernel that adds samples to the film that is shown: the scene's own, or what serves until that is there.
    fn sampling(&self) -> Kernel {
        let own = self.own();
        if self.accepts_general { self.kernels.serving(own) } else { own }
    }

    /// Kernel that knows what the scene has, and no more.
    fn own(&self) -> Kernel {
        let Resident { variant, special, .. } = self.resident;
        Kernel::sampling(self.integrator, self.films.feature(), variant, special)
    }

    /// Has kernels compiled after an edit: the scene's own, and general ones for edits to come. In software both would take minutes;
    /// general ones do for all.
    fn compile_for_edits(&self) {
        let own = self.own();
        let general = Kernel { special: Specialization::GENERAL, ..own };
        let in_software = self.kernels.context.physical().kind == DeviceKind::Software;
        let wanted: &[Kernel] = match (in_software, self.kernels.place(self.sampling()).is_filled()) {
            (true, true) => &[],
            (true, false) => &[general],
            (false, _) => &[own, general],
        };
        self.kernels.compile_ahead(&self.hardware.ahead, wanted.iter().copied());
    }
}

impl Session for VulkanSession {
    fn show(&mut self, feature: Feature) -> Result<(), DeviceError> {
        if feature != self.films.feature() {
            self.output = None;
        }
        self.films.show(feature, || self.kernels.film(&self.work, &self.resting))
    }

    fn prepare(&mut self) -> Result<(), DeviceError> {
        let kernel = self.sampling();
        let (kernels, pipeline) = (&self.kernels, self.kernels.get(kernel)?);
        kernels.place(kernel).warm_up(|| {
            let work = Work { rows: 0, samples: 0, ..self.work };
            let sets = [&self.films.shown()[0].set, &self.resident.set];
            let run = || {
                let groups = [1; 3];
                kernels.context.run(|passes| passes.compute(&pipeline, &sets, bytemuck::bytes_of(&work), groups))
            };
            Ok(kernels.store.compile(|_| run())?)
        })
    }

    fn is_prepared(&self) -> bool {
        let place = self.kernels.place(self.sampling());
        place.is_filled() && place.has_run()
    }

    fn prepare_ahead(&mut self) -> Result<(), DeviceError> {
        let kernel = self.sampling();
        if self.kernels.place(kernel).is_filled() {
            return self.prepare();
        }
        if self.accepts_general && self.is_edited {
            self.compile_for_edits();
            return Ok(());
        }
        let display = Kernel { entry: EntryPoint::Display, variant: Variant::SIMPLE, special: Specialization::GENERAL };
        self.kernels.compile_ahead(&self.hardware.ahead, [kernel, display]);
        Ok(())
    }

    fn accept_general(&mut self) {
        self.accepts_general = true;
    }

    fn compile_time(&self) -> Duration {
        self.kernels.store.time()
    }

    fn add_samples_until(
        &mut self,
        rows: Range<u32>,
        samples: Range<u32>,
        _: &(dyn Fn() -> bool + Sync),
    ) -> Result<u32, DeviceError> {
        // Nothing stops a dispatch: it is as short as the renderer makes it.
        let feature = self.films.feature();
        let kernel = self.sampling();
        let pipeline = self.kernels.get(kernel)?;
        for band in self.films.shown() {
            let first = rows.start.max(band.rows.start);
            let end = rows.end.min(band.rows.end);
            if first >= end {
                continue;
            }
            let work = Work {
                band_row: band.rows.start,
                first_row: first,
                rows: end - first,
                first_sample: samples.start,
                samples: samples.len() as u32,
                feature: feature as u32,
                filter: feature.filter(self.work.filter),
                ..self.work
            };
            let groups = kernel.entry.groups(&work);
            let sets = [&band.set, &self.resident.set];
            let added = self.kernels.context.run(|passes| {
                passes.compute(&pipeline, &sets, bytemuck::bytes_of(&work), groups);
            });
            match added {
                // Rows before have their samples, and whoever is told of an error would give them once more.
                Err(_) if first > rows.start => return Ok(first - rows.start),
                added => added?,
            }
        }
        Ok(rows.len() as u32)
    }

    fn set_film(&mut self, film: &Film) -> Result<(), DeviceError> {
        for band in self.films.shown() {
            let width = self.work.width as usize;
            let pixels = &film.pixels()[band.rows.start as usize * width..band.rows.end as usize * width];
            band.film.write(bytemuck::cast_slice(pixels))?;
        }
        Ok(())
    }

    fn rest(&mut self, blocks: Option<&Blocks>) -> Result<(), DeviceError> {
        self.work.adaptive = u32::from(blocks.is_some());
        self.resting = self.kernels.resting(blocks.map_or(&[], Blocks::words))?;
        for band in self.films.iter_mut().flatten() {
            band.set = self.kernels.band_set(&band.film, &self.resting)?;
        }
        Ok(())
    }

    fn restart(&mut self, scene: &DeviceScene) -> Result<(), DeviceError> {
        scene.buffers.check_after(&self.resident.lists.buffers)?;
        self.is_edited |= !scene.buffers.is_view_of(&self.resident.lists.buffers);
        self.resident = self.kernels.upload(scene, Some(&self.resident))?;
        let same_size = (self.work.width, self.work.height) == (scene.work.width, scene.work.height);
        #[cfg(target_os = "linux")]
        match &mut self.noiseless {
            Some(noiseless) if same_size => noiseless.begin_anew(),
            noiseless => *noiseless = None,
        }
        if same_size {
            let bands = self.films.iter().flatten();
            self.kernels.context.run(|passes| bands.for_each(|band| passes.clear(&band.film)))?;
        } else {
            self.output = None;
            self.reference = None;
            self.films.renew(|| self.kernels.film(&scene.work, &self.resting))?;
        }
        self.work = scene.work;
        self.integrator = scene.settings.integrator;
        if self.accepts_general && self.is_edited {
            self.compile_for_edits();
        }
        Ok(())
    }

    fn revive(&mut self, scene: &DeviceScene) -> Result<String, DeviceError> {
        let kernels = self.hardware.renew(&self.kernels)?;
        // What was on the device before goes first, for two of each may be more than fits.
        let resting = kernels.resting(&[])?;
        (self.output, self.reference) = (None, None);
        #[cfg(target_os = "linux")]
        {
            self.noiseless = None;
        }
        self.films = Films::new(vec![]);
        let empty = SceneLists { buffers: SceneBuffers::default(), boxed: Arc::default(), queries: false };
        self.resident = kernels.upload_lists(empty, None, None)?;
        (self.kernels, self.resting) = (kernels, resting);
        self.resident = self.kernels.upload(scene, None)?;
        self.films = Films::new(self.kernels.film(&scene.work, &self.resting)?);
        (self.work, self.integrator) = (scene.work, scene.settings.integrator);
        Ok("it was opened again".into())
    }

    fn may_be_lost(&self) -> bool {
        true
    }

    fn tracer(&self) -> Option<Tracer> {
        Some(if self.resident.variant.has_queries() { Tracer::Hardware } else { Tracer::Software })
    }

    fn set_reference(&mut self, reference: Option<&Image>) -> Result<(), DeviceError> {
        self.output = None;
        self.reference = None;
        if let Some(image) = reference {
            let pixels = reference_pixels(image, self.work.width, self.work.height);
            let bytes = bytemuck::cast_slice(&pixels);
            self.reference = Some(Arc::new(Buffer::with_bytes(&self.kernels.context, "reference image", bytes)?));
        }
        Ok(())
    }

    fn display(&mut self, display: Display) -> Result<Pixels, DeviceError> {
        let output = match self.output.take() {
            Some(output) => output,
            None => self.kernels.output(&self.work, self.films.shown(), self.reference.as_ref())?,
        };
        let work = display.apply(self.work, self.reference.is_some());
        self.kernels.display(&work, self.films.shown(), &output)?;
        Ok(Pixels::Device(self.output.insert(output).pixels.clone()))
    }

    #[cfg(target_os = "linux")]
    fn denoise(&mut self, denoiser: &Denoiser, care: Care, display: Display) -> Result<Denoised, DeviceError> {
        self.show_denoised(denoiser, care, display)
    }

    fn pixels(&self, columns: Range<u32>, y: u32) -> Result<Vec<FilmPixel>, DeviceError> {
        let band = self.films.shown().iter().find(|band| band.rows.contains(&y));
        let band = band.ok_or_else(|| DeviceError::Host(format!("there is no row {y} in the film")))?;
        let row = u64::from(y - band.rows.start) * u64::from(self.work.width);
        let place = |x: u32| (row + u64::from(x)) * size_of::<FilmPixel>() as u64;
        let bytes = band.film.read_range(place(columns.start)..place(columns.end))?;
        Ok(bytemuck::allocation::pod_collect_to_vec(&bytes))
    }

    fn film(&self) -> Result<Film, DeviceError> {
        // Memory that the system gives zeroed is touched once, by the copy.
        let width = self.work.width as usize;
        let mut pixels = bytemuck::zeroed_vec::<FilmPixel>(width * self.work.height as usize);
        for band in self.films.shown() {
            let rows = band.rows.start as usize * width..band.rows.end as usize * width;
            let rows: &mut [u8] = bytemuck::cast_slice_mut(&mut pixels[rows]);
            band.film.read_by(0..rows.len() as u64, |place, bytes| {
                copy(&mut rows[place..][..bytes.len()], bytes);
            })?;
        }
        Ok(Film::from_pixels(self.work.width, self.work.height, pixels))
    }

    #[cfg(target_os = "linux")]
    fn means_in_cuda(&self) -> Result<Option<CudaMemory>, DeviceError> {
        let context = &self.kernels.context;
        if !context.exports_memory() || self.films.feature() != Feature::Radiance || !CudaMemory::knows(context) {
            return Ok(None);
        }
        let bands = self.films.shown();
        let bytes = bands.iter().map(|band| band.film.size()).sum();
        let exported = ExportedBuffer::new(context, "a film for CUDA", bytes)?;
        let mut place = 0;
        for band in bands {
            exported.copy_from(&band.film, place)?;
            place += band.film.size();
        }
        Ok(Some(CudaMemory::means_of(&exported)?))
    }

    fn ask(&mut self, probe: Probe, questions: &[Question]) -> Result<Vec<Answer>, DeviceError> {
        let context = &self.kernels.context;
        let work = Work { probe: probe as u32, count: questions.len() as u32, ..self.work };
        let input = Arc::new(Buffer::with_bytes(context, "questions", bytemuck::cast_slice(questions))?);
        let output = Arc::new(Buffer::zeroed(context, "answers", size_of_val(questions) as u64)?);
        let set = self.kernels.bind(&[(INPUT_BINDING, input), (OUTPUT_BINDING, output.clone())])?;
        let sets = [&set, &self.resident.set];
        let groups = EntryPoint::Probe.groups(&work);
        let variant = self.resident.variant;
        let variant = if probe.is_full() { variant.full() } else { variant };
        let special = Specialization { probe: probe as u32, ..Specialization::GENERAL };
        let pipeline = self.kernels.get(Kernel { entry: EntryPoint::Probe, variant, special })?;
        context.run(|passes| passes.compute(&pipeline, &sets, bytemuck::bytes_of(&work), groups))?;
        Ok(bytemuck::allocation::pod_collect_to_vec(&output.read()?))
    }

    fn patience_seconds(&self) -> f64 {
        // A desktop drawn by the same device stays usable, and no driver's watchdog wakes up.
        0.05
    }
}
