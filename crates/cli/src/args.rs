use std::path::PathBuf;
use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser, UnknownArgumentValueParser};
use clap::{Args, Parser, Subcommand};
use raggio_render::{
    Aov, Choice, CpuOptions, DeviceChoice, DeviceSelection, Every, FrameRate, Frames, OpenOptions, PictureFormat,
    PngBits, ToneMapper, Tracer, endings,
};
use raggio_scene::{AssetOptions, Filter, Integrator, ModelFormat, Sampler};

use crate::progress::ProgressStyle;

const EXIT_STATUSES: &str = "\
Exit status:
  0    done
  2    the arguments, the scene, a film or a file to write are wrong
  3    the device has failed, or raggio has a fault of its own
  4    a file could not be written in its place; the film is saved, and the last lines say where
  129  stopped by SIGHUP,
  130  interrupted (Ctrl-C, SIGINT), or
  143  stopped by SIGTERM: the picture of what there was by then is written";

const BENCH_HELP: &str = "\
The score of a scene is its samples a second beside those of raggio of 2026-11-23 on two cores of a Zen 4, which are 100; \
that of a device is the geometric mean of its scenes. Other programs that run meanwhile lower it.";

/// A progressive path tracer on Vulkan and the CPU.
#[derive(Parser)]
#[command(name = "raggio", version, propagate_version = true, after_help = EXIT_STATUSES)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand)]
pub enum Command {
    /// Render a scene to image files
    #[command(after_help = EXIT_STATUSES)]
    Render(Box<RenderArguments>),
    /// Add up films of one scene, and make pictures of them
    #[command(after_help = EXIT_STATUSES)]
    Merge(MergeArguments),
    #[cfg(feature = "window")]
    /// Open a scene in a window and fly through it while the picture converges
    View(ViewArguments),
    /// Say that this build has no window
    #[cfg(not(feature = "window"))]
    #[command(hide = true)]
    View {
        /// Arguments that a build with a window takes
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<std::ffi::OsString>,
    },
    /// List the devices that can render, and what they lack if anything
    Devices,
    /// Read a scene and say what is wrong with it, if anything
    Check {
        #[arg(help = scene_help(""))]
        scene: PathBuf,
        #[command(flatten)]
        assets: AssetArguments,
    },
    /// Render the scene that comes with raggio, to showcase.png
    Demo(DemoArguments),
    /// Measure the speed of devices on scenes that come with raggio
    #[command(after_help = BENCH_HELP)]
    Bench(BenchArguments),
    /// Print the JSON Schema of scene files, for editors
    Schema,
    /// Print a script that completes raggio's commands and options in a shell
    Completions {
        /// Name of the shell: bash, zsh, fish, elvish or powershell
        shell: clap_complete::Shell,
    },
    /// Write the manual pages, raggio.1 and one for each command
    Manual {
        /// Folder for them, which is made where it is missing
        folder: PathBuf,
    },
}

