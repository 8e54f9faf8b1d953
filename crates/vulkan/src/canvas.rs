use std::sync::Arc;

use ash::vk;
use egui_ash_renderer::allocator::GpuAllocator;
use egui_ash_renderer::{Options, RenderMode, Renderer};

use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::{During, VulkanError};
use crate::image::{FORMAT, Image};
use crate::passes::Around;
use crate::surface::{Surface, Swapchain};

/// Panels drawn over the picture, as egui describes them.
pub struct Overlay<'a> {
    /// Triangles.
    pub primitives: &'a [egui::ClippedPrimitive],
    /// Textures that have changed.
    pub textures: egui::TexturesDelta,
    /// Physical pixels in a point of egui.
    pub pixels_per_point: f32,
}

/// Where frames are drawn: a window, or an image that nobody sees. Both take the same way.
pub struct Canvas {
    // In the order in which they have to go.
    panels: Panels,
    framebuffers: Vec<Framebuffer>,
    target: Target,
    picture: Option<Image>,
    device: Arc<Device>,
}

enum Target {
    Window { swapchain: Option<Swapchain>, surface: Surface, fits: bool },
    Hidden(Image),
}

impl Canvas {
    /// In a window.
    pub fn for_window(device: &Arc<Device>, surface: Surface, size: [u32; 2]) -> Result<Self, VulkanError> {
        let swapchain = Swapchain::new(device, &surface, size, None)?;
        let format = swapchain.as_ref().map_or(vk::Format::B8G8R8A8_UNORM, |s| s.format);
        Self::new(device, Target::Window { swapchain, surface, fits: true }, format)
    }

    /// In memory.
    pub fn hidden(device: &Arc<Device>, size: [u32; 2]) -> Result<Self, VulkanError> {
        let image = Image::new(device, size[0].max(1), size[1].max(1))?;
        Self::new(device, Target::Hidden(image), FORMAT)
    }

    fn new(device: &Arc<Device>, target: Target, format: vk::Format) -> Result<Self, VulkanError> {
        let panels = Panels::new(device, format)?;
        let mut canvas = Self { panels, framebuffers: vec![], target, picture: None, device: device.clone() };
        canvas.make_framebuffers()?;
        Ok(canvas)
    }

    /// Size in pixels; zero while there is nothing to draw into.
    pub fn size(&self) -> [u32; 2] {
        match &self.target {
            Target::Window { swapchain, .. } => {
                swapchain.as_ref().map_or([0, 0], |s| [s.extent.width, s.extent.height])
            }
            Target::Hidden(image) => [image.width, image.height],
        }
    }

    /// Follows the window's size.
    pub fn resize(&mut self, size: [u32; 2]) -> Result<(), VulkanError> {
        self.framebuffers.clear();
        match &mut self.target {
            Target::Window { swapchain, surface, fits } => {
                let new = Swapchain::new(&self.device, surface, size, swapchain.as_ref())?;
                *swapchain = new;
                *fits = true;
            }
            Target::Hidden(image) => *image = Image::new(&self.device, size[0].max(1), size[1].max(1))?,
        }
        self.make_framebuffers()
    }

    /// Draws `pixels` (`picture_size`, 4 bytes each) as large as fits, the panels over it, and shows the result.
    pub fn show(&mut self, pixels: &Buffer, picture_size: [u32; 2], overlay: Overlay<'_>) -> Result<(), VulkanError> {
        if matches!(self.target, Target::Window { fits: false, .. }) {
            self.resize(self.size())?;
        }
        if self.picture.as_ref().map(|p| [p.width, p.height]) != Some(picture_size) {
            self.picture = Some(Image::new(&self.device, picture_size[0], picture_size[1])?);
        }
        self.panels.update_textures(&self.device, &overlay)?;
        let drawn = self.draw(pixels, &overlay);
        self.panels.free_textures(overlay.textures)?;
        drawn
    }

