use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use crate::device::Device;
use crate::error::{During, VulkanError};

/// Range of a colour image that covers all of it.
pub(crate) const COLOR: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

/// Layers of a colour image that a copy covers: all of them.
pub(crate) const COLOR_LAYER: vk::ImageSubresourceLayers = vk::ImageSubresourceLayers {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    mip_level: 0,
    base_array_layer: 0,
    layer_count: 1,
};

/// Format of images that are not a window's: bytes red, green, blue, opacity, as they are.
pub(crate) const FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;

/// A picture in device memory.
pub(crate) struct Image {
    pub raw: vk::Image,
    pub width: u32,
    pub height: u32,
    allocation: Option<Allocation>,
    device: Arc<Device>,
}

impl Image {
    /// Makes an image of `width` times `height` pixels, undefined until filled; one larger than the device draws is an
    /// error.
    pub fn new(device: &Arc<Device>, width: u32, height: u32) -> Result<Self, VulkanError> {
        let limit = device.physical.limits.max_image_dimension2_d;
        if width.max(height) > limit {
            let name = device.physical.name.clone();
            return Err(VulkanError::ImageTooLarge { width, height, name, limit });
        }
        let usage = vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST
            | vk::ImageUsageFlags::COLOR_ATTACHMENT;
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(FORMAT)
            .extent(vk::Extent3D { width, height, depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(usage);
        // SAFETY: the device is alive; `Drop` destroys the image.
        let raw = unsafe { device.raw.create_image(&info, None) }.during("vkCreateImage")?;
        let mut image = Self { raw, width, height, allocation: None, device: device.clone() };

        // SAFETY: `raw` was just created from this device.
        let requirements = unsafe { device.raw.get_image_memory_requirements(raw) };
        let allocation = device
            .allocator()
            .allocate(&AllocationCreateDesc {
                name: "image",
                requirements,
                location: MemoryLocation::GpuOnly,
                linear: false,
                allocation_scheme: AllocationScheme::GpuAllocatorManaged,
            })
            .map_err(|e| VulkanError::OutOfMemory(format!("an image of {width}x{height}: {e}")))?;
        // SAFETY: the allocation was made for this image's requirements and is bound once.
        unsafe { device.raw.bind_image_memory(raw, allocation.memory(), allocation.offset()) }
            .during("vkBindImageMemory")?;
        image.allocation = Some(allocation);
        Ok(image)
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for while the images it uses are borrowed.
        unsafe { self.device.raw.destroy_image(self.raw, None) };
        if let Some(allocation) = self.allocation.take() {
            // Freeing fails only for allocations of another allocator.
            let _ = self.device.allocator().free(allocation);
        }
    }
}
