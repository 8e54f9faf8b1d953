//! Devices of this machine, and the choice among them.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;

use raggio_vulkan::{DeviceKind, Instance, PhysicalDevice, VulkanError};

use crate::devices::cpu::{CpuDevice, CpuOptions};
use crate::devices::device::{Device, DeviceError, DeviceInfo};
use crate::devices::group::DeviceGroup;
use crate::devices::tracer::Tracer;
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

/// Devices as users ask for them: one, several separated by commas, which share each picture, or `all`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DeviceSelection {
    /// All GPUs, and the CPU.
    All,
    /// These devices, each once; at least one.
    Listed(Vec<DeviceChoice>),
}

impl DeviceSelection {
    /// The device that is asked for, if it is only one.
    pub fn single(&self) -> Option<DeviceChoice> {
        match self {
            Self::Listed(choices) if choices.len() == 1 => Some(choices[0]),
            _ => None,
        }
    }
}

impl From<DeviceChoice> for DeviceSelection {
    fn from(choice: DeviceChoice) -> Self {
        Self::Listed(vec![choice])
    }
}

impl FromStr for DeviceSelection {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "all" {
            return Ok(Self::All);
        }
        let choices = text.split(',').map(str::parse).collect::<Result<Vec<DeviceChoice>, String>>();
        let choices = choices.map_err(|right| format!("{right}; several separated by commas, or all"))?;
        for (i, choice) in choices.iter().enumerate() {
            if choices[..i].contains(choice) {
                return Err(format!("{choice} is there twice"));
            }
            if *choice == DeviceChoice::Auto && choices.len() > 1 {
                return Err("auto is one device: name each of several, or give all".into());
            }
        }
        Ok(Self::Listed(choices))
    }
}

impl fmt::Display for DeviceSelection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::All => f.write_str("all"),
            Self::Listed(choices) => {
                f.write_str(&choices.iter().map(ToString::to_string).collect::<Vec<_>>().join(","))
            }
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
                has_ray_queries: p.has_ray_queries(),
                tracer: if Tracer::Auto.asks(&p) { Tracer::Hardware } else { Tracer::Software },
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
    /// Who finds what rays meet on GPUs.
    pub tracer: Tracer,
    /// Whether Vulkan's validation layers are on.
    pub validate: bool,
    /// A connection to Vulkan that exists already, such as a window's; it has its own validation.
    pub instance: Option<Arc<Instance>>,
    /// Folder in which compiled kernels are kept from one start of a program to the next, such as [`cache_folder`]'s; `None`:
    /// drivers compile them each time.
    ///
    /// [`cache_folder`]: crate::cache_folder
    pub cache: Option<PathBuf>,
    /// Whether software Vulkan has general kernels for simple scenes, compiled once for all, instead of those that know what a
    /// scene has: for who renders many small ones, such as tests. Of other scenes general kernels would take minutes.
    pub general_in_software: bool,
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
/// A [`DeviceError`] when there is no such device, it cannot run the kernels, it has not the hardware that is asked for, or
/// validation cannot be had.
pub fn open(choice: DeviceChoice, options: OpenOptions, warn: impl Fn(&str)) -> Result<Box<dyn Device>, DeviceError> {
    let gpu = match choice {
        DeviceChoice::Cpu => None,
        DeviceChoice::Vulkan(number) => Some(open_vulkan(number, &options)?),
        DeviceChoice::Auto => usable_gpus(&options, warn)?.next(),
    };
    match gpu {
        Some(gpu) => Ok(Box::new(gpu)),
        None if options.tracer == Tracer::Hardware => Err(without_hardware(choice)),
        None => Ok(Box::new(CpuDevice::new(options.cpu)?)),
    }
}

/// Error of a choice in which nothing traces rays by hardware, though that is asked for.
fn without_hardware(choice: impl fmt::Display) -> DeviceError {
    DeviceError::NotFound(format!(
        "nothing that is {choice} here traces rays by hardware: `raggio devices` says what does, and `--tracer auto` does without"
    ))
}