#[derive(Args)]
pub struct RenderArguments {
    #[arg(help = scene_help(", which gets a camera, a ground and a sky"))]
    pub scene: PathBuf,
    #[command(flatten)]
    pub assets: AssetArguments,
    #[arg(short, long = "output", value_name = "FILE", help = output_help())]
    pub output: Vec<PathBuf>,
    #[command(flatten)]
    pub frames: FrameArguments,
    #[command(flatten)]
    pub machine: MachineArguments,
    /// Render on the machines of a Ray cluster: HOST:PORT of its head, auto (this machine is part of it) or local (this machine
    /// alone); needs a Python with raggio[cluster], which RAGGIO_PYTHON names [default: python3 on the PATH]
    #[arg(long, value_name = "ADDRESS")]
    pub cluster: Option<String>,
    #[command(flatten)]
    pub overrides: Overrides,
    /// Way of following light
    #[arg(long, value_name = "NAME", value_parser = one_of::<Integrator>(), default_value_t = Integrator::Path)]
    pub integrator: Integrator,
    #[command(flatten)]
    pub stop: StopArguments,
    /// Write these layers into the EXR too, separated by commas
    #[arg(long, value_name = "LAYER", value_delimiter = ',', value_parser = layers())]
    pub aov: Vec<Layers>,
    /// Write each picture without its noise too, as NAME.denoised.png or .exr (Intel Open Image Denoise)
    #[arg(long)]
    pub denoise: bool,
    /// Write figures of the render to this file, as JSON
    #[arg(long, value_name = "FILE")]
    pub stats: Option<PathBuf>,
    #[command(flatten)]
    pub checkpoints: CheckpointArguments,
    /// Way of telling how the render goes
    #[arg(long, value_name = "STYLE", value_parser = one_of::<ProgressStyle>(), default_value_t = ProgressStyle::Auto)]
    pub progress: ProgressStyle,
    #[command(flatten)]
    pub look: LookArguments,
}

/// Frames of an animation.
#[derive(Args)]
pub struct FrameArguments {
    /// Render these frames, as 1-240 or 1-3,5,7-10:2 (a step), each to its own files: a row of # in names stands for the
    /// number; frame 1 is the moment of --time or 0. Whole frames that are there are not rendered again
    #[arg(long, value_name = "RANGE")]
    pub frames: Option<Frames>,
    /// Frames a second
    #[arg(long, value_name = "RATE", default_value = "24")]
    pub fps: FrameRate,
    /// Render frames again that are done already
    #[arg(long, visible_alias = "force", requires = "frames")]
    pub overwrite: bool,
    /// Make a video (.mp4, H.264) of the frames when all are done; needs ffmpeg on the PATH
    #[arg(long, value_name = "FILE", requires = "frames")]
    pub video: Option<PathBuf>,
}

/// Colours and bits of PNGs.
#[derive(Args)]
pub struct LookArguments {
    /// Brighten (or darken) PNGs by this many stops
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true, value_parser = stops)]
    pub exposure: f32,
    /// Curve that squeezes radiance into what a display can show, for PNGs
    #[arg(long, value_name = "NAME", value_parser = one_of::<ToneMapper>(), default_value_t = ToneMapper::Neutral)]
    pub tone_mapper: ToneMapper,
    /// Bits of each channel of PNGs
    #[arg(long, value_name = "BITS", value_parser = one_of::<PngBits>(), default_value_t = PngBits::Eight)]
    pub png_bits: PngBits,
}

/// Films that a render goes on from after whatever has ended it early.
#[derive(Args)]
pub struct CheckpointArguments {
    /// Keep what there is in this film while rendering, and the one before as FILE.previous; both go when all is done
    /// [default: OUTPUT.checkpoint, if the render takes over a minute]
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    /// Time or samples of each pixel from one checkpoint to the next: 60s, 5min, 2h, or 64samples [default: 60s]
    #[arg(long, value_name = "INTERVAL", value_parser = interval)]
    pub checkpoint_every: Option<Every>,
    /// Keep no checkpoints, however long it takes
    #[arg(long, conflicts_with_all = ["checkpoint", "checkpoint_every", "resume"])]
    pub no_checkpoint: bool,
    /// Go on from the checkpoint, or begin where there is none
    #[arg(long)]
    pub resume: bool,
}

