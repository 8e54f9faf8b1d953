//! Pictures in memory that the denoiser's GPU shares with whoever renders on it: nothing goes through the host.

use std::os::fd::{AsRawFd, IntoRawFd, OwnedFd};
use std::sync::Arc;

use crate::device::{Device, new_filter, set_image};
use crate::library::{Handle, OPAQUE_FD, text};
use crate::{Care, DenoiseError};

/// Bytes of a pixel of shared images: red, green, blue (or x, y, z), and a float that nobody reads.
pub const SHARED_PIXEL_BYTES: usize = 16;

/// Memory of a GPU that another interface to it has exported, with an image from its beginning on.
#[derive(Debug)]
pub struct SharedImage {
    /// Opaque handle of the memory, as Vulkan exports it.
    pub memory: OwnedFd,
    /// Bytes that were allocated.
    pub bytes: u64,
}

/// Images of a picture, row by row from the top left, [`SHARED_PIXEL_BYTES`] a pixel.
#[derive(Debug)]
pub struct SharedImages {
    /// Linear radiance of any brightness.
    pub color: SharedImage,
    /// Albedo of the first surfaces, 0 to 1.
    pub albedo: SharedImage,
    /// Normals of the first surfaces, -1 to 1.
    pub normal: SharedImage,
    /// Image for the picture without its noise.
    pub output: SharedImage,
}

/// A picture whose images the denoiser and somebody else share.
pub struct SharedPicture {
    device: Arc<Device>,
    size: [usize; 2],
    /// Images: color, albedo, normal, output.
    buffers: Vec<Handle>,
    /// Filters of quick work, and of thorough work, in the order in which they run; none as long as nobody asked for it.
    quick: Vec<Handle>,
    thorough: Vec<Handle>,
}

// SAFETY: handles may be used from any thread, one at a time.
unsafe impl Send for SharedPicture {}

/// Place of each image among the buffers.
const COLOR: usize = 0;
const ALBEDO: usize = 1;
const NORMAL: usize = 2;
const OUTPUT: usize = 3;

/// Quality `OIDN_QUALITY_HIGH`.
const HIGH: i32 = 6;

impl SharedPicture {
    pub(crate) fn new(device: Arc<Device>, size: [usize; 2], images: SharedImages) -> Result<Self, DenoiseError> {
        // From here on `Drop` cleans up.
        let mut picture = Self { device, size, buffers: vec![], quick: vec![], thorough: vec![] };
        let SharedImages { color, albedo, normal, output } = images;
        for SharedImage { memory, bytes } in [color, albedo, normal, output] {
            let (device, bytes) = (&picture.device, bytes as usize);
            if bytes < SHARED_PIXEL_BYTES * size[0] * size[1] {
                return Err(DenoiseError::Size { width: size[0], height: size[1], found: bytes / SHARED_PIXEL_BYTES });
            }
            // SAFETY: the handle is good, and of so many bytes.
            let raw = unsafe { (device.library.new_buffer_from_fd)(device.raw, OPAQUE_FD, memory.as_raw_fd(), bytes) };
            picture.buffers.push(raw.ok_or_else(|| device.library.failed(Some(device.raw)))?);
            picture.device.check()?;
            // Who has imported it owns it.
            let _ = memory.into_raw_fd();
        }
        Ok(picture)
    }

    /// Removes the noise of what is in the color image by now, and waits for it. Whoever wrote images has to have waited for
    /// that too. Thorough work changes albedo and normals.
    ///
    /// # Errors
    /// A [`DenoiseError`] when the library fails, as it does where memory is short.
    pub fn denoise(&mut self, care: Care) -> Result<(), DenoiseError> {
        let filters = match care {
            Care::Quick => &mut self.quick,
            Care::Thorough => &mut self.thorough,
        };
        if filters.is_empty() {
            let (device, buffers, size) = (&self.device, &self.buffers, self.size);
            let mut add = |images: &[(&str, usize)], switches: &[&str], quality: i32| {
                filters.push(new_filter(device)?);
                let filter = filters[filters.len() - 1];
                for (name, image) in images {
                    set_image(device, filter, name, buffers[*image], size, SHARED_PIXEL_BYTES);
                }
                // SAFETY: the filter lives; unknown names are ignored.
                unsafe {
                    switches.iter().for_each(|name| (device.library.set_bool)(filter, text(name).as_ptr(), true));
                    (device.library.set_int)(filter, c"quality".as_ptr(), quality);
                    (device.library.commit_filter)(filter);
                }
                device.check()
            };
            let all = [("color", COLOR), ("albedo", ALBEDO), ("normal", NORMAL), ("output", OUTPUT)];
            let made = match care {
                Care::Quick => add(&all, &["hdr"], HIGH),
                Care::Thorough => add(&[("albedo", ALBEDO), ("output", ALBEDO)], &[], HIGH)
                    .and_then(|()| add(&[("normal", NORMAL), ("output", NORMAL)], &[], HIGH))
                    .and_then(|()| add(&all, &["hdr", "cleanAux"], HIGH)),
            };
            if let Err(error) = made {
                release(&self.device, filters);
                return Err(error);
            }
        }
        for filter in filters {
            // SAFETY: the filter was committed, and its buffers live.
            unsafe { (self.device.library.execute_filter)(*filter) };
        }
        self.device.check()
    }
}

fn release(device: &Device, filters: &mut Vec<Handle>) {
    // SAFETY: nobody else has them.
    filters.drain(..).for_each(|filter| unsafe { (device.library.release_filter)(filter) });
}

impl Drop for SharedPicture {
    fn drop(&mut self) {
        release(&self.device, &mut self.quick);
        release(&self.device, &mut self.thorough);
        // SAFETY: filters that used them are gone, and nobody else has them.
        self.buffers.drain(..).for_each(|buffer| unsafe { (self.device.library.release_buffer)(buffer) });
    }
}
