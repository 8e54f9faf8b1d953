use std::sync::Arc;
use std::time::{Duration, Instant};

use ash::vk;
use egui_ash_renderer::allocator::GpuAllocator;
use egui_ash_renderer::{Options, RenderMode, Renderer, RendererError};

use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::{During, VulkanError};
use crate::image::{FORMAT, Image};
use crate::passes::Around;
use crate::surface::{Acquired, Surface, Swapchain};

/// Panels drawn over the picture, as egui describes them.
pub struct Overlay<'a> {
    /// Triangles to draw, in order.
    pub primitives: &'a [egui::ClippedPrimitive],
    /// Textures that have changed since the last frame.
    pub textures: egui::TexturesDelta,
    /// Physical pixels in a point of egui.
    pub pixels_per_point: f32,
    /// Whether the frame's pixels are [returned](Shown::capture) too.
    pub capture: bool,
}

/// A picture to show.
pub struct Picture<'a> {
    /// Pixels of the picture, row by row from the top left: bytes red, green, blue, opacity.
    pub pixels: Pixels<'a>,
    /// Size of the picture: pixels across and down.
    pub size: [u32; 2],
}

/// Memory that the pixels of a picture are in.
pub enum Pixels<'a> {
    /// Pixels in the host's memory.
    Host(&'a [u8]),
    /// Pixels in a device's memory; reaching the canvas is fastest from its own device.
    Device(&'a Buffer),
}

/// Part of a canvas, in pixels from its top left.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Area {
    /// Distance from the canvas' left edge.
    pub left: u32,
    /// Distance from the canvas' top edge.
    pub top: u32,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

/// Fate of a frame that was drawn.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Shown {
    /// Whether the frame was drawn: false while there is nothing to draw into, as when the window is minimised, or
    /// about to be made anew.
    pub visible: bool,
    /// Time spent waiting for the display.
    pub waited: Duration,
    /// Pixels of the frame, if asked for and if the display lets them be read: bytes red, green, blue, opacity.
    pub capture: Option<Vec<u8>>,
}

/// Target of frames: a window, or an image that nobody sees. Both take the same way.
pub struct Canvas {
    // The fields stand in the order in which they have to be dropped.
    panels: Panels,
    framebuffers: Vec<Framebuffer>,
    target: Target,
    picture: Option<Image>,
    upload: Option<Buffer>,
    device: Arc<Device>,
}

enum Target {
    Window { swapchain: Option<Swapchain>, surface: Surface, fits: bool },
    Hidden(Image),
    Nothing,
}

impl Canvas {
    /// Makes a canvas that shows its frames in a window, of `size` pixels where the window leaves the choice.
    pub fn for_window(device: &Arc<Device>, surface: Surface, size: [u32; 2]) -> Result<Self, VulkanError> {
        let swapchain = Swapchain::new(device, &surface, size, None)?;
        let format = surface.format(device.physical())?.format;
        Self::new(device, Target::Window { swapchain, surface, fits: true }, format)
    }

    /// Makes a canvas of `size` pixels in memory, which nobody sees.
    pub fn hidden(device: &Arc<Device>, size: [u32; 2]) -> Result<Self, VulkanError> {
        let image = Image::new(device, size[0].max(1), size[1].max(1))?;
        Self::new(device, Target::Hidden(image), FORMAT)
    }

    fn new(device: &Arc<Device>, target: Target, format: vk::Format) -> Result<Self, VulkanError> {
        let panels = Panels::new(device, format)?;
        let mut canvas =
            Self { panels, framebuffers: vec![], target, picture: None, upload: None, device: device.clone() };
        canvas.make_framebuffers()?;
        Ok(canvas)
    }

    /// Size in pixels, across and down; zero while there is nothing to draw into.
    pub fn size(&self) -> [u32; 2] {
        match &self.target {
            Target::Window { swapchain, .. } => {
                swapchain.as_ref().map_or([0, 0], |s| [s.extent.width, s.extent.height])
            }
            Target::Hidden(image) => [image.width, image.height],
            Target::Nothing => [0, 0],
        }
    }

    /// Resizes the canvas to `size` pixels, if it has another size.
    pub fn resize_to(&mut self, size: [u32; 2]) -> Result<(), VulkanError> {
        if size == self.size() { Ok(()) } else { self.resize(size) }
    }