#[derive(Args)]
pub struct MergeArguments {
    /// Films of one scene and one set of settings, each of other samples; checkpoints are films too
    #[arg(required = true, value_name = "FILM")]
    pub films: Vec<PathBuf>,
    #[arg(short, long = "output", value_name = "FILE", required = true, help = merged_help())]
    pub output: Vec<PathBuf>,
    /// Write each picture without its noise too, as NAME.denoised.png or .exr; films hold no layers that would keep its
    /// edges, which `raggio render --denoise` has
    #[arg(long)]
    pub denoise: bool,
    #[command(flatten)]
    pub look: LookArguments,
    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// End of sampling before all samples are there. Without --samples, the scene's number does not count then.
#[derive(Args)]
pub struct StopArguments {
    /// Stop sampling after so many seconds
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub time_limit: Option<f32>,
    /// Sample each part of the picture until its relative error is below this, as 0.01 [at most 65536 samples per pixel, unless --samples says so]
    #[arg(long, value_name = "ERROR", value_parser = positive)]
    pub noise: Option<f32>,
}

#[derive(Args)]
pub struct DemoArguments {
    /// Image to write
    #[arg(short, long = "output", value_name = "FILE", default_value = "showcase.png")]
    pub output: PathBuf,
    #[command(flatten)]
    pub machine: MachineArguments,
    #[command(flatten)]
    pub overrides: Overrides,
}

#[derive(Args)]
pub struct BenchArguments {
    /// Devices to measure, separated by commas: auto, cpu, vulkan or vulkan:N (N as in `raggio devices`)
    #[arg(long, value_name = "DEVICE", value_delimiter = ',', default_value = "auto")]
    pub device: Vec<DeviceChoice>,
    /// Threads of the cpu device [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub threads: Option<u32>,
    #[command(flatten)]
    pub tracer: TracerArguments,
    /// Seconds of sampling on each scene
    #[arg(long, value_name = "SECONDS", value_parser = positive, default_value_t = 5.0)]
    pub seconds: f32,
    /// Write all figures to this file, as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

impl BenchArguments {
    /// Options for opening a device.
    pub fn options(&self) -> OpenOptions {
        open_options(self.threads, &self.tracer)
    }
}

#[cfg(feature = "window")]
#[derive(Args)]
pub struct ViewArguments {
    #[arg(help = scene_help(", which gets a camera, a ground and a sky"))]
    pub scene: PathBuf,
    #[command(flatten)]
    pub assets: AssetArguments,
    #[command(flatten)]
    pub machine: MachineArguments,
    /// Size of the window; the picture takes what the panels leave of it
    #[arg(long, value_name = "WxH", default_value = "1280x800")]
    pub size: Size,
    /// Pixels in a point of the panels [default: as the desktop says]
    #[arg(long, value_name = "FACTOR", value_parser = scale)]
    pub scale: Option<f32>,
    /// Play a script: a turntable, a benchmark (docs/viewer.md lists its words)
    #[arg(long, value_name = "FILE")]
    pub play: Option<PathBuf>,
    /// Compile the kernels in this folder again whenever they change [default: the folder this program was built from]
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, default_missing_value = raggio_render::KERNELS_FOLDER)]
    pub watch_kernels: Option<PathBuf>,
    /// Draw the frames, but open no window: needs no display, only a script
    #[arg(long, requires = "play")]
    pub hidden: bool,
    /// Write the script's frame times to this file, as JSON
    #[arg(long, value_name = "FILE", requires = "play")]
    pub stats: Option<PathBuf>,
}

/// Reading of models.
#[derive(Args)]
pub struct AssetArguments {
    /// The moment of animations, in seconds from their beginning, in place of the scene's [default: the pose of rest]
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, value_parser = seconds)]
    pub time: Option<f64>,
    /// Let models name files outside their own folder
    #[arg(long)]
    pub allow_outside: bool,
    /// Camera of a model that is shown without a scene, by its name or number; `raggio check` lists them [default: the
    /// first, or one that sees all]
    #[arg(long, value_name = "NAME|N")]
    pub camera: Option<String>,
}

impl AssetArguments {
    /// Options for a picture of `size`, if that is known.
    pub fn options(&self, size: Option<Size>) -> AssetOptions {
        AssetOptions {
            allow_outside: self.allow_outside,
            time_seconds: self.time,
            elapsed_seconds: None,
            picture: size.map(|size| [size.width, size.height]),
            camera: self.camera.clone(),
        }
    }
}