    fn draw(&mut self, pixels: &Buffer, overlay: &Overlay<'_>) -> Result<(), VulkanError> {
        let (Some(picture), size) = (&self.picture, self.size()) else { return Ok(()) };
        let (index, raw, layout, around) = match &mut self.target {
            Target::Window { swapchain: Some(swapchain), fits, .. } => {
                let Some(index) = swapchain.acquire()? else {
                    *fits = false;
                    return Ok(());
                };
                let around = Around { wait: vec![swapchain.acquired], signal: vec![swapchain.drawn[index]] };
                (index, swapchain.images[index], vk::ImageLayout::PRESENT_SRC_KHR, around)
            }
            Target::Window { swapchain: None, .. } => return Ok(()),
            Target::Hidden(image) => (0, image.raw, vk::ImageLayout::TRANSFER_SRC_OPTIMAL, Around::default()),
        };
        let extent = vk::Extent2D { width: size[0], height: size[1] };
        let rectangle = fit([picture.width, picture.height], size);
        let begin = vk::RenderPassBeginInfo::default()
            .render_pass(self.panels.render_pass)
            .framebuffer(self.framebuffers[index].raw)
            .render_area(vk::Rect2D { offset: vk::Offset2D::default(), extent });
        let renderer = &mut self.panels.renderer;
        self.device.run_around(around, |passes| {
            passes.fill(picture, pixels);
            passes.place(picture, raw, rectangle);
            passes.draw(&begin, |commands| {
                renderer
                    .cmd_draw(commands, extent, overlay.pixels_per_point, overlay.primitives)
                    .map_err(|e| VulkanError::Panels(e.to_string()))
            })?;
            passes.hand_over(raw, layout);
            Ok(())
        })?;
        if let Target::Window { swapchain: Some(swapchain), fits, .. } = &mut self.target {
            *fits = swapchain.present(index)?;
        }
        Ok(())
    }

    /// What was last drawn on a hidden canvas: red, green, blue, opacity.
    pub fn read(&self) -> Result<Option<Vec<u8>>, VulkanError> {
        let Target::Hidden(image) = &self.target else { return Ok(None) };
        let size = u64::from(image.width) * u64::from(image.height) * 4;
        let pixels = Buffer::new(&self.device, "screenshot", size, Location::Readback)?;
        self.device.run(|passes| passes.copy_image(image, &pixels))?;
        Ok(Some(pixels.mapped()[..size as usize].to_vec()))
    }

    fn make_framebuffers(&mut self) -> Result<(), VulkanError> {
        let (images, format) = match &self.target {
            Target::Window { swapchain: Some(s), .. } => (s.images.clone(), s.format),
            Target::Window { swapchain: None, .. } => return Ok(()),
            Target::Hidden(image) => (vec![image.raw], FORMAT),
        };
        let size = self.size();
        let make = |image| Framebuffer::new(&self.device, image, format, self.panels.render_pass, size);
        self.framebuffers = images.into_iter().map(make).collect::<Result<_, _>>()?;
        Ok(())
    }
}

/// `[left, top, right, bottom]` of a picture as large as fits into `size`, centred, its proportions kept.
fn fit(picture: [u32; 2], size: [u32; 2]) -> [i32; 4] {
    let scale = (f64::from(size[0]) / f64::from(picture[0])).min(f64::from(size[1]) / f64::from(picture[1]));
    let inner = [0, 1].map(|i| ((f64::from(picture[i]) * scale).round() as i32).clamp(1, size[i] as i32));
    let corner = [0, 1].map(|i| (size[i] as i32 - inner[i]) / 2);
    [corner[0], corner[1], corner[0] + inner[0], corner[1] + inner[1]]
}

/// egui's triangles on the GPU.
struct Panels {
    renderer: Renderer<GpuAllocator>,
    render_pass: vk::RenderPass,
    pool: vk::CommandPool,
    device: Arc<Device>,
}