    /// Gives up the canvas' window, of which there can be only one canvas; a hidden canvas stays.
    pub fn release(&mut self) {
        self.framebuffers.clear();
        if let Target::Window { .. } = self.target {
            self.target = Target::Nothing;
        }
    }

    /// Resizes the canvas to `size` pixels, and makes all anew even if that is no change.
    pub fn resize(&mut self, size: [u32; 2]) -> Result<(), VulkanError> {
        self.framebuffers.clear();
        match &mut self.target {
            Target::Window { swapchain, surface, fits } => {
                // The swapchain does not fit until all is made anew.
                *fits = false;
                *swapchain = Swapchain::new(&self.device, surface, size, swapchain.as_ref())?;
                *fits = true;
            }
            Target::Hidden(image) => *image = Image::new(&self.device, size[0].max(1), size[1].max(1))?,
            Target::Nothing => {}
        }
        self.make_framebuffers()
    }

    /// Draws the picture (`None`: the last one again) over all of `area`, the panels over it, and shows the result.
    pub fn show(
        &mut self,
        picture: Option<Picture<'_>>,
        area: Area,
        mut overlay: Overlay<'_>,
    ) -> Result<Shown, VulkanError> {
        let unfit = matches!(self.target, Target::Window { fits: false, .. });
        if unfit {
            self.resize(self.size())?;
        }
        if let Some(picture) = picture {
            self.take(&picture)?;
        }
        // Even a frame that is not drawn may bring textures, and brings each only once.
        self.panels.update_textures(&self.device, &overlay)?;
        let drawn = self.draw(area, &overlay);
        self.panels.free_textures(&mut overlay.textures)?;
        drawn
    }

    /// Copies a picture into an image of the canvas' own, from which it can be drawn again and again.
    fn take(&mut self, picture: &Picture<'_>) -> Result<(), VulkanError> {
        let [width, height] = picture.size;
        let image = match self.picture.take() {
            Some(image) if [image.width, image.height] == picture.size => image,
            _ => Image::new(&self.device, width, height)?,
        };
        let foreign;
        let bytes = match picture.pixels {
            Pixels::Device(buffer) if Arc::ptr_eq(&buffer.device, &self.device) => {
                self.device.run(|passes| passes.fill(&image, buffer))?;
                self.picture = Some(image);
                return Ok(());
            }
            Pixels::Device(buffer) => {
                foreign = buffer.read()?;
                &foreign
            }
            Pixels::Host(bytes) => bytes,
        };
        let size = u64::from(width) * u64::from(height) * 4;
        let mut upload = match self.upload.take() {
            Some(upload) if upload.size() == size => upload,
            _ => Buffer::new(&self.device, "picture", size, Location::Upload)?,
        };
        upload.mapped_mut()[..size as usize].copy_from_slice(&bytes[..size as usize]);
        let upload = self.upload.insert(upload);
        self.device.run(|passes| passes.fill(&image, upload))?;
        self.picture = Some(image);
        Ok(())
    }

