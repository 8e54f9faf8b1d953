//! Devices of this machine, and the choice of one.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use raggio_vulkan::{DeviceKind, Instance, PhysicalDevice, VulkanError};

use crate::devices::cpu::{CpuDevice, CpuOptions};
use crate::devices::device::{Device, DeviceError, DeviceInfo};
use crate::devices::vulkan::VulkanDevice;

/// A device as users ask for it: `auto`, `cpu`, `vulkan` or `vulkan:N`.
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

/// All devices of this machine, the CPU first, and the error of Vulkan if it cannot be used.
pub fn devices() -> (Vec<DeviceInfo>, Option<DeviceError>) {
    let mut found = vec![CpuDevice::info()];
    let listed = Instance::new(false).and_then(|instance| instance.devices());
    match listed {
        Ok(physical) => {
            found.extend(physical.into_iter().map(|p| DeviceInfo {
                id: format!("vulkan:{}", p.index),
                missing: p.lacks(),
                name: p.name,
                kind: p.kind.name(),
                driver: p.driver,
                memory_bytes: Some(p.memory_bytes),
            }));
            (found, None)
        }
        Err(error) => (found, Some(error.into())),
    }
}

/// Options for opening a device.
#[derive(Clone, Default)]
pub struct OpenOptions {
    /// Options of the CPU.
    pub cpu: CpuOptions,
    /// Whether Vulkan's validation layers are on.
    pub validate: bool,
    /// A connection to Vulkan that exists already, such as a window's; it has its own validation.
    pub instance: Option<Arc<Instance>>,
}

impl OpenOptions {
    fn physical_devices(&self) -> Result<Vec<PhysicalDevice>, VulkanError> {
        match &self.instance {
            Some(instance) => instance.devices(),
            None => Instance::new(self.validate)?.devices(),
        }
    }
}

/// Opens the device that `choice` asks for. `warn` hears why `auto` passes over a GPU.
///
/// # Errors
/// A [`DeviceError`] when there is no such device, it cannot run the kernels, or validation cannot be had.
pub fn open(choice: DeviceChoice, options: OpenOptions, warn: impl Fn(&str)) -> Result<Box<dyn Device>, DeviceError> {
    let gpu = match choice {
        DeviceChoice::Cpu => None,
        DeviceChoice::Vulkan(number) => Some(open_vulkan(number, &options)?),
        DeviceChoice::Auto => open_gpu(&options, warn)?,
    };
    match gpu {
        Some(gpu) => Ok(Box::new(gpu)),
        None => Ok(Box::new(CpuDevice::new(options.cpu)?)),
    }
}

/// The first usable GPU, by kind; software devices are left to those who ask for them. No Vulkan is no error here, but
/// validation that was asked for and cannot be had is.
fn open_gpu(options: &OpenOptions, warn: impl Fn(&str)) -> Result<Option<VulkanDevice>, DeviceError> {
    let physical = match options.physical_devices() {
        Err(error @ VulkanError::NoValidationLayers) => return Err(error.into()),
        other => other.unwrap_or_default(),
    };
    for kind in [DeviceKind::Discrete, DeviceKind::Integrated] {
        for gpu in physical.iter().filter(|p| p.kind == kind) {
            match VulkanDevice::new(gpu) {
                Ok(device) => return Ok(Some(device)),
                Err(error) => warn(&format!("{} is not used: {error}", gpu.name)),
            }
        }
    }
    Ok(None)
}

fn open_vulkan(number: Option<usize>, options: &OpenOptions) -> Result<VulkanDevice, DeviceError> {
    let physical = options.physical_devices()?;
    let chosen = match number {
        Some(n) => physical.get(n),
        None => physical.iter().filter(|p| p.lacks().is_empty()).min_by_key(|p| match p.kind {
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
    VulkanDevice::new(chosen)
}
