//! Kernels that drivers compile: told, not counted, and kept for the next time.

use std::ops::{ControlFlow, Range};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use raggio_render::{
    Device, DeviceError, DeviceScene, Feature, Observer, Phase, Progress, RenderRequest, Rendering, Session, Stop,
    Tracer, VulkanDevice,
};
use raggio_vulkan::{Device as VulkanContext, Instance, PhysicalDevice, PipelineCache};

use crate::checkpoints::scene;
use crate::scripted::{Script, Scripted};

/// Time that the driver of [`Slow`] compiles for.
const COMPILING: Duration = Duration::from_millis(800);

/// A device whose driver takes its time, or fails.
struct Slow {
    fails: bool,
    has_been_told: Arc<AtomicBool>,
}

struct SlowSession {
    is_prepared: bool,
    fails: bool,
}

impl Device for Slow {
    fn name(&self) -> String {
        "slow".into()
    }

    fn compile_ahead(&self, _: &DeviceScene, features: &[Feature]) {
        assert_eq!(features, [Feature::Radiance]);
        self.has_been_told.store(true, Ordering::Relaxed);
    }

    fn load(&self, scene: &DeviceScene) -> Result<Box<dyn Session>, DeviceError> {
        assert!(self.has_been_told.load(Ordering::Relaxed), "kernels are compiled while the scene is uploaded");
        let script = SlowSession { is_prepared: false, fails: self.fails };
        Ok(Box::new(Scripted { size: [scene.work.width, scene.work.height], patience: 1e-3, script }))
    }
}

impl Script for SlowSession {
    fn prepare(&mut self) -> Result<(), DeviceError> {
        if self.fails {
            return Err(DeviceError::Host("it cannot compile the kernels".into()));
        }
        if !self.is_prepared {
            std::thread::sleep(COMPILING);
        }
        self.is_prepared = true;
        Ok(())
    }

    fn is_prepared(&self) -> bool {
        self.is_prepared
    }

    fn add_samples(&mut self, _: Range<u32>, _: Range<u32>) -> Result<(), DeviceError> {
        assert!(self.is_prepared, "nothing is sampled before");
        std::thread::sleep(Duration::from_millis(1));
        Ok(())
    }
}

/// Observer that keeps what it hears, in order.
#[derive(Default)]
struct Ear(Vec<String>);

impl Observer for Ear {
    fn begin(&mut self, phase: Phase) {
        self.0.push(phase.to_string());
    }

    fn compiling(&mut self, seconds: f64) {
        assert!(seconds > 0.0 && seconds < 60.0);
        self.0.push("wait".into());
    }

    fn progress(&mut self, progress: &Progress) -> ControlFlow<()> {
        if self.0.last().is_none_or(|last| last != "samples") {
            assert!(progress.seconds < COMPILING.as_secs_f64(), "compiling is no sampling");
            self.0.push("samples".into());
        }
        ControlFlow::Continue(())
    }
}

fn slow(fails: bool) -> Slow {
    Slow { fails, has_been_told: Arc::default() }
}

#[test]
fn compiling_is_told_and_no_limit_counts_it() {
    // Less time than compiling takes: some of it is left for samples nevertheless.
    let stop = Stop { time_limit: Some(0.3), ..Stop::default() };
    let request = RenderRequest { stop, ..RenderRequest::default() };
    let rendering = Rendering::begin(&scene(), &slow(false), request).expect("the scene loads");
    let (mut ear, start) = (Ear::default(), Instant::now());
    let rendered = rendering.run(&mut ear).expect("the film is there");
    let waits = ear.0.iter().filter(|heard| *heard == "wait").count();
    assert!(waits >= 2, "{:?}", ear.0);
    ear.0.retain(|heard| heard != "wait");
    assert_eq!(ear.0, ["compiling", "sampling", "samples"]);
    assert!(rendered.progress.total_samples > 0);
    let waited = rendered.preparation.compile_wait_seconds;
    assert!(waited >= COMPILING.as_secs_f64() && waited < start.elapsed().as_secs_f64(), "{waited}");
}

