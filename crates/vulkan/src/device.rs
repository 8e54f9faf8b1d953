use std::mem::ManuallyDrop;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use ash::vk;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};

use crate::error::{During, VulkanError};
use crate::instance::{Instance, PhysicalDevice};
use crate::passes::Passes;

/// After this long without an answer, a single submission counts as hung.
const PATIENCE: Duration = Duration::from_secs(600);

/// A device in use, with one compute queue.
pub struct Device {
    pub(crate) raw: ash::Device,
    pub(crate) physical: PhysicalDevice,
    // Freed by hand in `Drop`, before the device.
    allocator: ManuallyDrop<Mutex<Allocator>>,
    // One submission at a time: the lock is held while it is recorded and waited for.
    queue: Mutex<Queue>,
    instance: Arc<Instance>,
}

struct Queue {
    raw: vk::Queue,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
}

impl Device {
    /// Opens `physical`; fails if it lacks what the kernels need.
    pub fn new(instance: &Arc<Instance>, physical: &PhysicalDevice) -> Result<Arc<Self>, VulkanError> {
        if !physical.missing.is_empty() {
            return Err(VulkanError::Unfit { name: physical.name.clone(), missing: physical.missing.join(", ") });
        }
        let priorities = [1.0];
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(physical.queue_family)
            .queue_priorities(&priorities)];
        let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default().scalar_block_layout(true);
        // SAFETY: `physical` came from `instance`.
        let known = unsafe { instance.raw.enumerate_device_extension_properties(physical.handle) }
            .during("vkEnumerateDeviceExtensionProperties")?;
        // To be asked for wherever it is offered.
        let portability = c"VK_KHR_portability_subset";
        let extensions: Vec<_> = known
            .iter()
            .filter(|e| e.extension_name_as_c_str() == Ok(portability))
            .map(|_| portability.as_ptr())
            .collect();
        let info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_extension_names(&extensions)
            .push_next(&mut vulkan12);
        // SAFETY: all that `info` points to lives until the call returns; its features and queue were found above.
        let raw = unsafe { instance.raw.create_device(physical.handle, &info, None) }.during("vkCreateDevice")?;

        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw.clone(),
            device: raw.clone(),
            physical_device: physical.handle,
            debug_settings: Default::default(),
            buffer_device_address: false,
            allocation_sizes: Default::default(),
        })
        .map_err(|e| VulkanError::OutOfMemory(e.to_string()))?;
        let queue = Queue::new(&raw, physical.queue_family)?;
        Ok(Arc::new(Self {
            raw,
            physical: physical.clone(),
            allocator: ManuallyDrop::new(Mutex::new(allocator)),
            queue: Mutex::new(queue),
            instance: instance.clone(),
        }))
    }

    /// What the driver says of it.
    pub fn physical(&self) -> &PhysicalDevice {
        &self.physical
    }

    /// What it was opened from.
    pub fn instance(&self) -> &Arc<Instance> {
        &self.instance
    }

    /// Most bytes that a kernel can see of one buffer.
    pub fn max_binding_bytes(&self) -> u64 {
        u64::from(self.physical.limits.max_storage_buffer_range).min(self.physical.max_buffer_size)
    }

    /// Records passes, submits them and waits until they are done.
    pub fn run<'a>(&'a self, record: impl FnOnce(&mut Passes<'a>)) -> Result<(), VulkanError> {
        let queue = self.queue.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the lock makes this thread the only user of the command buffer, and the last submission was waited
        // for before the lock was released.
        unsafe {
            self.raw.reset_command_pool(queue.pool, vk::CommandPoolResetFlags::empty()).during("vkResetCommandPool")?;
            self.raw.begin_command_buffer(queue.commands, &begin).during("vkBeginCommandBuffer")?;
        }
        let mut passes = Passes::new(&self.raw, queue.commands);
        record(&mut passes);
        passes.finish();

        let commands = [queue.commands];
        let submit = [vk::SubmitInfo::default().command_buffers(&commands)];
        // SAFETY: as above; the resources that the passes use are borrowed by `passes` until after the wait.
        unsafe {
            self.raw.end_command_buffer(queue.commands).during("vkEndCommandBuffer")?;
            self.raw.reset_fences(&[queue.fence]).during("vkResetFences")?;
            self.raw.queue_submit(queue.raw, &submit, queue.fence).during("vkQueueSubmit")?;
            self.raw.wait_for_fences(&[queue.fence], true, PATIENCE.as_nanos() as u64).during("vkWaitForFences")
        }
    }

    pub(crate) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        self.allocator.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

impl Queue {
    fn new(device: &ash::Device, family: u32) -> Result<Self, VulkanError> {
        let pool_info = vk::CommandPoolCreateInfo::default().queue_family_index(family);
        // SAFETY: the device was created with one queue of this family; what is made here is destroyed in
        // `Device::drop`. Should a later call fail, the device itself is about to be abandoned.
        unsafe {
            let raw = device.get_device_queue(family, 0);
            let pool = device.create_command_pool(&pool_info, None).during("vkCreateCommandPool")?;
            let allocate = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            let commands = device.allocate_command_buffers(&allocate).during("vkAllocateCommandBuffers")?[0];
            let fence = device.create_fence(&vk::FenceCreateInfo::default(), None).during("vkCreateFence")?;
            Ok(Self { raw, pool, commands, fence })
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