    fn draw(&mut self, area: Area, overlay: &Overlay<'_>) -> Result<Shown, VulkanError> {
        let start = Instant::now();
        let size = self.size();
        let not_shown = Ok(Shown::default());
        if self.framebuffers.is_empty() {
            return not_shown;
        }
        let readable = match &self.target {
            Target::Window { swapchain, .. } => swapchain.as_ref().is_some_and(|s| s.readable),
            Target::Hidden(_) | Target::Nothing => true,
        };
        let bytes = u64::from(size[0]) * u64::from(size[1]) * 4;
        let capture = (overlay.capture && readable)
            .then(|| Buffer::new(&self.device, "screenshot", bytes, Location::Readback))
            .transpose()?;
        let (index, raw, layout, around) = match &mut self.target {
            Target::Window { swapchain: Some(swapchain), fits, .. } => {
                let index = match swapchain.acquire()? {
                    Acquired::Image(index) => index,
                    Acquired::Hidden => return not_shown,
                    Acquired::Unfit => {
                        *fits = false;
                        return not_shown;
                    }
                };
                let around = Around { wait: vec![swapchain.acquired], signal: vec![swapchain.drawn[index]] };
                (index, swapchain.images[index], vk::ImageLayout::PRESENT_SRC_KHR, around)
            }
            Target::Window { swapchain: None, .. } | Target::Nothing => return not_shown,
            Target::Hidden(image) => (0, image.raw, vk::ImageLayout::TRANSFER_SRC_OPTIMAL, Around::default()),
        };
        let mut waited = start.elapsed();
        let extent = vk::Extent2D { width: size[0], height: size[1] };
        let begin = vk::RenderPassBeginInfo::default()
            .render_pass(self.panels.render_pass)
            .framebuffer(self.framebuffers[index].raw)
            .render_area(vk::Rect2D { offset: vk::Offset2D::default(), extent });
        let renderer = &mut self.panels.renderer;
        let picture = &self.picture;
        let drawn = self.device.run_around(around, |passes| {
            passes.blank(raw);
            if let (Some(picture), Some(rectangle)) = (picture, area.inside(size)) {
                passes.place(picture, raw, rectangle);
            }
            passes.draw(raw, &begin, |commands| {
                renderer.cmd_draw(commands, extent, overlay.pixels_per_point, overlay.primitives).map_err(panels)
            })?;
            if let Some(capture) = &capture {
                passes.capture(raw, size, capture);
            }
            passes.hand_over(raw, layout);
            Ok(())
        });
        if let Target::Window { swapchain: Some(swapchain), surface, fits } = &mut self.target {
            // An image that was taken and not shown makes the swapchain useless.
            *fits = false;
            drawn?;
            let start = Instant::now();
            *fits = swapchain.present(index, surface)?;
            waited += start.elapsed();
        } else {
            drawn?;
        }
        let mut capture = capture.map(|pixels| pixels.mapped()[..bytes as usize].to_vec());
        if self.panels.format == vk::Format::B8G8R8A8_UNORM {
            let pixels = capture.iter_mut().flat_map(|bytes| bytes.chunks_exact_mut(4));
            pixels.for_each(|pixel| pixel.swap(0, 2));
        }
        Ok(Shown { visible: true, waited, capture })
    }

    fn make_framebuffers(&mut self) -> Result<(), VulkanError> {
        let (images, format) = match &self.target {
            Target::Window { swapchain: Some(s), .. } => (s.images.clone(), s.format),
            Target::Window { swapchain: None, .. } | Target::Nothing => return Ok(()),
            Target::Hidden(image) => (vec![image.raw], FORMAT),
        };
        let size = self.size();
        let make = |image| Framebuffer::new(&self.device, image, format, self.panels.render_pass, size);
        self.framebuffers = images.into_iter().map(make).collect::<Result<_, _>>()?;
        Ok(())
    }
}

impl Area {
    /// Part inside a canvas of `size`, as `[left, top, right, bottom]` in pixels; `None` if nothing is.
    fn inside(self, size: [u32; 2]) -> Option<[i32; 4]> {
        let (right, bottom) = ((self.left + self.width).min(size[0]), (self.top + self.height).min(size[1]));
        (self.left < right && self.top < bottom).then(|| [self.left, self.top, right, bottom].map(|x| x as i32))
    }
}

/// Renderer of egui's triangles on the GPU, with all that it draws through.
struct Panels {
    renderer: Renderer<GpuAllocator>,
    render_pass: vk::RenderPass,
    format: vk::Format,
    pool: vk::CommandPool,
    device: Arc<Device>,
}

impl Panels {
    fn new(device: &Arc<Device>, format: vk::Format) -> Result<Self, VulkanError> {
        // The panels are drawn over what is there; the passes around them change the layout.
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
        .map_err(panels)?;
        Ok(Self { renderer, render_pass, format, pool, device: device.clone() })
    }

    fn update_textures(&mut self, device: &Device, overlay: &Overlay<'_>) -> Result<(), VulkanError> {
        let queue = device.queue.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        for (id, deltas) in &overlay.textures.set {
            for delta in deltas {
                self.renderer.set_texture(queue.raw, self.pool, *id, delta).map_err(panels)?;
            }
        }
        Ok(())
    }

    fn free_textures(&mut self, textures: &mut egui::TexturesDelta) -> Result<(), VulkanError> {
        textures.set.clear();
        for id in textures.free.drain() {
            self.renderer.free_texture(id).map_err(panels)?;
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

/// Names the panels in an error; a lost device is no fault of theirs.
fn panels(error: RendererError) -> VulkanError {
    match error {
        RendererError::Vulkan(result) => Err::<(), _>(result).during("drawing the panels").unwrap_err(),
        other => VulkanError::Panels(other.to_string()),
    }
}

/// Image of the target as something to draw on.
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
