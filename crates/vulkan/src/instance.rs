use std::ffi::{CStr, c_char, c_void};
use std::io::Write;
use std::sync::{Arc, Mutex};

use ash::{ext, khr, vk};
#[cfg(feature = "window")]
use raw_window_handle::RawDisplayHandle;

use crate::cache::Compiler;
use crate::error::{During, VulkanError};
use crate::structure::StructureLimits;

/// Number of storage buffers that a kernel may bind at once on any device that counts as fit.
pub const STORAGE_BUFFERS: u32 = 32;

/// Kind of processor behind a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceKind {
    /// Graphics card of its own.
    Discrete,
    /// GPU that is part of the processor.
    Integrated,
    /// GPU seen through a virtual machine.
    Virtual,
    /// Processor itself: for tests.
    Software,
    /// Device of any other kind.
    Other,
}

impl DeviceKind {
    /// Name of the kind in one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Discrete => "discrete",
            Self::Integrated => "integrated",
            Self::Virtual => "virtual",
            Self::Software => "software",
            Self::Other => "other",
        }
    }
}

/// Description of a device by its driver.
#[derive(Clone)]
pub struct PhysicalDevice {
    instance: Arc<Instance>,
    pub(crate) handle: vk::PhysicalDevice,
    pub(crate) queue_family: u32,
    pub(crate) limits: vk::PhysicalDeviceLimits,
    pub(crate) max_buffer_size: u64,
    pub(crate) compiler: Compiler,
    /// Place in the driver's list: the N of `vulkan:N`.
    pub index: usize,
    /// Name of the device.
    pub name: String,
    /// Name and version of the driver.
    pub driver: String,
    /// Kind of processor behind the device.
    pub kind: DeviceKind,
    /// UUID of the device, which other interfaces have too.
    pub uuid: [u8; 16],
    /// LUID of the device, which Windows has.
    pub luid: Option<[u8; 8]>,
    /// Bytes of the device's own memory.
    pub memory_bytes: u64,
    /// Whether kernels can reach buffers by address, and so more of them than `max_storage_buffer_range`.
    pub(crate) addresses: bool,
    /// Limits of structures that hardware traces rays by; `None` where kernels cannot ask for rays.
    pub(crate) structures: Option<StructureLimits>,
    /// Whether the device can draw panels, not only compute.
    pub draws: bool,
    /// Features that are needed and the device lacks; it is usable if there is none.
    pub missing: Vec<String>,
    /// Driver to install in place of one that is known not to compile the kernels, though it draws.
    pub outdated: Option<String>,
}

impl PhysicalDevice {
    /// Connection to the loader through which the device was found.
    pub fn instance(&self) -> &Arc<Instance> {
        &self.instance
    }

    /// Device and driver, as far as what the driver compiles depends on them.
    pub fn compiler(&self) -> Compiler {
        self.compiler
    }

    /// Whether kernels can ask hardware for what a ray meets: `VK_KHR_ray_query`.
    pub fn has_ray_queries(&self) -> bool {
        self.structures.is_some()
    }

    /// What the device lacks to run the kernels; it can if there is nothing.
    pub fn lacks(&self) -> Vec<String> {
        self.missing.iter().chain(&self.outdated).cloned().collect()
    }
}

/// Connection to the Vulkan loader.
pub struct Instance {
    pub(crate) raw: ash::Instance,
    debug: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    // The messenger holds the list's address.
    messages: Box<Mutex<Vec<String>>>,
    /// Whether windows can be drawn into.
    pub(crate) presents: bool,
    // The entry unloads the loader's library, so it goes last.
    pub(crate) entry: ash::Entry,
}

impl Instance {
    /// Connects to the loader; `validate` turns on the validation layers, with synchronization validation. Fails
    /// without a loader or driver, or without the layers.
    pub fn new(validate: bool) -> Result<Arc<Self>, VulkanError> {
        Self::create(validate, &[])
    }

    /// Connects to the loader, able to draw into windows of `display`.
    #[cfg(feature = "window")]
    pub fn for_windows(validate: bool, display: RawDisplayHandle) -> Result<Arc<Self>, VulkanError> {
        let extensions = ash_window::enumerate_required_extensions(display).map_err(|_| VulkanError::NoWindows)?;
        Self::create(validate, extensions)
    }

