use std::any::Any;
use std::sync::Arc;
use std::time::Duration;

use ash::{khr, vk};
use raw_window_handle::{HasDisplayHandle, HasWindowHandle};

use crate::device::Device;
use crate::error::{During, VulkanError};
use crate::instance::{Instance, PhysicalDevice};

/// Window to draw into.
pub struct Surface {
    raw: vk::SurfaceKHR,
    loader: khr::surface::Instance,
    instance: Arc<Instance>,
    // The system destroys the surface with its window, so the window has to stay.
    _window: Arc<dyn Any>,
}

impl Surface {
    /// Makes the surface of `window`, with an instance made [for windows](Instance::for_windows).
    pub fn new<W: HasDisplayHandle + HasWindowHandle + 'static>(
        instance: &Arc<Instance>,
        window: &Arc<W>,
    ) -> Result<Self, VulkanError> {
        let display = window.display_handle().map_err(|_| VulkanError::NoWindows)?.as_raw();
        let handle = window.window_handle().map_err(|_| VulkanError::NoWindows)?.as_raw();
        // SAFETY: the handles are of a live window, kept alive by this value.
        let raw = unsafe { ash_window::create_surface(&instance.entry, &instance.raw, display, handle, None) }
            .during("vkCreateSurfaceKHR")?;
        let loader = khr::surface::Instance::new(&instance.entry, &instance.raw);
        Ok(Self { raw, loader, instance: instance.clone(), _window: window.clone() })
    }

    /// Format in which the surface's images hold colours.
    pub(crate) fn format(&self, physical: &PhysicalDevice) -> Result<vk::SurfaceFormatKHR, VulkanError> {
        // SAFETY: device and surface come from one instance.
        let formats = unsafe { self.loader.get_physical_device_surface_formats(physical.handle, self.raw) }
            .during("vkGetPhysicalDeviceSurfaceFormatsKHR")?;
        choose_format(&formats).ok_or(VulkanError::NoWindows)
    }

    fn capabilities(&self, physical: &PhysicalDevice) -> Result<vk::SurfaceCapabilitiesKHR, VulkanError> {
        // SAFETY: device and surface come from one instance.
        unsafe { self.loader.get_physical_device_surface_capabilities(physical.handle, self.raw) }
            .during("vkGetPhysicalDeviceSurfaceCapabilitiesKHR")
    }

    /// Whether the pictures of `physical` can be shown in this window.
    pub fn shows(&self, physical: &PhysicalDevice) -> bool {
        // SAFETY: device and surface come from one instance.
        unsafe { self.loader.get_physical_device_surface_support(physical.handle, physical.queue_family, self.raw) }
            .unwrap_or(false)
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        // SAFETY: the swapchain that used it owns it, and goes first.
        unsafe { self.loader.destroy_surface(self.raw, None) };
    }
}

/// Longest wait for an image: some systems give none for a window that is not seen, and the program is not to wait for
/// that to change.
const PATIENCE: Duration = Duration::from_millis(200);

/// Outcome of asking for an image to draw into.
pub(crate) enum Acquired {
    /// Image to draw into, by its place among the swapchain's images.
    Image(usize),
    /// The window is not seen at the moment.
    Hidden,
    /// The swapchain no longer fits its window.
    Unfit,
}

/// Images that a window shows in turn.
pub(crate) struct Swapchain {
    raw: vk::SwapchainKHR,
    loader: khr::swapchain::Device,
    pub images: Vec<vk::Image>,
    pub format: vk::Format,
    pub extent: vk::Extent2D,
    /// Whether images can be copied from.
    pub readable: bool,
    /// Semaphore that is signalled when an image may be drawn into.
    pub acquired: vk::Semaphore,
    /// Semaphores that are signalled when an image may be shown, one for each image.
    pub drawn: Vec<vk::Semaphore>,
    device: Arc<Device>,
}

