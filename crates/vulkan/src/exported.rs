use std::os::fd::{FromRawFd, OwnedFd};
use std::sync::Arc;

use ash::{khr, vk};

use crate::buffer::Buffer;
use crate::device::Device;
use crate::error::{During, VulkanError};

/// Kind of handles that are made of memory.
pub(crate) const HANDLE: vk::ExternalMemoryHandleTypeFlags = vk::ExternalMemoryHandleTypeFlags::OPAQUE_FD;

/// Memory of the device that another interface to it can be handed, with a buffer in it.
pub struct ExportedBuffer {
    raw: vk::Buffer,
    memory: vk::DeviceMemory,
    size: u64,
    allocated: u64,
    device: Arc<Device>,
}

impl ExportedBuffer {
    /// Makes a buffer of `size` bytes, undefined until written. `what` names it in errors.
    pub fn new(device: &Arc<Device>, what: &str, size: u64) -> Result<Self, VulkanError> {
        device.check_room(what, size)?;
        let mut external = vk::ExternalMemoryBufferCreateInfo::default().handle_types(HANDLE);
        let info = vk::BufferCreateInfo::default()
            .size(size.max(16))
            .usage(vk::BufferUsageFlags::TRANSFER_DST)
            .push_next(&mut external);
        device.attempt("vkCreateBuffer")?;
        // SAFETY: the device is alive; `raw` is destroyed in `Drop`.
        let raw = unsafe { device.raw.create_buffer(&info, None) }.during("vkCreateBuffer")?;
        // From here on `Drop` cleans up; no memory is a null handle, which Vulkan lets be freed.
        let mut buffer = Self { raw, memory: vk::DeviceMemory::null(), size, allocated: 0, device: device.clone() };

        (buffer.memory, buffer.allocated) = allocate(device, raw, what, true)?;
        device.attempt("vkBindBufferMemory")?;
        // SAFETY: the memory was allocated for this buffer and is bound once.
        unsafe { device.raw.bind_buffer_memory(raw, buffer.memory, 0) }.during("vkBindBufferMemory")?;
        Ok(buffer)
    }

    /// Copies all of `from` to `place`, and waits for it.
    ///
    /// # Panics
    /// If it reaches past the end.
    pub fn copy_from(&self, from: &Buffer, place: u64) -> Result<(), VulkanError> {
        assert!(place + from.size() <= self.size);
        self.device.run(|passes| passes.copy_out(from, self.raw, place))
    }

    /// Handle by which another interface gets at the memory; it owns a share of it.
    pub(crate) fn handle(&self) -> Result<OwnedFd, VulkanError> {
        handle(&self.device, self.memory)
    }

    /// Number of bytes asked for.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// UUID of the device, by which other interfaces find it.
    pub(crate) fn device_uuid(&self) -> [u8; 16] {
        self.device.physical.uuid
    }

    /// Bytes that were allocated.
    pub(crate) fn allocated_bytes(&self) -> u64 {
        self.allocated
    }
}

/// Takes memory of the device for the buffer `raw`, from which handles can be made; whoever is `dedicated` has memory for this
/// buffer alone, as some interfaces want it. Returns it with its bytes.
pub(crate) fn allocate(
    device: &Device,
    raw: vk::Buffer,
    what: &str,
    dedicated: bool,
) -> Result<(vk::DeviceMemory, u64), VulkanError> {
    // SAFETY: `raw` was created from this device, which came from this instance.
    let (requirements, properties) = unsafe {
        let instance = &device.physical.instance().raw;
        (
            device.raw.get_buffer_memory_requirements(raw),
            instance.get_physical_device_memory_properties(device.physical.handle),
        )
    };
    let own = vk::MemoryPropertyFlags::DEVICE_LOCAL;
    let kinds = properties.memory_types_as_slice().iter().enumerate();
    let kind = kinds
        .filter(|(i, kind)| requirements.memory_type_bits & (1 << i) != 0 && kind.property_flags.contains(own))
        .map(|(i, _)| i as u32)
        .next();
    let kind = kind.ok_or_else(|| VulkanError::OutOfMemory(what.into()))?;
    let mut alone = vk::MemoryDedicatedAllocateInfo::default().buffer(raw);
    let mut addressed = vk::MemoryAllocateFlagsInfo::default().flags(vk::MemoryAllocateFlags::DEVICE_ADDRESS);
    let mut export = vk::ExportMemoryAllocateInfo::default().handle_types(HANDLE);
    let mut info = vk::MemoryAllocateInfo::default()
        .allocation_size(requirements.size)
        .memory_type_index(kind)
        .push_next(&mut export);
    if dedicated {
        info = info.push_next(&mut alone);
    } else if device.physical.addresses {
        info = info.push_next(&mut addressed);
    }
    device.attempt("vkAllocateMemory")?;
    // SAFETY: all that `info` points to lives until the call returns.
    let memory = unsafe { device.raw.allocate_memory(&info, None) }.during("vkAllocateMemory")?;
    Ok((memory, requirements.size))
}

/// Handle by which another interface gets at `memory`, which was [allocated](allocate) for it; it owns a share of it.
pub(crate) fn handle(device: &Device, memory: vk::DeviceMemory) -> Result<OwnedFd, VulkanError> {
    let loader = khr::external_memory_fd::Device::new(&device.physical.instance().raw, &device.raw);
    let info = vk::MemoryGetFdInfoKHR::default().memory(memory).handle_type(HANDLE);
    device.attempt("vkGetMemoryFdKHR")?;
    // SAFETY: the device has the extension, for without it no such memory is allocated.
    let handle = unsafe { loader.get_memory_fd(&info) }.during("vkGetMemoryFdKHR")?;
    // SAFETY: the handle is new, and nobody else's.
    Ok(unsafe { OwnedFd::from_raw_fd(handle) })
}

impl Drop for ExportedBuffer {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for, so the GPU is done with it; whoever has the handle has a share of its own.
        unsafe {
            self.device.raw.destroy_buffer(self.raw, None);
            self.device.raw.free_memory(self.memory, None);
        }
    }
}
