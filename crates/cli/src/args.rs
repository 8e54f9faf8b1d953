use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, Parser, Subcommand, ValueEnum};
use raggio_render::{Aov, CpuOptions, DeviceChoice, OpenOptions, ToneMapper};
use raggio_scene::{AssetOptions, Filter, Sampler};

/// A progressive path tracer on Vulkan and the CPU.
#[derive(Parser)]
#[command(name = "raggio", version, propagate_version = true)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand)]
pub enum Command {
    /// Render a scene to image files
    Render(RenderArguments),
    #[cfg(feature = "window")]
    /// Open a scene in a window and fly through it while the picture converges
    View(ViewArguments),
    /// Say that this build has no window
    #[cfg(not(feature = "window"))]
    #[command(hide = true)]
    View {
        /// Whatever a build with a window takes
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<std::ffi::OsString>,
    },
    /// List the devices that can render, and what they lack if anything
    Devices,
    /// Read a scene and say what is wrong with it, if anything
    Check {
        /// Scene file (.toml), or a model (.glb, .gltf, .ply, .obj, .stl)
        scene: PathBuf,
        #[command(flatten)]
        assets: AssetArguments,
    },
    /// Render the scene that comes with raggio, to showcase.png
    Demo(DemoArguments),
    /// Print the JSON Schema of scene files, for editors
    Schema,
    /// Print a script that completes raggio's commands and options in a shell
    Completions {
        /// bash, zsh, fish, elvish or powershell
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
    /// Scene file (.toml), or a model (.glb, .gltf, .ply, .obj, .stl), which gets a camera, a ground and a sky
    pub scene: PathBuf,
    #[command(flatten)]
    pub assets: AssetArguments,
    /// Image to write, .png (tone-mapped) or .exr (linear radiance); may be given several times [default: NAME.png]
    #[arg(short, long = "output", value_name = "FILE")]
    pub output: Vec<PathBuf>,
    #[command(flatten)]
    pub machine: MachineArguments,
    #[command(flatten)]
    pub overrides: Overrides,
    /// How light is followed
    #[arg(long, value_enum, default_value_t = Integrator::Path)]
    pub integrator: Integrator,
    #[command(flatten)]
    pub stop: StopArguments,
    /// Write these layers into the EXR too, separated by commas
    #[arg(long, value_enum, value_name = "LAYER", value_delimiter = ',')]
    pub aov: Vec<AovName>,
    /// Write each picture without its noise too, as NAME.denoised.png or .exr (Intel Open Image Denoise)
    #[arg(long)]
    pub denoise: bool,
    /// Write figures of the render to this file, as JSON
    #[arg(long, value_name = "FILE")]
    pub stats: Option<PathBuf>,
    /// Brighten (or darken) PNGs by this many stops
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true, value_parser = stops)]
    pub exposure: f32,
    /// How PNGs squeeze radiance into what a display can show
    #[arg(long, value_enum, default_value_t = ToneMapperName::Neutral)]
    pub tone_mapper: ToneMapperName,
}

/// When there are samples enough. Without --samples, the scene's number does not count then.
#[derive(Args, Clone, Copy, Default)]
pub struct StopArguments {
    /// Stop sampling after so many seconds
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub time_limit: Option<f32>,
    /// Sample each part of the picture until its relative error is below this, as 0.01 [at most 65536 samples per pixel, unless --samples says so]
    #[arg(long, value_name = "ERROR", value_parser = positive)]
    pub noise: Option<f32>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum AovName {
    /// All of them
    All,
    /// Colour of the first surface: albedo.R, .G, .B
    Albedo,
    /// Its normal in the world: normal.X, .Y, .Z
    Normal,
    /// Its distance along the view direction: depth.Z
    Depth,
    /// Where it is in the world: position.X, .Y, .Z
    Position,
    /// Pixels a frame: motion.X, .Y; 0, for scenes stand still
    Motion,
    /// Number of the shape in the pixel's middle, from 1 on: object_id.I
    ObjectId,
    /// Number of its material, from 1 on: material_id.I
    MaterialId,
    /// Number of samples: samples.N
    Samples,
    /// Variance of the mean luminance: variance.Y
    Variance,
}

impl AovName {
    /// What it stands for.
    pub fn aovs(self) -> &'static [Aov] {
        match self {
            Self::All => &Aov::ALL,
            Self::Albedo => &[Aov::Albedo],
            Self::Normal => &[Aov::Normal],
            Self::Depth => &[Aov::Depth],
            Self::Position => &[Aov::Position],
            Self::Motion => &[Aov::Motion],
            Self::ObjectId => &[Aov::ObjectId],
            Self::MaterialId => &[Aov::MaterialId],
            Self::Samples => &[Aov::Samples],
            Self::Variance => &[Aov::Variance],
        }
    }
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

#[cfg(feature = "window")]
#[derive(Args)]
pub struct ViewArguments {
    /// Scene file (.toml), or a model (.glb, .gltf, .ply, .obj, .stl), which gets a camera, a ground and a sky
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

/// How models are read.
#[derive(Args)]
pub struct AssetArguments {
    /// The moment of animations, in seconds from their beginning, in place of the scene's [default: the pose of rest]
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, value_parser = seconds)]
    pub time: Option<f64>,
    /// Let models name files outside their own folder
    #[arg(long)]
    pub allow_outside: bool,
}