impl Swapchain {
    /// Makes a swapchain for the window's current size, or `wanted` where the window leaves the choice. `None` while
    /// the window has no area, as when it is minimised.
    pub fn new(
        device: &Arc<Device>,
        surface: &Surface,
        wanted: [u32; 2],
        old: Option<&Self>,
    ) -> Result<Option<Self>, VulkanError> {
        let capabilities = surface.capabilities(&device.physical)?;
        let format = surface.format(&device.physical)?;
        let (least, most) = (capabilities.min_image_extent, capabilities.max_image_extent);
        let extent = match capabilities.current_extent {
            vk::Extent2D { width: u32::MAX, .. } => vk::Extent2D {
                width: wanted[0].clamp(least.width, most.width.max(least.width)),
                height: wanted[1].clamp(least.height, most.height.max(least.height)),
            },
            extent => extent,
        };
        if extent.width == 0 || extent.height == 0 {
            return Ok(None);
        }
        let at_most = if capabilities.max_image_count == 0 { u32::MAX } else { capabilities.max_image_count };
        let readable = capabilities.supported_usage_flags.contains(vk::ImageUsageFlags::TRANSFER_SRC);
        let mut usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_DST;
        if readable {
            usage |= vk::ImageUsageFlags::TRANSFER_SRC;
        }
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(surface.raw)
            .min_image_count((capabilities.min_image_count + 1).min(at_most))
            .image_format(format.format)
            .image_color_space(format.color_space)
            .image_extent(extent)
            .image_array_layers(1)
            .image_usage(usage)
            .pre_transform(capabilities.current_transform)
            .composite_alpha(vk::CompositeAlphaFlagsKHR::OPAQUE)
            .present_mode(vk::PresentModeKHR::FIFO)
            .clipped(true)
            .old_swapchain(old.map_or(vk::SwapchainKHR::null(), |old| old.raw));
        let loader = khr::swapchain::Device::new(&surface.instance.raw, &device.raw);
        // SAFETY: the surface is alive and used by no other swapchain but `old`; `Drop` destroys what is made here.
        unsafe {
            let raw = loader.create_swapchain(&info, None).during("vkCreateSwapchainKHR")?;
            let images = loader.get_swapchain_images(raw).during("vkGetSwapchainImagesKHR")?;
            let semaphore =
                || device.raw.create_semaphore(&vk::SemaphoreCreateInfo::default(), None).during("vkCreateSemaphore");
            let acquired = semaphore()?;
            let drawn = images.iter().map(|_| semaphore()).collect::<Result<_, _>>()?;
            let format = format.format;
            Ok(Some(Self { raw, loader, images, format, extent, readable, acquired, drawn, device: device.clone() }))
        }
    }

    /// Takes the next image to draw into.
    pub fn acquire(&self) -> Result<Acquired, VulkanError> {
        let patience = PATIENCE.as_nanos() as u64;
        // SAFETY: the semaphore is not in use: the last submission that waited for it has been waited for.
        let acquired = unsafe { self.loader.acquire_next_image(self.raw, patience, self.acquired, vk::Fence::null()) };
        match acquired {
            Ok((index, _)) => Ok(Acquired::Image(index as usize)),
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => Ok(Acquired::Unfit),
            Err(vk::Result::TIMEOUT | vk::Result::NOT_READY) => Ok(Acquired::Hidden),
            Err(result) => Err(result).during("vkAcquireNextImageKHR"),
        }
    }

    /// Shows an image; false if the swapchain no longer fits its window.
    pub fn present(&self, index: usize, surface: &Surface) -> Result<bool, VulkanError> {
        let queue = self.device.queue.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let (swapchains, indices, wait) = ([self.raw], [index as u32], [self.drawn[index]]);
        let info = vk::PresentInfoKHR::default().swapchains(&swapchains).image_indices(&indices).wait_semaphores(&wait);
        // SAFETY: the image was acquired and handed over for presentation; the lock makes the queue ours.
        match unsafe { self.loader.queue_present(queue.raw, &info) } {
            Ok(false) => Ok(true),
            // Some windows never fit quite right; only another size is worth another swapchain.
            Ok(true) => {
                let extent = surface.capabilities(&self.device.physical)?.current_extent;
                Ok(extent == self.extent || extent.width == u32::MAX)
            }
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => Ok(false),
            Err(result) => Err(result).during("vkQueuePresentKHR"),
        }
    }
}

impl Drop for Swapchain {
    fn drop(&mut self) {
        // SAFETY: waiting makes sure that no submission or presentation uses it.
        unsafe {
            let _ = self.device.raw.device_wait_idle();
            for &semaphore in self.drawn.iter().chain([&self.acquired]) {
                self.device.raw.destroy_semaphore(semaphore, None);
            }
            self.loader.destroy_swapchain(self.raw, None);
        }
    }
}

/// Chooses a format whose bytes are shown as they are: the kernels have already encoded them.
fn choose_format(formats: &[vk::SurfaceFormatKHR]) -> Option<vk::SurfaceFormatKHR> {
    let plain = |f: &&vk::SurfaceFormatKHR| {
        matches!(f.format, vk::Format::B8G8R8A8_UNORM | vk::Format::R8G8B8A8_UNORM)
            && f.color_space == vk::ColorSpaceKHR::SRGB_NONLINEAR
    };
    formats.iter().find(plain).copied()
}