    fn create(validate: bool, for_windows: &[*const c_char]) -> Result<Arc<Self>, VulkanError> {
        // SAFETY: the Vulkan loader is a well-behaved library; nothing of it is used after `entry` is dropped.
        let entry = unsafe { ash::Entry::load() }.map_err(|_| VulkanError::NoLoader)?;
        let layer = c"VK_LAYER_KHRONOS_validation";
        if validate {
            // SAFETY: no arguments; the result is owned.
            let layers =
                unsafe { entry.enumerate_instance_layer_properties() }.during("vkEnumerateInstanceLayerProperties")?;
            if !layers.iter().any(|l| l.layer_name_as_c_str() == Ok(layer)) {
                return Err(VulkanError::NoValidationLayers);
            }
        }
        // SAFETY: as above.
        let known = unsafe { entry.enumerate_instance_extension_properties(None) }
            .during("vkEnumerateInstanceExtensionProperties")?;
        let has = |name: &CStr| known.iter().any(|e| e.extension_name_as_c_str() == Ok(name));

        let layers = if validate { vec![layer.as_ptr()] } else { vec![] };
        let mut extensions = for_windows.to_vec();
        // SAFETY: the names are string constants of `ash`.
        if for_windows.iter().any(|&name| !has(unsafe { CStr::from_ptr(name) })) {
            return Err(VulkanError::NoWindows);
        }
        let mut flags = vk::InstanceCreateFlags::empty();
        if has(khr::portability_enumeration::NAME) {
            // Shows devices such as Apple's, which leave out parts of Vulkan that raggio does not use.
            extensions.push(khr::portability_enumeration::NAME.as_ptr());
            flags |= vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR;
        }
        if validate {
            extensions.push(ext::debug_utils::NAME.as_ptr());
        }
        let application = vk::ApplicationInfo::default().application_name(c"raggio").api_version(vk::API_VERSION_1_2);
        let checks = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut validation = vk::ValidationFeaturesEXT::default().enabled_validation_features(&checks);
        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&application)
            .enabled_layer_names(&layers)
            .enabled_extension_names(&extensions)
            .flags(flags);
        if validate {
            info = info.push_next(&mut validation);
        }
        // SAFETY: all that `info` points to lives until the call returns.
        let raw = unsafe { entry.create_instance(&info, None) }.during("vkCreateInstance")?;

        let messages = Box::new(Mutex::new(Vec::new()));
        let presents = !for_windows.is_empty();
        // From here on `Drop` cleans up.
        let mut instance = Self { raw, debug: None, messages, presents, entry };
        if validate {
            instance.debug = Some(listen(&instance.entry, &instance.raw, &instance.messages)?);
        }
        Ok(Arc::new(instance))
    }

    /// Lists all devices, in the driver's order.
    pub fn devices(self: &Arc<Self>) -> Result<Vec<PhysicalDevice>, VulkanError> {
        // SAFETY: the instance is alive.
        let handles = unsafe { self.raw.enumerate_physical_devices() }.during("vkEnumeratePhysicalDevices")?;
        Ok(handles.into_iter().enumerate().map(|(index, handle)| self.describe(index, handle)).collect())
    }

    /// Messages of the validation layers so far; empty when all is well.
    pub fn validation_messages(&self) -> Vec<String> {
        self.messages.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).clone()
    }

    fn describe(self: &Arc<Self>, index: usize, handle: vk::PhysicalDevice) -> PhysicalDevice {
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut maintenance = vk::PhysicalDeviceMaintenance3Properties::default();
        let mut identity = vk::PhysicalDeviceIDProperties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default()
            .push_next(&mut driver)
            .push_next(&mut maintenance)
            .push_next(&mut identity);
        let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default();
        let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut vulkan12);
        // SAFETY: `handle` came from this instance. Devices of Vulkan 1.0 ignore chained structures they do not know.
        let (memory, queues) = unsafe {
            self.raw.get_physical_device_properties2(handle, &mut properties);
            self.raw.get_physical_device_features2(handle, &mut features);
            (
                self.raw.get_physical_device_memory_properties(handle),
                self.raw.get_physical_device_queue_family_properties(handle),
            )
        };
        let properties = properties.properties;

        // A queue family that can draw too is taken, if there is one: a window's panels are drawn on it.
        let able = |flags| queues.iter().position(|q| q.queue_flags.contains(flags));
        let drawing = able(vk::QueueFlags::COMPUTE | vk::QueueFlags::GRAPHICS);
        let queue_family = drawing.or_else(|| able(vk::QueueFlags::COMPUTE));
        let mut missing = Vec::new();
        if properties.api_version < vk::API_VERSION_1_2 {
            missing.push("Vulkan 1.2".into());
        }
        if vulkan12.scalar_block_layout == vk::FALSE {
            missing.push("scalarBlockLayout".into());
        }
        if queue_family.is_none() {
            missing.push("a compute queue".into());
        }
        if properties.limits.max_per_stage_descriptor_storage_buffers < STORAGE_BUFFERS {
            missing.push(format!("{STORAGE_BUFFERS} storage buffers in a shader"));
        }
        PhysicalDevice {
            instance: self.clone(),
            handle,
            queue_family: queue_family.unwrap_or(0) as u32,
            limits: properties.limits,
            max_buffer_size: maintenance.max_memory_allocation_size,
            compiler: Compiler::of(&properties),
            index,
            name: text(properties.device_name_as_c_str()),
            driver: format!("{} {}", text(driver.driver_name_as_c_str()), text(driver.driver_info_as_c_str()))
                .trim()
                .to_owned(),
            kind: match properties.device_type {
                vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
                vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
                vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
                vk::PhysicalDeviceType::CPU => DeviceKind::Software,
                _ => DeviceKind::Other,
            },
            uuid: identity.device_uuid,
            luid: (identity.device_luid_valid == vk::TRUE).then_some(identity.device_luid),
            memory_bytes: own_heaps(&memory).map(|(_, heap)| heap.size).sum(),
            addresses: vulkan12.buffer_device_address == vk::TRUE,
            structures: StructureLimits::of(&self.raw, handle).filter(|_| vulkan12.buffer_device_address == vk::TRUE),
            draws: drawing.is_some(),
            missing,
            outdated: outdated(&driver),
        }
    }
}