#[test]
fn kernels_that_are_there_are_not_told() {
    let mut rendering = Rendering::begin(&scene(), &slow(false), RenderRequest::default()).expect("the scene loads");
    rendering.prepare(&mut Ear::default()).expect("it compiles");
    let mut ear = Ear::default();
    rendering.prepare(&mut ear).expect("nothing is left to do");
    rendering.sample(&mut ear).expect("it samples");
    assert_eq!(ear.0, ["sampling", "samples"]);
}

#[test]
fn a_failure_of_compiling_is_that_of_the_render() {
    let mut rendering = Rendering::begin(&scene(), &slow(true), RenderRequest::default()).expect("the scene loads");
    let error = rendering.sample(&mut Ear::default()).expect_err("it cannot compile");
    assert_eq!(error.to_string(), "it cannot compile the kernels");
}

/// The first Vulkan device that can run the kernels, if there is one.
fn physical() -> Option<PhysicalDevice> {
    let required = std::env::var("RAGGIO_TEST_EVERYTHING").is_ok_and(|value| value == "1");
    let devices = Instance::new(false).and_then(|instance| instance.devices()).unwrap_or_default();
    let found = devices.into_iter().find(|device| device.lacks().is_empty());
    assert!(found.is_some() || !required, "RAGGIO_TEST_EVERYTHING=1, and there is no Vulkan device");
    if found.is_none() {
        eprintln!("skipped: there is no Vulkan device");
    }
    found
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).map(|entries| entries.map(|entry| entry.expect("an entry").path()));
    entries.map(Iterator::collect).unwrap_or_default()
}

#[test]
fn drivers_are_given_their_own_data_alone() {
    let Some(physical) = physical() else { return };
    let device = VulkanContext::new(&physical).expect("the device opens");
    let data = PipelineCache::new(&device, &[]).and_then(|cache| cache.data()).expect("a cache has data");
    let compiler = physical.compiler();
    assert!(compiler.knows(&data));
    // Length, version, vendor, device and UUID.
    for place in 0..32 {
        let mut foreign = data.clone();
        foreign[place] ^= 0x80;
        assert!(!compiler.knows(&foreign), "byte {place}");
        let cache = PipelineCache::new(&device, &foreign).expect("it is ignored");
        assert!(compiler.knows(&cache.data().expect("a cache has data")));
        cache.merge(&foreign).expect("it is ignored");
    }
    for length in 0..32 {
        assert!(!compiler.knows(&data[..length]), "{length} bytes");
    }
    PipelineCache::new(&device, &data).expect("it is known").merge(&data).expect("it is known");
}

/// One file for all devices of one kind and driver, whole whatever was there, and nothing without a folder.
#[test]
fn what_a_device_has_compiled_is_kept() {
    let Some(physical) = physical() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let cache = folder.path().join("raggio");
    let open = |folder: Option<&Path>| {
        drop(VulkanDevice::new(&physical, Tracer::Auto, folder, false).expect("the device opens"))
    };
    open(Some(&cache));
    let kept = files(&cache);
    let [file] = &kept[..] else { panic!("{kept:?}") };
    let whole = std::fs::read(file).expect("the file");
    // The driver's own data are the end of it.
    assert!(physical.compiler().knows(&whole[80..]));

    open(Some(&cache));
    assert_eq!(files(&cache), kept);
    assert!(std::fs::read(file).expect("the file").len() >= whole.len());

    let mut flipped = whole.clone();
    flipped[100] ^= 1;
    for broken in [&whole[..whole.len() / 2], b"", &flipped, &[0xff; 5000]] {
        std::fs::write(file, broken).expect("the file");
        open(Some(&cache));
        assert_eq!(files(&cache), kept);
        let mended = std::fs::read(file).expect("the file");
        assert!(mended != broken && physical.compiler().knows(&mended[80..]));
    }

    std::fs::remove_file(file).expect("the file");
    std::thread::scope(|scope| (0..3).for_each(|_| drop(scope.spawn(|| open(Some(&cache))))));
    assert_eq!(files(&cache), kept);

    // Where nothing can be kept, devices open nevertheless.
    std::fs::remove_dir_all(&cache).expect("the folder");
    std::fs::write(&cache, "a file").expect("the file");
    open(Some(&cache));
    open(None);
    assert_eq!(files(folder.path()), [cache]);
}
