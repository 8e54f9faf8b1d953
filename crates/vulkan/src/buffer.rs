use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use crate::device::Device;
use crate::error::{During, VulkanError};

/// Where a buffer lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Location {
    /// In the device's memory, for kernels.
    Device,
    /// In memory the host writes and the device copies from.
    Upload,
    /// In memory the device copies to and the host reads.
    Readback,
}

/// A run of bytes that kernels and copies can use.
pub struct Buffer {
    pub(crate) raw: vk::Buffer,
    size: u64,
    allocation: Option<Allocation>,
    pub(crate) device: Arc<Device>,
}

impl Buffer {
    /// `size` bytes (at least 1 is taken), undefined until written. `what` names it in errors.
    pub fn new(device: &Arc<Device>, what: &str, size: u64, location: Location) -> Result<Self, VulkanError> {
        let limit = match location {
            Location::Device => device.max_binding_bytes(),
            _ => device.physical.max_buffer_size,
        };
        if size > limit {
            let name = device.physical.name.clone();
            return Err(VulkanError::TooLarge { what: what.into(), name, needed: size, limit });
        }
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        // An empty binding is not allowed: the smallest buffer has 16 bytes.
        let info = vk::BufferCreateInfo::default().size(size.max(16)).usage(usage);
        // SAFETY: the device is alive; `raw` is destroyed below or in `Drop`.
        let raw = unsafe { device.raw.create_buffer(&info, None) }.during("vkCreateBuffer")?;
        // From here on `Drop` cleans up.
        let mut buffer = Self { raw, size, allocation: None, device: device.clone() };

        // SAFETY: `raw` was just created from this device.
        let requirements = unsafe { device.raw.get_buffer_memory_requirements(raw) };
        let allocation = device
            .allocator()
            .allocate(&AllocationCreateDesc {
                name: what,
                requirements,
                location: match location {
                    Location::Device => MemoryLocation::GpuOnly,
                    Location::Upload => MemoryLocation::CpuToGpu,
                    Location::Readback => MemoryLocation::GpuToCpu,
                },
                linear: true,
                allocation_scheme: AllocationScheme::GpuAllocatorManaged,
            })
            .map_err(|e| VulkanError::OutOfMemory(format!("{what}, {size} bytes: {e}")))?;
        let allocation = buffer.allocation.insert(allocation);
        // SAFETY: the allocation was made for this buffer's requirements and is bound once.
        unsafe { device.raw.bind_buffer_memory(raw, allocation.memory(), allocation.offset()) }
            .during("vkBindBufferMemory")?;
        Ok(buffer)
    }

    /// Bytes asked for.
    pub fn size(&self) -> u64 {
        self.size
    }

    pub(crate) fn mapped(&self) -> &[u8] {
        self.allocation.as_ref().and_then(Allocation::mapped_slice).unwrap_or_default()
    }

    pub(crate) fn mapped_mut(&mut self) -> &mut [u8] {
        self.allocation.as_mut().and_then(Allocation::mapped_slice_mut).unwrap_or_default()
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for while the buffers it uses are borrowed, so the GPU is done with it.
        unsafe { self.device.raw.destroy_buffer(self.raw, None) };
        if let Some(allocation) = self.allocation.take() {
            // Freeing fails only for allocations of another allocator.
            let _ = self.device.allocator().free(allocation);
        }
    }
}
