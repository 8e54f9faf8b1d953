//! Passes that fill, place and draw on images, and change their layouts.

use ash::vk;

use super::{Kind, Passes};
use crate::buffer::Buffer;
use crate::error::VulkanError;
use crate::image::{COLOR, COLOR_LAYER, Image};

const UNDEFINED: vk::ImageLayout = vk::ImageLayout::UNDEFINED;

impl<'a> Passes<'a> {
    /// Fills all of `image` from `pixels`, 4 bytes each, row by row; it can then be [placed](Self::place).
    pub(crate) fn fill(&mut self, image: &'a Image, pixels: &'a Buffer) {
        self.begin(Kind::Transfer);
        self.transition(
            image.raw,
            (Kind::Transfer, UNDEFINED),
            (Kind::Transfer, vk::ImageLayout::TRANSFER_DST_OPTIMAL),
        );
        let region = [vk::BufferImageCopy::default().image_subresource(COLOR_LAYER).image_extent(vk::Extent3D {
            width: image.width,
            height: image.height,
            depth: 1,
        })];
        let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        // SAFETY: the command buffer is recording; the image has the layout named, and the buffer enough pixels.
        unsafe { self.device.cmd_copy_buffer_to_image(self.commands, pixels.raw, image.raw, layout, &region) };
        let source = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        self.transition(image.raw, (Kind::Transfer, layout), (Kind::Transfer, source));
    }

    /// Makes `target` one dark colour, ready for a picture to be [placed](Self::place) on it.
    pub(crate) fn blank(&mut self, target: vk::Image) {
        self.begin(Kind::Transfer);
        let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        self.transition(target, (Kind::Transfer, UNDEFINED), (Kind::Transfer, layout));
        let background = vk::ClearColorValue { float32: [0.09, 0.09, 0.1, 1.0] };
        // SAFETY: the command buffer is recording, and the image has the layout named.
        unsafe { self.device.cmd_clear_color_image(self.commands, target, layout, &background, &[COLOR]) };
        self.transition(target, (Kind::Transfer, layout), (Kind::Transfer, layout));
    }

    /// Draws `image` into the rectangle `[left, top, right, bottom]` of the blank `target`, scaled.
    pub(crate) fn place(&mut self, image: &'a Image, target: vk::Image, rectangle: [i32; 4]) {
        self.begin(Kind::Transfer);
        let [left, top, right, bottom] = rectangle;
        let corner = |x, y, z| vk::Offset3D { x, y, z };
        let region = [vk::ImageBlit::default()
            .src_subresource(COLOR_LAYER)
            .src_offsets([corner(0, 0, 0), corner(image.width as i32, image.height as i32, 1)])
            .dst_subresource(COLOR_LAYER)
            .dst_offsets([corner(left, top, 0), corner(right, bottom, 1)])];
        let same_size = (right - left, bottom - top) == (image.width as i32, image.height as i32);
        let filter = if same_size { vk::Filter::NEAREST } else { vk::Filter::LINEAR };
        let (source, layout) = (vk::ImageLayout::TRANSFER_SRC_OPTIMAL, vk::ImageLayout::TRANSFER_DST_OPTIMAL);
        // SAFETY: the command buffer is recording; both images have the layouts named, and the rectangle lies inside.
        unsafe { self.device.cmd_blit_image(self.commands, image.raw, source, target, layout, &region, filter) };
    }

    /// Draws on `target`, which has been made [blank](Self::blank), inside a render pass that leaves its layout alone.
    pub(crate) fn draw(
        &mut self,
        target: vk::Image,
        begin: &vk::RenderPassBeginInfo<'_>,
        record: impl FnOnce(vk::CommandBuffer) -> Result<(), VulkanError>,
    ) -> Result<(), VulkanError> {
        let placed = (Kind::Transfer, vk::ImageLayout::TRANSFER_DST_OPTIMAL);
        self.transition(target, placed, (Kind::Draw, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL));
        self.last = Some(Kind::Draw);
        // SAFETY: the command buffer is recording; render pass and framebuffer are alive until the submission is done.
        unsafe { self.device.cmd_begin_render_pass(self.commands, begin, vk::SubpassContents::INLINE) };
        record(self.commands)?;
        // SAFETY: begun above.
        unsafe { self.device.cmd_end_render_pass(self.commands) };
        Ok(())
    }

    /// Copies `target`, `size` pixels and [drawn](Self::draw) on, to `pixels`.
    pub(crate) fn capture(&mut self, target: vk::Image, size: [u32; 2], pixels: &'a Buffer) {
        let drawn = (Kind::Draw, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL);
        let source = (Kind::Transfer, vk::ImageLayout::TRANSFER_SRC_OPTIMAL);
        self.transition(target, drawn, source);
        self.last = Some(Kind::Transfer);
        let [width, height] = size;
        let extent = vk::Extent3D { width, height, depth: 1 };
        let region = [vk::BufferImageCopy::default().image_subresource(COLOR_LAYER).image_extent(extent)];
        // SAFETY: the command buffer is recording; the image has the layout named, and the buffer room for its pixels.
        unsafe { self.device.cmd_copy_image_to_buffer(self.commands, target, source.1, pixels.raw, &region) };
        self.transition(target, source, drawn);
    }

    /// Leaves `target` in the layout that a display wants, or a source of copies.
    pub(crate) fn hand_over(&mut self, target: vk::Image, layout: vk::ImageLayout) {
        let drawn = vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL;
        self.transition(target, (Kind::Draw, drawn), (Kind::Transfer, layout));
    }

    fn transition(&self, image: vk::Image, from: (Kind, vk::ImageLayout), to: (Kind, vk::ImageLayout)) {
        let barrier = [vk::ImageMemoryBarrier::default()
            .image(image)
            .subresource_range(COLOR)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .src_access_mask(from.0.writes())
            .dst_access_mask(to.0.reads() | to.0.writes())
            .old_layout(from.1)
            .new_layout(to.1)];
        let none = vk::DependencyFlags::empty();
        // SAFETY: the command buffer is recording, and the image is in the layout `from` or may lose its contents.
        unsafe {
            self.device.cmd_pipeline_barrier(self.commands, from.0.stage(), to.0.stage(), none, &[], &[], &barrier);
        }
    }
}
