//! Devices of the library, and filters that run on them.

use std::ffi::{CStr, c_void};
use std::sync::Arc;

use crate::library::{CPU, DEVICE_STORAGE, FLOAT3, Handle, Library, text};
use crate::{DenoiseError, Gpu, Interface};

/// Device of the library.
pub struct Device {
    pub library: Arc<Library>,
    pub raw: Handle,
    pub interface: Interface,
}

// SAFETY: the library synchronises what is called on a device from several threads, says its documentation.
unsafe impl Send for Device {}
// SAFETY: as above.
unsafe impl Sync for Device {}

impl Device {
    /// The CPU, which reads and writes the host's memory.
    pub fn cpu(library: Arc<Library>) -> Result<Self, DenoiseError> {
        // SAFETY: a plain call; the handle is released when it is dropped.
        let raw = unsafe { (library.new_device)(CPU) };
        Self::ready(library, raw)
    }

    /// The library's device that is `gpu`.
    pub fn gpu(library: Arc<Library>, gpu: &Gpu) -> Result<Self, DenoiseError> {
        // SAFETY: the library reads 16 and 8 bytes; the handle is released when it is dropped.
        let raw = unsafe {
            let by_luid = || gpu.luid.and_then(|luid| (library.new_device_by_luid)(luid.as_ptr().cast()));
            (library.new_device_by_uuid)(gpu.uuid.as_ptr().cast()).or_else(by_luid)
        };
        Self::ready(library, raw)
    }

    fn ready(library: Arc<Library>, raw: Option<Handle>) -> Result<Self, DenoiseError> {
        let raw = raw.ok_or_else(|| library.failed(None))?;
        let mut device = Self { library, raw, interface: Interface::Cpu };
        // SAFETY: the device is new and has no settings that could be wrong.
        unsafe { (device.library.commit_device)(raw) };
        device.check()?;
        device.interface = Interface::of(device.int(c"type"));
        Ok(device)
    }

    /// Property of the device.
    pub fn int(&self, name: &CStr) -> i32 {
        // SAFETY: the device lives; of properties that it does not have the library says 0.
        unsafe { (self.library.device_int)(self.raw, name.as_ptr()) }
    }

    /// Runs the ray-tracing filter over `inputs`, each `width` times `height` pixels, with the named `switches` on.
    pub fn filter(
        &self,
        [width, height]: [usize; 2],
        inputs: &[(&str, &[[f32; 3]])],
        switches: &[&str],
    ) -> Result<Vec<[f32; 3]>, DenoiseError> {
        assert!(inputs.iter().all(|(_, pixels)| pixels.len() == width * height), "lists of equal length");
        let mut output = vec![[0f32; 3]; width * height];
        let filter = Filter::new(self)?;
        let mut lent = vec![];
        for (name, pixels) in inputs {
            let pixels: &[f32] = pixels.as_flattened();
            if self.interface == Interface::Cpu {
                filter.set_host_image(name, pixels.as_ptr().cast_mut().cast(), [width, height]);
            } else {
                let buffer = Buffer::new(self, size_of_val(pixels))?;
                buffer.write(pixels);
                filter.set_image(name, &buffer, [width, height], 0);
                lent.push(buffer);
            }
        }
        let result = match self.interface {
            Interface::Cpu => {
                filter.set_host_image("output", output.as_mut_ptr().cast(), [width, height]);
                None
            }
            _ => {
                let buffer = Buffer::new(self, size_of_val(output.as_slice()))?;
                filter.set_image("output", &buffer, [width, height], 0);
                Some(buffer)
            }
        };
        switches.iter().for_each(|switch| filter.set_bool(switch));
        filter.commit()?;
        filter.execute()?;
        if let Some(result) = result {
            result.read(output.as_flattened_mut());
            self.check()?;
        }
        Ok(output)
    }

    /// Error of what has been done since the last question.
    pub fn check(&self) -> Result<(), DenoiseError> {
        self.library.error(Some(self.raw)).map_or(Ok(()), |message| Err(DenoiseError::Failed(message)))
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: nothing else holds it, and what was made of it keeps a share of its own.
        unsafe { (self.library.release_device)(self.raw) };
    }
}

