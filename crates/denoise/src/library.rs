//! The C interface of the library, as far as it is needed (`OpenImageDenoise/oidn.h`, version 2).

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::Path;
use std::ptr::NonNull;

use crate::DenoiseError;

type Handle = NonNull<c_void>;

/// Device type `OIDN_DEVICE_TYPE_CPU`: it reads and writes the host's memory.
const CPU: c_int = 1;
/// Pixel format `OIDN_FORMAT_FLOAT3`.
const FLOAT3: c_int = 3;

/// Functions of the loaded library, which stays loaded as long as they are here.
pub struct Library {
    new_device: unsafe extern "C" fn(c_int) -> Option<Handle>,
    commit_device: unsafe extern "C" fn(Handle),
    release_device: unsafe extern "C" fn(Handle),
    device_error: unsafe extern "C" fn(Option<Handle>, *mut *const c_char) -> c_int,
    device_int: unsafe extern "C" fn(Handle, *const c_char) -> c_int,
    new_filter: unsafe extern "C" fn(Handle, *const c_char) -> Option<Handle>,
    release_filter: unsafe extern "C" fn(Handle),
    #[allow(clippy::type_complexity)] // As the header has it.
    set_image: unsafe extern "C" fn(Handle, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize),
    set_bool: unsafe extern "C" fn(Handle, *const c_char, bool),
    commit_filter: unsafe extern "C" fn(Handle),
    execute_filter: unsafe extern "C" fn(Handle),
    _library: libloading::Library,
}

impl Library {
    /// Loads the library at `path`. Fails, in the system's words, if there is none or it is not of version 2.
    pub fn open(path: &Path) -> Result<Self, String> {
        // SAFETY: the library's constructors do nothing but prepare it; the types are those of its header, and the names
        // exist in this form since version 2.
        unsafe {
            let library = libloading::Library::new(path).map_err(|e| e.to_string())?;
            macro_rules! function {
                ($name:literal) => {
                    *library.get($name).map_err(|e| e.to_string())?
                };
            }
            Ok(Self {
                new_device: function!(b"oidnNewDevice\0"),
                commit_device: function!(b"oidnCommitDevice\0"),
                release_device: function!(b"oidnReleaseDevice\0"),
                device_error: function!(b"oidnGetDeviceError\0"),
                device_int: function!(b"oidnGetDeviceInt\0"),
                new_filter: function!(b"oidnNewFilter\0"),
                release_filter: function!(b"oidnReleaseFilter\0"),
                set_image: function!(b"oidnSetSharedFilterImage\0"),
                set_bool: function!(b"oidnSetFilterBool\0"),
                commit_filter: function!(b"oidnCommitFilter\0"),
                execute_filter: function!(b"oidnExecuteFilter\0"),
                _library: library,
            })
        }
    }
}

/// Device of the library that stands for the CPU.
pub struct Device {
    library: Library,
    raw: Handle,
}

// SAFETY: the library synchronises what is called on a device from several threads, says its documentation.
unsafe impl Send for Device {}

impl Device {
    pub fn new(library: Library) -> Result<Self, DenoiseError> {
        // SAFETY: a plain call; the handle is released when it is dropped.
        let raw = unsafe { (library.new_device)(CPU) };
        let Some(raw) = raw else { return Err(failed(&library, None)) };
        let device = Self { library, raw };
        // SAFETY: the device is new and has no settings that could be wrong.
        unsafe { (device.library.commit_device)(raw) };
        device.check()?;
        Ok(device)
    }

    /// Version of the library in one number: its parts are the ten thousands, the hundreds and the ones.
    pub fn version(&self) -> i32 {
        // SAFETY: the device lives, and every device has this property.
        unsafe { (self.library.device_int)(self.raw, c"version".as_ptr()) }
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
        // SAFETY: the device lives; the name is one of the library's filters.
        let filter = unsafe { (self.library.new_filter)(self.raw, c"RT".as_ptr()) };
        let Some(filter) = filter else { return Err(failed(&self.library, Some(self.raw))) };

        let image = |name: &str, pixels: *mut c_void| {
            let name = text(name);
            // SAFETY: the pixels are as many as the size says and live until the filter is released, below; strides of 0
            // stand for pixels without gaps. Inputs are only read.
            unsafe { (self.library.set_image)(filter, name.as_ptr(), pixels, FLOAT3, width, height, 0, 0, 0) };
        };
        for (name, pixels) in inputs {
            image(name, pixels.as_ptr().cast_mut().cast());
        }
        image("output", output.as_mut_ptr().cast());
        for switch in switches {
            let name = text(switch);
            // SAFETY: the filter lives; unknown names are ignored.
            unsafe { (self.library.set_bool)(filter, name.as_ptr(), true) };
        }
        // SAFETY: the filter has what it needs; it is executed on this thread, and released once, here.
        unsafe {
            (self.library.commit_filter)(filter);
            (self.library.execute_filter)(filter);
            (self.library.release_filter)(filter);
        }
        self.check()?;
        Ok(output)
    }

    fn check(&self) -> Result<(), DenoiseError> {
        error_of(&self.library, Some(self.raw)).map_or(Ok(()), |message| Err(DenoiseError::Failed(message)))
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: nothing else holds it, and its filters are gone.
        unsafe { (self.library.release_device)(self.raw) };
    }
}

fn failed(library: &Library, device: Option<Handle>) -> DenoiseError {
    DenoiseError::Failed(error_of(library, device).unwrap_or_else(|| "it gives no reason".into()))
}

/// Message of the first error since the last question; without a device, of this thread's first error.
fn error_of(library: &Library, device: Option<Handle>) -> Option<String> {
    let mut message = std::ptr::null();
    // SAFETY: the library sets the message to a string that lives until the next call, or leaves it.
    unsafe {
        let code = (library.device_error)(device, &mut message);
        let told = (!message.is_null()).then(|| CStr::from_ptr(message).to_string_lossy().into_owned());
        (code != 0).then(|| told.unwrap_or_else(|| format!("error {code}")))
    }
}

fn text(name: &str) -> CString {
    CString::new(name).unwrap_or_default()
}