/// Opens the devices that `selection` asks for: as one that shares pictures among them if they are several. `warn` hears why
/// `auto` and `all` pass over a GPU.
///
/// # Errors
/// The errors of [`open`]; also where two words name one device.
pub fn open_all(
    selection: &DeviceSelection,
    options: &OpenOptions,
    warn: impl Fn(&str),
) -> Result<Box<dyn Device>, DeviceError> {
    let mut devices: Vec<Box<dyn Device>> = vec![];
    match selection {
        DeviceSelection::All => {
            for gpu in usable_gpus(options, &warn)? {
                devices.push(Box::new(gpu));
            }
            match options.tracer {
                // The CPU has no such hardware.
                Tracer::Hardware if devices.is_empty() => return Err(without_hardware(selection)),
                Tracer::Hardware => {}
                _ => devices.push(Box::new(CpuDevice::new(options.cpu)?)),
            }
        }
        DeviceSelection::Listed(choices) => {
            for choice in choices {
                let device = open(*choice, options.clone(), &warn)?;
                if devices.iter().any(|other| other.name() == device.name()) {
                    return Err(DeviceError::NotFound(format!(
                        "{choice} is {}, which is named already",
                        device.name()
                    )));
                }
                devices.push(device);
            }
        }
    }
    Ok(if devices.len() == 1 { devices.remove(0) } else { Box::new(DeviceGroup::new(devices)) })
}

/// GPUs that can be used, by kind, the fastest kind first, each opened when it is asked for; software devices are left to
/// those who ask for them. No Vulkan is no error here, but validation that was asked for and cannot be had is.
fn usable_gpus(options: &OpenOptions, warn: impl Fn(&str)) -> Result<impl Iterator<Item = VulkanDevice>, DeviceError> {
    let mut physical = match options.physical_devices() {
        Err(error @ VulkanError::NoValidationLayers) => return Err(error.into()),
        other => other.unwrap_or_default(),
    };
    physical.retain(|gpu| matches!(gpu.kind, DeviceKind::Discrete | DeviceKind::Integrated));
    physical.sort_by_key(|gpu| gpu.kind != DeviceKind::Discrete);
    let (cache, tracer) = (options.cache.clone(), options.tracer);
    let open = move |gpu: PhysicalDevice| {
        VulkanDevice::new(&gpu, tracer, cache.as_deref(), false)
            .map_err(|error| warn(&format!("{} is not used: {error}", gpu.name)))
            .ok()
    };
    Ok(physical.into_iter().filter_map(open))
}

fn open_vulkan(number: Option<usize>, options: &OpenOptions) -> Result<VulkanDevice, DeviceError> {
    let physical = options.physical_devices()?;
    let asked = |p: &PhysicalDevice| options.tracer != Tracer::Hardware || p.has_ray_queries();
    let chosen = match number {
        Some(n) => physical.get(n),
        None => physical.iter().filter(|p| p.lacks().is_empty() && asked(p)).min_by_key(|p| match p.kind {
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
            None if options.tracer == Tracer::Hardware => return without_hardware("a Vulkan device"),
            None => "no Vulkan device of this machine can run the kernels: `raggio devices` says why".into(),
        })
    })?;
    VulkanDevice::new(chosen, options.tracer, options.cache.as_deref(), options.general_in_software)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn selections_are_words_and_lists_of_words() {
        let selection = |text: &str| text.parse::<DeviceSelection>();
        for text in ["all", "auto", "cpu", "vulkan", "vulkan:3", "vulkan:0,vulkan:1,cpu"] {
            assert_eq!(selection(text).expect("it is right").to_string(), text);
        }
        assert_eq!(selection("vulkan:3").expect("it is right").single(), Some(DeviceChoice::Vulkan(Some(3))));
        assert_eq!(selection("cpu,vulkan").expect("it is right").single(), None);
        for (text, error) in [
            (
                "gpu",
                "give auto, cpu, vulkan or vulkan:N, with N as in `raggio devices`; several separated by commas, or all",
            ),
            (
                "cpu,",
                "give auto, cpu, vulkan or vulkan:N, with N as in `raggio devices`; several separated by commas, or all",
            ),
            ("cpu,vulkan:0,cpu", "cpu is there twice"),
            ("cpu,auto", "auto is one device: name each of several, or give all"),
        ] {
            assert_eq!(selection(text), Err(error.to_owned()));
        }
    }
}