/// Machine to render on, and how loudly.
#[derive(Args)]
pub struct MachineArguments {
    /// Device: auto, cpu, vulkan or vulkan:N (N as in `raggio devices`); auto is a GPU if there is one, else the CPU;
    /// several separated by commas share the picture, and all is every GPU with the CPU
    #[arg(long, value_name = "DEVICE", default_value_t = DeviceChoice::Auto.into())]
    pub device: DeviceSelection,
    /// Threads of the cpu device; where there are fewer cores, 64 at most [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub threads: Option<u32>,
    #[command(flatten)]
    pub tracer: TracerArguments,
    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

impl MachineArguments {
    /// Options for opening a device.
    pub fn options(&self) -> OpenOptions {
        open_options(self.threads, &self.tracer)
    }
}

/// Tracing of rays by GPUs.
#[derive(Args)]
pub struct TracerArguments {
    /// Who finds what rays meet on a GPU
    #[arg(long, value_name = "NAME", value_parser = one_of::<Tracer>(), default_value_t = Tracer::Auto)]
    pub tracer: Tracer,
}

/// Options for opening a device. `RAGGIO_VALIDATE=1` turns on the Vulkan validation layers.
fn open_options(threads: Option<u32>, tracer: &TracerArguments) -> OpenOptions {
    OpenOptions {
        cpu: CpuOptions { threads: threads.unwrap_or(0) as usize, ..CpuOptions::default() },
        tracer: tracer.tracer,
        validate: std::env::var_os("RAGGIO_VALIDATE").is_some_and(|value| value == "1"),
        instance: None,
        cache: raggio_render::cache_folder(),
        ..OpenOptions::default()
    }
}

/// Keys of the scene's [render] that the command line overrides.
#[derive(Args)]
pub struct Overrides {
    /// Samples per pixel; A..B takes those from A to B-1 alone, whose film adds up with those of other ranges
    #[arg(long, value_name = "N|A..B", value_parser = sample_range)]
    pub samples: Option<SampleRange>,
    /// Size of the image in pixels; keeps the vertical field of view
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,
    /// Most rays along one path, the camera's included; 0 sets no limit
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=65535))]
    pub max_depth: Option<u32>,
    /// Seed of the random numbers: another seed is another picture of the same noise level
    #[arg(long, value_name = "N")]
    pub seed: Option<u32>,
    /// Source of the random numbers [default: sobol]
    #[arg(long, value_name = "NAME", value_parser = one_of::<Sampler>())]
    pub sampler: Option<Sampler>,
    /// Take off what any sample's largest channel has above this, which loses light and fireflies [default: nothing]
    #[arg(long, value_name = "RADIANCE", value_parser = positive)]
    pub clamp: Option<f32>,
    /// Weights with which the picture around a pixel's centre makes its value [default: box]
    #[arg(long, value_name = "NAME", value_parser = one_of::<Filter>())]
    pub filter: Option<Filter>,
    /// Give pictures an alpha channel, and leave out the background where it is seen directly
    #[arg(long)]
    pub alpha: bool,
    #[command(flatten)]
    pub foreign: ForeignNames,
}

/// Other renderers' names of options; the error for each tells ours.
#[derive(Args)]
pub struct ForeignNames {
    #[arg(long, hide = true, value_parser = UnknownArgumentValueParser::suggest_arg("--samples"))]
    spp: Option<()>,
    #[arg(long, hide = true, value_parser = UnknownArgumentValueParser::suggest_arg("--size"))]
    resolution: Option<()>,
    #[arg(long, hide = true, value_parser = UnknownArgumentValueParser::suggest_arg("--size"))]
    width: Option<()>,
    #[arg(long, hide = true, value_parser = UnknownArgumentValueParser::suggest_arg("--size"))]
    height: Option<()>,
    #[arg(long, hide = true, value_parser = UnknownArgumentValueParser::suggest_arg("--max-depth"))]
    bounces: Option<()>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    pub width: u32,
    pub height: u32,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |text: &str| text.parse().ok().filter(|n| (1..=65536).contains(n));
        text.split_once(['x', 'X'])
            .and_then(|(width, height)| Some(Self { width: side(width)?, height: side(height)? }))
            .ok_or_else(|| "give width and height in pixels, each 1 to 65536, as in 1280x720".into())
    }
}