/// Driver to install in place of `driver`, if that is known not to compile the kernels.
fn outdated(driver: &vk::PhysicalDeviceDriverProperties) -> Option<String> {
    let is_old = driver.driver_id == vk::DriverId::MESA_LLVMPIPE && is_old_mesa(&text(driver.driver_info_as_c_str()));
    is_old.then(|| "Mesa 23 or newer (Debian 12: apt install -t bookworm-backports mesa-vulkan-drivers)".into())
}

/// Whether lavapipe of this version, `Mesa 22.3.6 (LLVM 15.0.6)`, fails to compile the kernels.
fn is_old_mesa(info: &str) -> bool {
    let major = info.strip_prefix("Mesa ").and_then(|rest| rest.split('.').next());
    major.and_then(|major| major.parse().ok()).is_some_and(|major: u32| major < 23)
}

impl PhysicalDevice {
    /// Free bytes of the device's own memory, as far as the driver tells; else all of it.
    pub(crate) fn free_bytes(&self) -> u64 {
        let mut budget = vk::PhysicalDeviceMemoryBudgetPropertiesEXT::default();
        let mut memory = vk::PhysicalDeviceMemoryProperties2::default().push_next(&mut budget);
        // SAFETY: the handle came from this instance. Drivers ignore chained structures they do not know.
        unsafe { self.instance.raw.get_physical_device_memory_properties2(self.handle, &mut memory) };
        let memory = memory.memory_properties;
        // A driver that does not know leaves zeros.
        let free = |(i, heap): (usize, &vk::MemoryHeap)| match budget.heap_budget[i] {
            0 => heap.size,
            bytes => bytes.saturating_sub(budget.heap_usage[i]),
        };
        own_heaps(&memory).map(free).sum()
    }
}

/// Heaps of the device's own memory, by index.
fn own_heaps(memory: &vk::PhysicalDeviceMemoryProperties) -> impl Iterator<Item = (usize, &vk::MemoryHeap)> {
    let own = |(_, heap): &(usize, &vk::MemoryHeap)| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL);
    memory.memory_heaps_as_slice().iter().enumerate().filter(own)
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: every device keeps its instance alive, so none is left; the messenger goes before the instance.
        unsafe {
            if let Some((loader, messenger)) = &self.debug {
                loader.destroy_debug_utils_messenger(*messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

fn text(name: Result<&CStr, std::ffi::FromBytesUntilNulError>) -> String {
    name.map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Collects the layers' warnings and errors in `messages`, and prints them on standard error.
fn listen(
    entry: &ash::Entry,
    instance: &ash::Instance,
    messages: &Mutex<Vec<String>>,
) -> Result<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT), VulkanError> {
    let loader = ext::debug_utils::Instance::new(entry, instance);
    let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR)
        .message_type(
            vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION
                | vk::DebugUtilsMessageTypeFlagsEXT::GENERAL
                | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE,
        )
        .pfn_user_callback(Some(on_message))
        .user_data(std::ptr::from_ref(messages).cast_mut().cast());
    // SAFETY: `messages` is boxed and outlives the messenger (see `Drop`); the callback has the right signature.
    let messenger =
        unsafe { loader.create_debug_utils_messenger(&info, None) }.during("vkCreateDebugUtilsMessengerEXT")?;
    Ok((loader, messenger))
}

unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    kinds: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes valid data, and `user` is the mutex given in `listen`.
    let (message, messages) = unsafe {
        let text = (*data).p_message;
        let text = if text.is_null() { String::new() } else { CStr::from_ptr(text).to_string_lossy().into_owned() };
        (text, &*user.cast::<Mutex<Vec<String>>>())
    };
    // The loader itself reports, as GENERAL, drivers on this machine that it cannot use: no fault of ours.
    if kinds != vk::DebugUtilsMessageTypeFlagsEXT::GENERAL {
        // A panic must not leave through the layers, and printing to a closed stream is one.
        let _ = writeln!(std::io::stderr(), "vulkan validation: {message}");
        messages.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push(message);
    }
    vk::FALSE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lavapipe_is_told_by_its_version() {
        for (info, old) in [
            ("Mesa 22.3.6 (LLVM 15.0.6)", true),
            ("Mesa 23.0.0-devel", false),
            ("Mesa 25.0.7-2~bpo12+1 (LLVM 15.0.6)", false),
            ("", false),
            ("550.54.15", false),
        ] {
            assert_eq!(is_old_mesa(info), old, "{info}");
        }
    }
}
