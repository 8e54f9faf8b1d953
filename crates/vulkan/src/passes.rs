#[cfg(feature = "window")]
mod pictures;

use std::ops::Range;
use std::time::Duration;

use ash::vk;

use crate::buffer::Buffer;
use crate::compute::{BindingSet, Pipeline};
use crate::device::Device;
use crate::error::{During, VulkanError};

/// Time after which a single submission without an answer counts as hung.
const PATIENCE: Duration = Duration::from_secs(600);

/// Kind of a pass: what it does to memory. The barrier between two passes follows from their kinds.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Compute,
    Transfer,
    /// Builds and copies of structures that hardware traces rays by.
    Build,
    #[cfg(feature = "window")]
    Draw,
}

impl Kind {
    fn stage(self) -> vk::PipelineStageFlags {
        match self {
            Self::Compute => vk::PipelineStageFlags::COMPUTE_SHADER,
            Self::Transfer => vk::PipelineStageFlags::TRANSFER,
            Self::Build => vk::PipelineStageFlags::ACCELERATION_STRUCTURE_BUILD_KHR,
            #[cfg(feature = "window")]
            Self::Draw => vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT,
        }
    }

    fn reads(self) -> vk::AccessFlags {
        match self {
            Self::Compute => vk::AccessFlags::SHADER_READ,
            Self::Transfer => vk::AccessFlags::TRANSFER_READ,
            Self::Build => vk::AccessFlags::ACCELERATION_STRUCTURE_READ_KHR | vk::AccessFlags::SHADER_READ,
            #[cfg(feature = "window")]
            Self::Draw => vk::AccessFlags::COLOR_ATTACHMENT_READ,
        }
    }

    fn writes(self) -> vk::AccessFlags {
        match self {
            Self::Compute => vk::AccessFlags::SHADER_WRITE,
            Self::Transfer => vk::AccessFlags::TRANSFER_WRITE,
            Self::Build => vk::AccessFlags::ACCELERATION_STRUCTURE_WRITE_KHR,
            #[cfg(feature = "window")]
            Self::Draw => vk::AccessFlags::COLOR_ATTACHMENT_WRITE,
        }
    }
}

/// Passes being recorded. Each sees all that the earlier ones wrote; the host sees all that they wrote after
/// [`Device::run`] has returned.
pub struct Passes<'a> {
    device: &'a ash::Device,
    commands: vk::CommandBuffer,
    last: Option<Kind>,
}

/// Semaphores of a submission that shares images with a display.
#[derive(Default)]
pub(crate) struct Around {
    pub wait: Vec<vk::Semaphore>,
    pub signal: Vec<vk::Semaphore>,
}

impl Device {
    /// Records passes, submits them and waits until they are done; a lost device is an error.
    pub fn run<'a>(&'a self, record: impl FnOnce(&mut Passes<'a>)) -> Result<(), VulkanError> {
        self.run_around(Around::default(), |passes| {
            record(passes);
            Ok(())
        })
    }

    /// Runs passes in step with a window's images: waits for semaphores before, and signals others after.
    pub(crate) fn run_around<'a>(
        &'a self,
        around: Around,
        record: impl FnOnce(&mut Passes<'a>) -> Result<(), VulkanError>,
    ) -> Result<(), VulkanError> {
        let queue = self.queue.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the lock makes this thread the only user of the command buffer, and the last submission was waited
        // for before the lock was released.
        unsafe {
            self.attempt("vkResetCommandPool")?;
            self.raw.reset_command_pool(queue.pool, vk::CommandPoolResetFlags::empty()).during("vkResetCommandPool")?;
            self.attempt("vkBeginCommandBuffer")?;
            self.raw.begin_command_buffer(queue.commands, &begin).during("vkBeginCommandBuffer")?;
        }
        let mut passes = Passes::new(&self.raw, queue.commands);
        record(&mut passes)?;
        passes.finish();

        let commands = [queue.commands];
        // Whatever touches the window's image waits until the display is done with it.
        let stages = vec![vk::PipelineStageFlags::TRANSFER; around.wait.len()];
        let submit = [vk::SubmitInfo::default()
            .command_buffers(&commands)
            .wait_semaphores(&around.wait)
            .wait_dst_stage_mask(&stages)
            .signal_semaphores(&around.signal)];
        // SAFETY: as above; the resources that the passes use are borrowed by `passes` until after the wait.
        unsafe {
            self.attempt("vkEndCommandBuffer")?;
            self.raw.end_command_buffer(queue.commands).during("vkEndCommandBuffer")?;
            self.attempt("vkResetFences")?;
            self.raw.reset_fences(&[queue.fence]).during("vkResetFences")?;
            self.attempt("vkQueueSubmit")?;
            self.raw.queue_submit(queue.raw, &submit, queue.fence).during("vkQueueSubmit")?;
            let waited = self.attempt("vkWaitForFences").and_then(|()| {
                let waited = self.raw.wait_for_fences(&[queue.fence], true, PATIENCE.as_nanos() as u64);
                waited.during("vkWaitForFences")
            });
            match waited {
                // Whatever the trouble, nothing that the passes use may be released while the GPU still runs. Once it is
                // idle all has been done: only the waiting has failed, and whoever were told so would do it twice.
                Err(VulkanError::OutOfMemory(_)) => self.raw.device_wait_idle().during("vkDeviceWaitIdle"),
                Err(error) => {
                    let _ = self.raw.device_wait_idle();
                    Err(error)
                }
                Ok(()) => Ok(()),
            }
        }
    }
}

