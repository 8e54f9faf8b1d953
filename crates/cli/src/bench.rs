//! The command `raggio bench`: speed of devices, in figures that people can send one another.

use std::ops::ControlFlow;

use raggio_render::{Device, DeviceError, DeviceInfo, Progress, RenderRequest, Rendering, Stop, Tracer};
use raggio_scene::{Integrator, Scene, counted};
use serde_json::{Value, json};

use crate::args::BenchArguments;
use crate::error::{Failure, cannot_write};
use crate::files::output_file;
use crate::output::{print, say};

/// Version of the scenes, their size and the baseline: scores of different versions cannot be compared.
const VERSION: u32 = 1;
/// Size of all pictures, in pixels: enough of them for a large GPU.
const SIZE: [u32; 2] = [960, 720];
/// Level of the mesh: 327,682 triangles.
const ROCK_LEVEL: u32 = 7;
/// Score of the baseline.
const BASELINE_SCORE: f64 = 100.0;

/// A scene to measure with.
struct Subject {
    name: &'static str,
    /// Text of the scene; `None` for the mesh.
    text: Option<&'static str>,
    /// Msamples/s of the baseline: two cores of a Zen 4, measured on 2026-11-23 (docs/performance.md).
    baseline: f64,
}

const SUBJECTS: [Subject; 5] = [
    Subject { name: "cornell", text: Some(include_str!("../../../scenes/reference/cornell.toml")), baseline: 0.67 },
    Subject { name: "lamp", text: Some(include_str!("../../../scenes/reference/lamp.toml")), baseline: 3.2 },
    Subject { name: "nested", text: Some(include_str!("../../../scenes/reference/nested.toml")), baseline: 4.32 },
    Subject { name: "weekend", text: Some(include_str!("../../../scenes/reference/weekend.toml")), baseline: 2.07 },
    Subject { name: "rock", text: None, baseline: 1.6 },
];

impl Subject {
    fn scene(&self) -> Result<Scene, Failure> {
        let mut scene = match self.text {
            Some(text) => Scene::parse(text, self.name)?,
            None => Scene::rock(ROCK_LEVEL),
        };
        scene.render.integrator = Integrator::Path;
        [scene.render.width, scene.render.height] = SIZE;
        Ok(scene)
    }
}

/// Speed of a device on a scene.
struct Measured {
    subject: &'static Subject,
    triangles: usize,
    samples: u64,
    rays: u64,
    /// Time of sampling.
    seconds: f64,
    /// Who found what rays met.
    tracer: Option<Tracer>,
}

impl Measured {
    fn samples_per_second(&self) -> f64 {
        self.samples as f64 / self.seconds
    }

    fn rays_per_second(&self) -> f64 {
        self.rays as f64 / self.seconds
    }

    fn score(&self) -> f64 {
        BASELINE_SCORE * self.samples_per_second() / (1e6 * self.subject.baseline)
    }

    fn json(&self) -> Value {
        json!({
            "scene": self.subject.name,
            "triangles": self.triangles,
            "tracer": self.tracer.map(Tracer::name),
            "samples": self.samples,
            "rays": self.rays,
            "seconds": self.seconds,
            "samples_per_second": self.samples_per_second(),
            "rays_per_second": self.rays_per_second(),
            "score": self.score(),
        })
    }
}

/// Runs `raggio bench`.
pub fn bench(arguments: &BenchArguments) -> Result<(), Failure> {
    let file = arguments.json.as_deref().map(output_file).transpose()?;
    let infos = raggio_render::devices().0;
    let scenes = SUBJECTS.iter().map(Subject::scene).collect::<Result<Vec<_>, _>>()?;
    print(format_args!("raggio {}, benchmark {VERSION}, {}x{}", env!("CARGO_PKG_VERSION"), SIZE[0], SIZE[1]))?;
    let mut reports = vec![];
    for choice in &arguments.device {
        let warn = |warning: &str| say(format_args!("warning: {warning}"));
        let device = raggio_render::open(*choice, arguments.options(), warn)?;
        let name = device.name();
        let info = infos.iter().find(|info| is_of(&name, info));
        let driver = info.map_or("unknown", |info| info.driver.as_str());
        print(format_args!("\n{name}\n{driver}\n"))?;
        print(format_args!(
            "{:8}  {:>9}  {:>10}  {:>8}  {:>7}",
            "scene", "triangles", "Msamples/s", "Mrays/s", "score"
        ))?;
        let mut measured = vec![];
        for (subject, scene) in SUBJECTS.iter().zip(&scenes) {
            let found = measure(&*device, subject, scene, arguments.seconds)?;
            print(format_args!(
                "{:8}  {:9}  {:10.2}  {:8.2}  {:7.0}",
                subject.name,
                found.triangles,
                found.samples_per_second() / 1e6,
                found.rays_per_second() / 1e6,
                found.score()
            ))?;
            measured.push(found);
        }
        let total = score(&measured);
        print(format_args!("{:8}  {:41.0}", "all", total))?;
        reports.push(json!({
            "device": name,
            "kind": info.map(|info| info.kind),
            "driver": driver,
            "memory_bytes": info.and_then(|info| info.memory_bytes),
            "scenes": measured.iter().map(Measured::json).collect::<Vec<_>>(),
            "score": total,
        }));
    }
    let Some(file) = file else { return Ok(()) };
    let report = json!({
        "raggio": env!("CARGO_PKG_VERSION"),
        "benchmark": VERSION,
        "system": format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        "cores": std::thread::available_parallelism().map_or(1, usize::from),
        "width": SIZE[0],
        "height": SIZE[1],
        "seconds_per_scene": arguments.seconds,
        "baseline": "raggio of 2026-11-23 on two cores of a Zen 4: 100",
        "devices": reports,
    });
    file.write(format!("{report:#}\n").as_bytes()).map_err(|e| cannot_write(file.path(), &e))
}

/// Whether a device of this name is the one of `info`: `NVIDIA H200 (vulkan:0)` has the word of its line in parentheses.
fn is_of(name: &str, info: &DeviceInfo) -> bool {
    let word = name.rsplit_once('(').and_then(|(_, words)| words.split([',', ')']).next());
    word == Some(info.id.as_str())
}

/// Renders `scene` for `seconds`, once the device is ready.
fn measure(device: &dyn Device, subject: &'static Subject, scene: &Scene, seconds: f32) -> Result<Measured, Failure> {
    let stop = Stop { time_limit: Some(seconds), ..Stop::default() };
    let rendering = Rendering::begin(scene, device, RenderRequest { stop, ..RenderRequest::default() })?;
    // Drivers compile kernels first, which is no part of their speed.
    let rendered = rendering.run(&mut |_: &Progress| ControlFlow::Continue(()))?;
    if let Some(error) = rendered.failure {
        return Err(error.into());
    }
    let film = &rendered.picture.film;
    let (samples, rays) = (film.samples(), film.rays());
    if film.rejected() > 0 {
        let lost = counted(film.rejected() as usize, "sample");
        return Err(DeviceError::Host(format!(
            "{lost} of {} had no finite value: this device miscalculates",
            subject.name
        ))
        .into());
    }
    let (triangles, tracer, seconds) = (rendered.triangles, rendered.tracer, rendered.progress.seconds);
    Ok(Measured { subject, triangles, samples, rays, seconds, tracer })
}

/// Geometric mean of all scores: twice the speed on one scene counts as much as on another.
fn score(measured: &[Measured]) -> f64 {
    (measured.iter().map(|found| found.score().ln()).sum::<f64>() / measured.len() as f64).exp()
}