impl Panels {
    fn new(device: &Arc<Device>, format: vk::Format) -> Result<Self, VulkanError> {
        // Drawn over what is there; the passes around it change the layout.
        let attachment = [vk::AttachmentDescription::default()
            .format(format)
            .samples(vk::SampleCountFlags::TYPE_1)
            .load_op(vk::AttachmentLoadOp::LOAD)
            .store_op(vk::AttachmentStoreOp::STORE)
            .initial_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
            .final_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)];
        let reference = [vk::AttachmentReference::default().layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)];
        let subpass = [vk::SubpassDescription::default().color_attachments(&reference)];
        let info = vk::RenderPassCreateInfo::default().attachments(&attachment).subpasses(&subpass);
        let pool_info = vk::CommandPoolCreateInfo::default().queue_family_index(device.physical.queue_family);
        // SAFETY: the structures live until the calls return; `Drop` destroys what is made here.
        let (render_pass, pool) = unsafe {
            (
                device.raw.create_render_pass(&info, None).during("vkCreateRenderPass")?,
                device.raw.create_command_pool(&pool_info, None).during("vkCreateCommandPool")?,
            )
        };
        let renderer = Renderer::with_gpu_allocator(
            device.shared_allocator(),
            device.raw.clone(),
            RenderMode::RenderPass(render_pass),
            Options::default(),
        )
        .map_err(|e| VulkanError::Panels(e.to_string()))?;
        Ok(Self { renderer, render_pass, pool, device: device.clone() })
    }

    fn update_textures(&mut self, device: &Device, overlay: &Overlay<'_>) -> Result<(), VulkanError> {
        let queue = device.queue.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        for (id, deltas) in &overlay.textures.set {
            for delta in deltas {
                self.renderer
                    .set_texture(queue.raw, self.pool, *id, delta)
                    .map_err(|e| VulkanError::Panels(e.to_string()))?;
            }
        }
        Ok(())
    }

    fn free_textures(&mut self, mut textures: egui::TexturesDelta) -> Result<(), VulkanError> {
        textures.set.clear();
        for id in textures.free.drain() {
            self.renderer.free_texture(id).map_err(|e| VulkanError::Panels(e.to_string()))?;
        }
        Ok(())
    }
}

impl Drop for Panels {
    fn drop(&mut self) {
        // SAFETY: every submission has been waited for. The renderer destroys its own parts after this, while the
        // device is still alive.
        unsafe {
            self.device.raw.destroy_render_pass(self.render_pass, None);
            self.device.raw.destroy_command_pool(self.pool, None);
        }
    }
}

/// An image of the target as something to draw on.
struct Framebuffer {
    raw: vk::Framebuffer,
    view: vk::ImageView,
    device: Arc<Device>,
}

impl Framebuffer {
    fn new(
        device: &Arc<Device>,
        image: vk::Image,
        format: vk::Format,
        render_pass: vk::RenderPass,
        size: [u32; 2],
    ) -> Result<Self, VulkanError> {
        let info = vk::ImageViewCreateInfo::default()
            .image(image)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(format)
            .subresource_range(crate::image::COLOR);
        // SAFETY: the image is alive and of this format; `Drop` destroys the view.
        let view = unsafe { device.raw.create_image_view(&info, None) }.during("vkCreateImageView")?;
        let mut framebuffer = Self { raw: vk::Framebuffer::null(), view, device: device.clone() };
        let views = [view];
        let info = vk::FramebufferCreateInfo::default()
            .render_pass(render_pass)
            .attachments(&views)
            .width(size[0])
            .height(size[1])
            .layers(1);
        // SAFETY: view and render pass are alive.
        framebuffer.raw = unsafe { device.raw.create_framebuffer(&info, None) }.during("vkCreateFramebuffer")?;
        Ok(framebuffer)
    }
}

impl Drop for Framebuffer {
    fn drop(&mut self) {
        // SAFETY: every submission has been waited for; null handles are allowed.
        unsafe {
            self.device.raw.destroy_framebuffer(self.raw, None);
            self.device.raw.destroy_image_view(self.view, None);
        }
    }
}