impl<'a> Passes<'a> {
    fn new(device: &'a ash::Device, commands: vk::CommandBuffer) -> Self {
        Self { device, commands, last: None }
    }

    /// Runs `groups` workgroups of a kernel, in x, y and z. `push` holds the bytes of its push block.
    ///
    /// # Panics
    /// If a set is laid out differently from the kernel's module, or `push` is not as long as the module's push block.
    pub fn compute(&mut self, pipeline: &'a Pipeline, sets: &[&'a BindingSet], push: &[u8], groups: [u32; 3]) {
        let module = &pipeline.module;
        assert!(sets.iter().all(|set| module.takes(set)), "the sets are laid out as the kernel's module says");
        assert_eq!(push.len(), module.push_bytes as usize, "the push block is filled");
        self.begin(Kind::Compute);
        let layout = module.layout;
        let point = vk::PipelineBindPoint::COMPUTE;
        // SAFETY: the command buffer is recording; pipeline and sets are alive until the submission has been waited for.
        unsafe {
            self.device.cmd_bind_pipeline(self.commands, point, pipeline.raw);
            for set in sets {
                self.device.cmd_bind_descriptor_sets(self.commands, point, layout, set.index, &[set.raw], &[]);
            }
            self.device.cmd_push_constants(self.commands, layout, vk::ShaderStageFlags::COMPUTE, 0, push);
            self.device.cmd_dispatch(self.commands, groups[0], groups[1], groups[2]);
        }
    }

    /// Copies a byte range of one buffer to the byte `at` of another.
    ///
    /// # Panics
    /// If either buffer is too small.
    pub fn copy_range(&mut self, from: &'a Buffer, range: Range<u64>, to: &'a Buffer, at: u64) {
        let size = range.end - range.start;
        assert!(range.end <= from.size() && at + size <= to.size(), "a copy stays inside its buffers");
        if size == 0 {
            return;
        }
        self.begin(Kind::Transfer);
        let region = [vk::BufferCopy::default().src_offset(range.start).dst_offset(at).size(size)];
        // SAFETY: as above; the region lies inside both buffers.
        unsafe { self.device.cmd_copy_buffer(self.commands, from.raw, to.raw, &region) };
    }

    /// Copies all of a buffer to the place `at` of another, of at least that size, which was made elsewhere.
    #[cfg(target_os = "linux")]
    pub(crate) fn copy_out(&mut self, from: &'a Buffer, to: vk::Buffer, at: u64) {
        self.begin(Kind::Transfer);
        let region = [vk::BufferCopy::default().dst_offset(at).size(from.size())];
        // SAFETY: as above; whoever calls sees to it that the other buffer lives and is large enough.
        unsafe { self.device.cmd_copy_buffer(self.commands, from.raw, to, &region) };
    }

    /// Fills a buffer with zeros.
    pub fn clear(&mut self, buffer: &'a Buffer) {
        self.begin(Kind::Transfer);
        // SAFETY: as above.
        unsafe { self.device.cmd_fill_buffer(self.commands, buffer.raw, 0, vk::WHOLE_SIZE, 0) };
    }

    /// Records builds or copies of structures by `record`, which is given the command buffer.
    pub(crate) fn build(&mut self, record: impl FnOnce(vk::CommandBuffer)) {
        self.begin(Kind::Build);
        record(self.commands);
    }

    fn begin(&mut self, kind: Kind) {
        if let Some(last) = self.last.replace(kind) {
            self.barrier(last, kind.stage(), kind.reads() | kind.writes());
        }
    }

    /// Makes the results visible to the host; structures, which only kernels and builds read, to those of later submissions.
    fn finish(&mut self) {
        let Some(last) = self.last else { return };
        if last == Kind::Build {
            let stages = vk::PipelineStageFlags::COMPUTE_SHADER | Kind::Build.stage();
            self.barrier(last, stages, vk::AccessFlags::ACCELERATION_STRUCTURE_READ_KHR);
        } else {
            self.barrier(last, vk::PipelineStageFlags::HOST, vk::AccessFlags::HOST_READ);
        }
    }

    fn barrier(&self, last: Kind, stage: vk::PipelineStageFlags, access: vk::AccessFlags) {
        let memory = [vk::MemoryBarrier::default().src_access_mask(last.writes()).dst_access_mask(access)];
        let none = vk::DependencyFlags::empty();
        // SAFETY: the command buffer is recording.
        unsafe {
            self.device.cmd_pipeline_barrier(self.commands, last.stage(), stage, none, &memory, &[], &[]);
        }
    }
}
