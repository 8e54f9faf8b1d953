use std::ffi::CStr;
use std::mem::ManuallyDrop;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};

use ash::{khr, vk};
use gpu_allocator::AllocationSizes;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};

use crate::error::{During, VulkanError};
use crate::faults::Faults;
use crate::instance::PhysicalDevice;
use crate::structure;

/// Bytes of the device's memory that are taken at once, to be given out in parts.
const DEVICE_BLOCK_BYTES: u64 = 256 << 20;
/// Bytes of the host's memory that are taken so: drivers take long over it.
const HOST_BLOCK_BYTES: u64 = 32 << 20;

/// A device in use, with one compute queue.
pub struct Device {
    pub(crate) raw: ash::Device,
    pub(crate) physical: PhysicalDevice,
    // The allocator is freed by hand in `Drop`, before the device.
    allocator: ManuallyDrop<Arc<Mutex<Allocator>>>,
    pub(crate) faults: Arc<Faults>,
    /// Whether memory can be handed to other interfaces.
    exports: bool,
    /// Functions of structures, where kernels may ask hardware for rays.
    pub(crate) structures: Option<khr::acceleration_structure::Device>,
    /// Limit on the bytes that a descriptor refers to, set by [`Device::pretend_small_bindings`].
    most_binding_bytes: AtomicU64,
    /// Limit on the bytes that are free, set by [`Device::pretend_small_memory`].
    most_free_bytes: AtomicU64,
    // Only one submission runs at a time: the lock is held while it is recorded and waited for.
    pub(crate) queue: Mutex<Queue>,
}

pub(crate) struct Queue {
    pub(crate) raw: vk::Queue,
    pub(crate) pool: vk::CommandPool,
    pub(crate) commands: vk::CommandBuffer,
    pub(crate) fence: vk::Fence,
}

impl Device {
    /// Opens `physical`; fails if it lacks what the kernels need.
    pub fn new(physical: &PhysicalDevice) -> Result<Arc<Self>, VulkanError> {
        Self::open(physical, false, Arc::default())
    }

    /// Opens `physical` for kernels that ask hardware for rays; fails if it lacks what they need.
    pub fn with_ray_queries(physical: &PhysicalDevice) -> Result<Arc<Self>, VulkanError> {
        Self::open(physical, true, Arc::default())
    }

    /// Opens the device once more: one that was lost stays so.
    pub fn reopen(&self) -> Result<Arc<Self>, VulkanError> {
        self.faults.reopen()?;
        Self::open(&self.physical, self.has_ray_queries(), self.faults.clone())
    }

