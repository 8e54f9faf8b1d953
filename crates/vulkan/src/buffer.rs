use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use crate::device::Device;
use crate::error::{During, VulkanError};
#[cfg(target_os = "linux")]
use crate::exported;

/// Memory that a buffer lives in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Location {
    /// The device's memory, for kernels.
    Device,
    /// Memory that the host writes and the device copies from.
    Upload,
    /// Memory that the device copies to and the host reads.
    Readback,
    /// The device's memory, for structures that hardware traces rays by.
    Structure,
}

/// A run of bytes that kernels and copies can use.
pub struct Buffer {
    pub(crate) raw: vk::Buffer,
    size: u64,
    what: String,
    addressed: bool,
    allocation: Option<Allocation>,
    /// Memory of the buffer's own, and its bytes, where another interface can be handed it.
    #[cfg(target_os = "linux")]
    exported: Option<(vk::DeviceMemory, u64)>,
    pub(crate) device: Arc<Device>,
}

impl Buffer {
    /// Makes a buffer of `size` bytes (at least 1 is taken), undefined until written. `what` names it in errors; one
    /// larger than the device takes is an error.
    pub fn new(device: &Arc<Device>, what: &str, size: u64, location: Location) -> Result<Self, VulkanError> {
        // A buffer that cannot be reached by address is reached by a descriptor.
        let on_device = matches!(location, Location::Device | Location::Structure);
        let addressed = on_device && device.physical.addresses;
        let limit = match location {
            Location::Device if !addressed => device.max_binding_bytes(),
            _ => device.physical.max_buffer_size,
        };
        if size > limit {
            return Err(device.too_large(what, size, limit));
        }
        let traced = if location == Location::Structure {
            vk::BufferUsageFlags::ACCELERATION_STRUCTURE_STORAGE_KHR
        } else if addressed && device.has_ray_queries() {
            vk::BufferUsageFlags::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR
        } else {
            vk::BufferUsageFlags::empty()
        };
        let mut buffer = Self::create(device, what, size, addressed, vk::BufferCreateInfo::default().usage(traced))?;
        let raw = buffer.raw;

        // SAFETY: `raw` was just created from this device.
        let requirements = unsafe { device.raw.get_buffer_memory_requirements(raw) };
        device.attempt("vkAllocateMemory")?;
        let allocation = device
            .allocator()
            .allocate(&AllocationCreateDesc {
                name: what,
                requirements,
                location: match location {
                    Location::Device | Location::Structure => MemoryLocation::GpuOnly,
                    Location::Upload => MemoryLocation::CpuToGpu,
                    Location::Readback => MemoryLocation::GpuToCpu,
                },
                linear: true,
                allocation_scheme: AllocationScheme::GpuAllocatorManaged,
            })
            .map_err(|e| VulkanError::OutOfMemory(format!("{what}, {size} bytes: {e}")))?;
        let allocation = buffer.allocation.insert(allocation);
        device.attempt("vkBindBufferMemory")?;
        // SAFETY: the allocation was made for this buffer's requirements and is bound once.
        unsafe { device.raw.bind_buffer_memory(raw, allocation.memory(), allocation.offset()) }
            .during("vkBindBufferMemory")?;
        Ok(buffer)
    }

    /// Makes a buffer of the device's memory as [`Buffer::new`] does, which other interfaces to the same device can be
    /// [handed](Self::handle).
    ///
    /// # Panics
    /// If the device does not [export memory](Device::exports_memory).
    #[cfg(target_os = "linux")]
    pub fn shared(device: &Arc<Device>, what: &str, size: u64) -> Result<Self, VulkanError> {
        assert!(device.exports_memory(), "the device exports memory");
        let limit = device.max_binding_bytes();
        if size > limit {
            return Err(device.too_large(what, size, limit));
        }
        device.check_room(what, size)?;
        let mut external = vk::ExternalMemoryBufferCreateInfo::default().handle_types(exported::HANDLE);
        let info = vk::BufferCreateInfo::default().push_next(&mut external);
        let mut buffer = Self::create(device, what, size, device.physical.addresses, info)?;
        let (memory, bytes) = exported::allocate(device, buffer.raw, what, false)?;
        buffer.exported = Some((memory, bytes));
        device.attempt("vkBindBufferMemory")?;
        // SAFETY: the memory was allocated for this buffer and is bound once.
        unsafe { device.raw.bind_buffer_memory(buffer.raw, memory, 0) }.during("vkBindBufferMemory")?;
        Ok(buffer)
    }

    /// Handle by which another interface gets at the memory of a [shared](Self::shared) buffer, of which it owns a share, and
    /// the memory's bytes; `None` of any other buffer.
    #[cfg(target_os = "linux")]
    pub fn handle(&self) -> Result<Option<(std::os::fd::OwnedFd, u64)>, VulkanError> {
        let Some((memory, bytes)) = self.exported else { return Ok(None) };
        Ok(Some((exported::handle(&self.device, memory)?, bytes)))
    }

    /// Makes a buffer without memory; `info` says what else there is to say.
    fn create(
        device: &Arc<Device>,
        what: &str,
        size: u64,
        addressed: bool,
        info: vk::BufferCreateInfo<'_>,
    ) -> Result<Self, VulkanError> {
        let mut usage = info.usage
            | vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::UNIFORM_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        if addressed {
            usage |= vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
        }
        // An empty binding is not allowed: the smallest buffer has 16 bytes.
        let info = info.size(size.max(16)).usage(usage);
        device.attempt("vkCreateBuffer")?;
        // SAFETY: the device is alive, and so is all that `info` points to; `raw` is destroyed in `Drop`.
        let raw = unsafe { device.raw.create_buffer(&info, None) }.during("vkCreateBuffer")?;
        let (what, device) = (what.into(), device.clone());
        Ok(Self {
            raw,
            size,
            what,
            addressed,
            allocation: None,
            #[cfg(target_os = "linux")]
            exported: None,
            device,
        })
    }

    /// Number of bytes asked for.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// Name of the buffer in errors.
    pub(crate) fn what(&self) -> &str {
        &self.what
    }

    /// Address at which kernels find the buffer, if they can reach buffers by address.
    pub(crate) fn address(&self) -> Option<u64> {
        let info = vk::BufferDeviceAddressInfo::default().buffer(self.raw);
        // SAFETY: the feature is enabled and the buffer was made for it.
        self.addressed.then(|| unsafe { self.device.raw.get_buffer_device_address(&info) })
    }

    /// Fails if descriptors cannot refer to the whole buffer.
    pub(crate) fn check_bindable(&self) -> Result<(), VulkanError> {
        let limit = self.device.max_binding_bytes();
        if self.size > limit { Err(self.device.too_large(&self.what, self.size, limit)) } else { Ok(()) }
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
        #[cfg(target_os = "linux")]
        if let Some((memory, _)) = self.exported {
            // SAFETY: as above; whoever has the handle has a share of its own.
            unsafe { self.device.raw.free_memory(memory, None) };
        }
    }
}
