//! What the rest of the program knows of a device.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use raggio_kernels::{BrokenScene, Probe};
use raggio_vulkan::{DeviceKind, Instance, VulkanError};

use crate::cpu::{CpuDevice, CpuOptions};
use crate::device_scene::DeviceScene;
use crate::film::Film;
use crate::vulkan::VulkanDevice;

/// Something that can trace rays.
pub trait Device {
    /// As shown to users: `NVIDIA H200 (vulkan:0)`.
    fn name(&self) -> String;

    /// What Vulkan's validation layers have said so far, if they are on; empty when all is well.
    fn validation_messages(&self) -> Vec<String> {
        vec![]
    }

    /// Makes `scene` resident, with an empty film.
    fn load<'a>(&'a self, scene: &DeviceScene) -> Result<Box<dyn Session + 'a>, DeviceError>;
}

/// A scene and its film on a device.
pub trait Session {
    /// Adds the samples `samples` to the pixels of `rows`, and waits for them.
    fn add_samples(&mut self, rows: Range<u32>, samples: Range<u32>) -> Result<(), DeviceError>;

    /// The film as it is now.
    fn film(&self) -> Result<Film, DeviceError>;

    /// Evaluates one function of the kernels for many arguments: see `Probe` in `kernels/entry/probe.slang`.
    fn ask(&mut self, probe: Probe, questions: &[Question]) -> Result<Vec<Answer>, DeviceError>;

    /// How long one call of [`Session::add_samples`] may take without harm, in seconds.
    fn patience_seconds(&self) -> f64;
}

/// Arguments of a probe.
pub type Question = [[f32; 4]; 3];
/// What a probe returns.
pub type Answer = [[f32; 4]; 3];

/// Why a device cannot be had or has failed.
#[derive(Debug, thiserror::Error)]
pub enum DeviceError {
    /// A Vulkan call failed.
    #[error(transparent)]
    Vulkan(#[from] VulkanError),
    /// The scene's indices are wrong.
    #[error(transparent)]
    BrokenScene(#[from] BrokenScene),
    /// There is no such device.
    #[error("{0}")]
    NotFound(String),
    /// The machine refused threads or the like.
    #[error("{0}")]
    Host(String),
}

/// Which device is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceChoice {
    /// A discrete or integrated GPU if there is one, the CPU otherwise.
    Auto,
    /// The CPU, through compiled kernels.
    Cpu,
    /// The best Vulkan device, or the one with this number.
    Vulkan(Option<usize>),
}

impl FromStr for DeviceChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            "cpu" => Ok(Self::Cpu),
            "vulkan" => Ok(Self::Vulkan(None)),
            _ => text
                .strip_prefix("vulkan:")
                .and_then(|n| n.parse().ok())
                .map(|n| Self::Vulkan(Some(n)))
                .ok_or_else(|| "give auto, cpu, vulkan or vulkan:N, with N as in `raggio devices`".into()),
        }
    }
}

impl fmt::Display for DeviceChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Cpu => f.write_str("cpu"),
            Self::Vulkan(None) => f.write_str("vulkan"),
            Self::Vulkan(Some(n)) => write!(f, "vulkan:{n}"),
        }
    }
}

/// A line of `raggio devices`.
#[derive(Clone, Debug)]
pub struct DeviceInfo {
    /// What `--device` takes.
    pub id: String,
    /// The processor.
    pub name: String,
    /// Its kind, in a word.
    pub kind: &'static str,
    /// What drives it.
    pub driver: String,
    /// Its memory in bytes; `None` if unknown.
    pub memory_bytes: Option<u64>,
    /// What it lacks to run the kernels.
    pub missing: Vec<String>,
}

/// All devices of this machine, and why Vulkan has none if it cannot be used.
pub fn devices() -> (Vec<DeviceInfo>, Option<DeviceError>) {
    let mut found = vec![CpuDevice::info()];
    let listed = Instance::new(false).and_then(|instance| instance.devices());
    match listed {
        Ok(physical) => {
            found.extend(physical.into_iter().map(|p| DeviceInfo {
                id: format!("vulkan:{}", p.index),
                name: p.name,
                kind: p.kind.name(),
                driver: p.driver,
                memory_bytes: Some(p.memory_bytes),
                missing: p.missing,
            }));
            (found, None)
        }
        Err(error) => (found, Some(error.into())),
    }
}

/// How devices are opened.
#[derive(Clone, Copy, Debug, Default)]
pub struct OpenOptions {
    /// How the CPU is used.
    pub cpu: CpuOptions,
    /// Turns Vulkan's validation layers on.
    pub validate: bool,
}

/// Opens the device that `choice` asks for.
pub fn open(choice: DeviceChoice, options: OpenOptions) -> Result<Box<dyn Device>, DeviceError> {
    let cpu = || -> Result<Box<dyn Device>, DeviceError> { Ok(Box::new(CpuDevice::new(options.cpu)?)) };
    match choice {
        DeviceChoice::Cpu => cpu(),
        DeviceChoice::Vulkan(number) => Ok(Box::new(open_vulkan(number, options.validate)?)),
        DeviceChoice::Auto => match open_gpu(options.validate) {
            Some(gpu) => Ok(Box::new(gpu)),
            None => cpu(),
        },
    }
}

/// The first usable GPU, by kind; software devices are left to those who ask for them.
fn open_gpu(validate: bool) -> Option<VulkanDevice> {
    let instance = Instance::new(validate).ok()?;
    let physical = instance.devices().ok()?;
    [DeviceKind::Discrete, DeviceKind::Integrated].into_iter().find_map(|kind| {
        physical
            .iter()
            .filter(|p| p.kind == kind && p.missing.is_empty())
            .find_map(|p| VulkanDevice::new(&instance, p).ok())
    })
}

fn open_vulkan(number: Option<usize>, validate: bool) -> Result<VulkanDevice, DeviceError> {
    let instance = Instance::new(validate)?;
    let physical = instance.devices()?;
    let chosen = match number {
        Some(n) => physical.get(n),
        None => physical.iter().filter(|p| p.missing.is_empty()).min_by_key(|p| match p.kind {
            DeviceKind::Discrete => 0,
            DeviceKind::Integrated => 1,
            DeviceKind::Virtual => 2,
            DeviceKind::Other => 3,
            DeviceKind::Software => 4,
        }),
    };
    let chosen = chosen.ok_or_else(|| {
        DeviceError::NotFound(match number {
            Some(n) => {
                format!(
                    "there is no Vulkan device {n}: this machine has {}; `raggio devices` lists them",
                    physical.len()
                )
            }
            None => "no Vulkan device of this machine can run the kernels: `raggio devices` says why".into(),
        })
    })?;
    VulkanDevice::new(&instance, chosen)
}