    fn open(physical: &PhysicalDevice, queries: bool, faults: Arc<Faults>) -> Result<Arc<Self>, VulkanError> {
        let instance = physical.instance();
        let unfit = |missing| Err(VulkanError::Unfit { name: physical.name.clone(), missing });
        if !physical.missing.is_empty() {
            return unfit(physical.missing.join(", "));
        }
        if queries && !physical.has_ray_queries() {
            return unfit("VK_KHR_ray_query".into());
        }
        let priorities = [1.0];
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(physical.queue_family)
            .queue_priorities(&priorities)];
        let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default()
            .scalar_block_layout(true)
            .buffer_device_address(physical.addresses);
        // SAFETY: `physical` came from `instance`.
        let known = unsafe { instance.raw.enumerate_device_extension_properties(physical.handle) }
            .during("vkEnumerateDeviceExtensionProperties")?;
        let offered = |name: &CStr| known.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
        // The first has to be asked for wherever it is offered.
        let mut extensions = vec![c"VK_KHR_portability_subset"];
        if instance.presents {
            extensions.push(khr::swapchain::NAME);
        }
        let exports = offered(khr::external_memory_fd::NAME);
        extensions.push(khr::external_memory_fd::NAME);
        if queries {
            extensions.extend(structure::EXTENSIONS);
        }
        let extensions: Vec<_> = extensions.into_iter().filter(|name| offered(name)).map(CStr::as_ptr).collect();
        let mut structures = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default().acceleration_structure(true);
        let mut ray_queries = vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true);
        let mut info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_extension_names(&extensions)
            .push_next(&mut vulkan12);
        if queries {
            info = info.push_next(&mut structures).push_next(&mut ray_queries);
        }
        // SAFETY: all that `info` points to lives until the call returns; its features and queue were found above.
        let raw = unsafe { instance.raw.create_device(physical.handle, &info, None) }.during("vkCreateDevice")?;

        let equip = || {
            let allocator = Allocator::new(&AllocatorCreateDesc {
                instance: instance.raw.clone(),
                device: raw.clone(),
                physical_device: physical.handle,
                debug_settings: Default::default(),
                buffer_device_address: physical.addresses,
                allocation_sizes: AllocationSizes::new(DEVICE_BLOCK_BYTES, HOST_BLOCK_BYTES),
            })
            .map_err(|e| VulkanError::OutOfMemory(e.to_string()))?;
            Ok((allocator, Queue::new(&raw, physical.queue_family)?))
        };
        match equip() {
            Ok((allocator, queue)) => Ok(Arc::new(Self {
                structures: queries.then(|| khr::acceleration_structure::Device::new(&instance.raw, &raw)),
                raw,
                physical: physical.clone(),
                allocator: ManuallyDrop::new(Arc::new(Mutex::new(allocator))),
                faults,
                exports,
                most_binding_bytes: AtomicU64::new(u64::MAX),
                most_free_bytes: AtomicU64::new(u64::MAX),
                queue: Mutex::new(queue),
            })),
            Err(error) => {
                // SAFETY: nothing made from the device is left.
                unsafe { raw.destroy_device(None) };
                Err(error)
            }
        }
    }

    /// Description of the device by its driver.
    pub fn physical(&self) -> &PhysicalDevice {
        &self.physical
    }

    /// Most bytes of a buffer that a descriptor can refer to.
    pub fn max_binding_bytes(&self) -> u64 {
        u64::from(self.physical.limits.max_storage_buffer_range)
            .min(self.physical.max_buffer_size)
            .min(self.most_binding_bytes.load(Ordering::Relaxed))
    }

    /// Whether memory can be handed to other interfaces.
    pub fn exports_memory(&self) -> bool {
        self.exports
    }

    /// Whether kernels can reach buffers by address.
    pub fn has_addresses(&self) -> bool {
        self.physical.addresses
    }

    /// Whether kernels can ask hardware for what a ray meets.
    pub fn has_ray_queries(&self) -> bool {
        self.structures.is_some()
    }

    /// Fails, with both numbers in the error, if `what`, which takes `needed` bytes, does not fit the memory that is
    /// free.
    pub fn check_room(&self, what: &str, needed: u64) -> Result<(), VulkanError> {
        let free = self.physical.free_bytes().min(self.most_free_bytes.load(Ordering::Relaxed));
        if needed <= free {
            return Ok(());
        }
        Err(VulkanError::NoRoom { what: what.into(), name: self.physical.name.clone(), needed, free })
    }

    pub(crate) fn too_large(&self, what: &str, needed: u64, limit: u64) -> VulkanError {
        VulkanError::TooLarge { what: what.into(), name: self.physical.name.clone(), needed, limit }
    }

    /// Bytes of the device's memory in use, as far as this program goes.
    pub fn allocated_bytes(&self) -> u64 {
        self.allocator().generate_report().total_allocated_bytes
    }

    /// Makes descriptors refer to no more than `bytes` of a buffer from now on: how devices with small limits fare can
    /// be tried out on others.
    pub fn pretend_small_bindings(&self, bytes: u64) {
        self.most_binding_bytes.store(bytes, Ordering::Relaxed);
    }

    /// Makes no more than `bytes` of memory count as free from now on: how devices with little memory fare can be tried out on
    /// others.
    pub fn pretend_small_memory(&self, bytes: u64) {
        self.most_free_bytes.store(bytes, Ordering::Relaxed);
    }

    /// Allocator for a library that allocates by itself; to be given back before the device goes.
    #[cfg(feature = "window")]
    pub(crate) fn shared_allocator(&self) -> Arc<Mutex<Allocator>> {
        Arc::clone(&self.allocator)
    }

    pub(crate) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        self.allocator.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

impl Queue {
    fn new(device: &ash::Device, family: u32) -> Result<Self, VulkanError> {
        let pool_info = vk::CommandPoolCreateInfo::default().queue_family_index(family);
        // SAFETY: the device was created with one queue of this family; what is made here is destroyed in
        // `Device::drop`, or with its pool where a later call fails.
        unsafe {
            let raw = device.get_device_queue(family, 0);
            let pool = device.create_command_pool(&pool_info, None).during("vkCreateCommandPool")?;
            let allocate = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            let rest = || {
                let commands = device.allocate_command_buffers(&allocate).during("vkAllocateCommandBuffers")?[0];
                let fence = device.create_fence(&vk::FenceCreateInfo::default(), None).during("vkCreateFence")?;
                Ok(Self { raw, pool, commands, fence })
            };
            rest().inspect_err(|_| device.destroy_command_pool(pool, None))
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        let queue = self.queue.get_mut().unwrap_or_else(|poisoned| poisoned.into_inner());
        // SAFETY: buffers and pipelines keep the device alive, so none is left; waiting makes sure that the GPU is
        // done even after a submission failed halfway. The allocator is dropped once, here.
        unsafe {
            let _ = self.raw.device_wait_idle();
            self.raw.destroy_fence(queue.fence, None);
            self.raw.destroy_command_pool(queue.pool, None);
            ManuallyDrop::drop(&mut self.allocator);
            self.raw.destroy_device(None);
        }
    }
}