impl AssetArguments {
    /// `size` is that of the picture, if it is known.
    pub fn options(&self, size: Option<Size>) -> AssetOptions {
        AssetOptions {
            allow_outside: self.allow_outside,
            time_seconds: self.time,
            picture: size.map(|size| [size.width, size.height]),
        }
    }
}

/// What to render on, and how loudly.
#[derive(Args)]
pub struct MachineArguments {
    /// auto, cpu, vulkan or vulkan:N (as `raggio devices` numbers them); auto is a GPU if there is one, else the CPU
    #[arg(long, value_name = "DEVICE", default_value_t = DeviceChoice::Auto)]
    pub device: DeviceChoice,
    /// Threads of the cpu device [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub threads: Option<u32>,
    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

impl MachineArguments {
    /// `RAGGIO_VALIDATE=1` turns on the Vulkan validation layers.
    pub fn options(&self) -> OpenOptions {
        OpenOptions {
            cpu: CpuOptions { threads: self.threads.unwrap_or(0) as usize, ..CpuOptions::default() },
            validate: std::env::var_os("RAGGIO_VALIDATE").is_some_and(|value| value == "1"),
            instance: None,
        }
    }
}

/// Keys of the scene's [render] that the command line overrides.
#[derive(Args)]
pub struct Overrides {
    /// Samples per pixel
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i32::MAX as i64))]
    pub samples: Option<u32>,
    /// Size of the image in pixels; keeps the vertical field of view
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,
    /// Most rays along one path, the camera's included; 0 sets no limit
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=65535))]
    pub max_depth: Option<u32>,
    /// Selects the random numbers: another seed is another picture of the same noise level
    #[arg(long, value_name = "N")]
    pub seed: Option<u32>,
    /// Where the random numbers come from
    #[arg(long, value_enum)]
    pub sampler: Option<SamplerName>,
    /// Take off what any sample's largest channel has above this, which loses light and fireflies [default: nothing]
    #[arg(long, value_name = "RADIANCE", value_parser = positive)]
    pub clamp: Option<f32>,
    /// With which weights the picture around a pixel's centre makes its value
    #[arg(long, value_enum)]
    pub filter: Option<FilterName>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum FilterName {
    /// All of the pixel's area alike [default]
    Box,
    /// A smooth bell 3 pixels wide: the softest
    BlackmanHarris,
    /// Mitchell and Netravali's, 4 pixels wide, with negative lobes: the sharpest
    Mitchell,
    /// The pixel's centre alone, which shows aliasing
    Point,
}

impl From<FilterName> for Filter {
    fn from(name: FilterName) -> Self {
        match name {
            FilterName::Box => Self::Box,
            FilterName::BlackmanHarris => Self::BlackmanHarris,
            FilterName::Mitchell => Self::Mitchell,
            FilterName::Point => Self::Point,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum SamplerName {
    /// Scrambled Sobol' points, which spread evenly: less noise [default]
    Sobol,
    /// Independent numbers
    Pcg,
}

impl From<SamplerName> for Sampler {
    fn from(name: SamplerName) -> Self {
        match name {
            SamplerName::Sobol => Self::Sobol,
            SamplerName::Pcg => Self::Pcg,
        }
    }
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

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Integrator {
    /// Looks for lights at each surface
    Path,
    /// The naive path tracer: no light sampling, no tricks
    Reference,
}

impl Integrator {
    /// As users write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Path => "path",
            Self::Reference => "reference",
        }
    }
}

impl From<Integrator> for raggio_scene::Integrator {
    fn from(integrator: Integrator) -> Self {
        match integrator {
            Integrator::Path => Self::Path,
            Integrator::Reference => Self::Reference,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum ToneMapperName {
    /// Khronos PBR Neutral: colours stay what they are, highlights roll off
    Neutral,
    /// AgX, the default of Blender: bright colours fade to white as on film
    Agx,
    /// The film-like curve of ACES
    Aces,
    /// Hable's film curve of Uncharted 2
    Filmic,
    /// Reinhard's curve of luminance, with 4 as white
    Reinhard,
    /// Cut off at 1
    None,
}

impl From<ToneMapperName> for ToneMapper {
    fn from(name: ToneMapperName) -> Self {
        match name {
            ToneMapperName::Neutral => Self::Neutral,
            ToneMapperName::Agx => Self::Agx,
            ToneMapperName::Aces => Self::Aces,
            ToneMapperName::Filmic => Self::Filmic,
            ToneMapperName::Reinhard => Self::Reinhard,
            ToneMapperName::None => Self::None,
        }
    }
}