/// Memory of a device.
pub struct Buffer<'a> {
    device: &'a Device,
    pub raw: Handle,
}

impl<'a> Buffer<'a> {
    fn new(device: &'a Device, bytes: usize) -> Result<Self, DenoiseError> {
        // SAFETY: the device lives; the handle is released when it is dropped.
        let raw = unsafe { (device.library.new_buffer)(device.raw, bytes, DEVICE_STORAGE) };
        let buffer = Self { device, raw: raw.ok_or_else(|| device.library.failed(Some(device.raw)))? };
        device.check()?;
        Ok(buffer)
    }

    fn write(&self, numbers: &[f32]) {
        // SAFETY: the buffer was made for so many bytes.
        unsafe { (self.device.library.write_buffer)(self.raw, 0, size_of_val(numbers), numbers.as_ptr().cast()) };
    }

    fn read(&self, numbers: &mut [f32]) {
        // SAFETY: the buffer was made for so many bytes.
        unsafe { (self.device.library.read_buffer)(self.raw, 0, size_of_val(numbers), numbers.as_mut_ptr().cast()) };
    }
}

impl Drop for Buffer<'_> {
    fn drop(&mut self) {
        // SAFETY: filters that it is set for keep a share of their own.
        unsafe { (self.device.library.release_buffer)(self.raw) };
    }
}

/// A ray-tracing filter of a device.
struct Filter<'a> {
    device: &'a Device,
    raw: Handle,
}

impl<'a> Filter<'a> {
    fn new(device: &'a Device) -> Result<Self, DenoiseError> {
        Ok(Self { device, raw: new_filter(device)? })
    }

    /// Sets an image in the host's memory, without gaps, which has to live as long as the filter.
    fn set_host_image(&self, name: &str, pixels: *mut c_void, [width, height]: [usize; 2]) {
        let name = text(name);
        // SAFETY: the pixels are as many as the size says and live until the filter is released; strides of 0 stand for
        // pixels without gaps. Inputs are only read.
        unsafe {
            (self.device.library.set_host_image)(self.raw, name.as_ptr(), pixels, FLOAT3, width, height, 0, 0, 0);
        }
    }

    fn set_image(&self, name: &str, buffer: &Buffer, size: [usize; 2], pixel_bytes: usize) {
        set_image(self.device, self.raw, name, buffer.raw, size, pixel_bytes);
    }

    fn set_bool(&self, name: &str) {
        // SAFETY: the filter lives; unknown names are ignored.
        unsafe { (self.device.library.set_bool)(self.raw, text(name).as_ptr(), true) };
    }

    fn commit(&self) -> Result<(), DenoiseError> {
        // SAFETY: the filter lives, and has what it needs.
        unsafe { (self.device.library.commit_filter)(self.raw) };
        self.device.check()
    }

    fn execute(&self) -> Result<(), DenoiseError> {
        // SAFETY: the filter was committed; it is executed on this thread.
        unsafe { (self.device.library.execute_filter)(self.raw) };
        self.device.check()
    }
}

impl Drop for Filter<'_> {
    fn drop(&mut self) {
        // SAFETY: nobody else has it.
        unsafe { (self.device.library.release_filter)(self.raw) };
    }
}

/// New ray-tracing filter of a device.
pub fn new_filter(device: &Device) -> Result<Handle, DenoiseError> {
    // SAFETY: the device lives; the name is one of the library's filters.
    let raw = unsafe { (device.library.new_filter)(device.raw, c"RT".as_ptr()) };
    raw.ok_or_else(|| device.library.failed(Some(device.raw)))
}

/// Sets an image of a filter in a buffer of the device; pixels are `pixel_bytes` apart, and without gaps where that is 0.
pub fn set_image(
    device: &Device,
    filter: Handle,
    name: &str,
    buffer: Handle,
    [width, height]: [usize; 2],
    pixel_bytes: usize,
) {
    let name = text(name);
    // SAFETY: filter and buffer live; the library refuses images that reach past the end of a buffer.
    unsafe {
        (device.library.set_image)(filter, name.as_ptr(), buffer, FLOAT3, width, height, 0, pixel_bytes, 0);
    }
}