/// Numbers of the samples of each pixel: the first, and the one after the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleRange {
    pub start: u32,
    pub end: u32,
}

fn sample_range(text: &str) -> Result<SampleRange, String> {
    let number = |text: &str| text.parse().ok().filter(|n| *n <= i32::MAX as u32);
    let range = match text.split_once("..") {
        None => number(text).map(|end| SampleRange { start: 0, end }),
        Some((start, end)) => number(start).zip(number(end)).map(|(start, end)| SampleRange { start, end }),
    };
    range
        .filter(|range| range.start < range.end)
        .ok_or_else(|| format!("give a number from 1 to {}, or a range as 64..128: samples 64 to 127", i32::MAX))
}

/// Interval from one checkpoint to the next.
fn interval(text: &str) -> Result<Every, String> {
    let unit = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = (text[..unit].trim(), &text[unit..]);
    let seconds = |factor: f64| {
        let number = number.parse::<f64>().ok().map(|number| factor * number);
        number.filter(|seconds| (0.001..=1e9).contains(seconds)).map(Every::Seconds)
    };
    let every = match unit {
        "s" => seconds(1.0),
        "min" => seconds(60.0),
        "h" => seconds(3600.0),
        "samples" | "sample" => number.parse().ok().filter(|count| *count > 0).map(Every::Samples),
        _ => None,
    };
    every.ok_or_else(|| "give a time (60s, 5min, 2h) or a number of samples (64samples)".into())
}

#[cfg(feature = "window")]
fn scale(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|scale| (0.25..=8.0).contains(scale)).ok_or_else(|| "give a number from 0.25 to 8".into())
}

fn positive(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|number: &f32| *number > 0.0 && number.is_finite())
        .ok_or_else(|| "give a number greater than 0".into())
}

fn seconds(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|time| (0.0..=1e9).contains(time)).ok_or_else(|| "give seconds, 0 to 1e9".into())
}

fn stops(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|stops| (-32.0..=32.0).contains(stops))
        .ok_or_else(|| "give stops between -32 and 32".into())
}

/// Layers that a word on the command line stands for.
pub type Layers = &'static [Aov];

/// Parser of a choice's names, which help texts explain.
fn one_of<T: Choice>() -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(T::ALL.iter().map(described)).try_map(|name| name.parse::<T>())
}

/// Parser of a layer's name, or of `all`.
fn layers() -> impl TypedValueParser<Value = Layers> {
    let all = PossibleValue::new("all").help("All of them");
    PossibleValuesParser::new(std::iter::once(all).chain(Aov::ALL.iter().map(described))).map(|name| {
        let known = Aov::ALL.iter().position(|aov| aov.name() == name);
        known.map_or(Aov::ALL, |place| &Aov::ALL[place..=place])
    })
}

fn described<T: Choice>(choice: &T) -> PossibleValue {
    // Sentences of help texts have no full stop.
    PossibleValue::new(choice.name()).help(choice.description().trim_end_matches('.'))
}

fn scene_help(more: &str) -> String {
    format!("Scene file (.toml), or a model ({}){more}", endings::<ModelFormat>())
}

fn output_help() -> String {
    let formats = PictureFormat::listed();
    format!("File to write, {formats}; may be given several times [default: NAME.png, or NAME-####.png with --frames]")
}

fn merged_help() -> String {
    format!("File to write, {}; may be given several times", PictureFormat::listed())
}
