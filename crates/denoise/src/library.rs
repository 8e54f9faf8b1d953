//! The C interface of the library, as far as it is needed (`OpenImageDenoise/oidn.h`, version 2).

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::Path;
use std::ptr::NonNull;

use crate::DenoiseError;

pub type Handle = NonNull<c_void>;

/// Device type `OIDN_DEVICE_TYPE_CPU`.
pub const CPU: c_int = 1;
/// Pixel format `OIDN_FORMAT_FLOAT3`.
pub const FLOAT3: c_int = 3;
/// Storage mode `OIDN_STORAGE_DEVICE`.
pub const DEVICE_STORAGE: c_int = 2;
/// External memory type `OIDN_EXTERNAL_MEMORY_TYPE_FLAG_OPAQUE_FD`.
#[cfg(unix)]
pub const OPAQUE_FD: c_int = 1;

/// Functions of the loaded library, which stays loaded as long as they are here.
pub struct Library {
    pub new_device: unsafe extern "C" fn(c_int) -> Option<Handle>,
    pub new_device_by_uuid: unsafe extern "C" fn(*const c_void) -> Option<Handle>,
    pub new_device_by_luid: unsafe extern "C" fn(*const c_void) -> Option<Handle>,
    pub count_devices: unsafe extern "C" fn() -> c_int,
    pub physical_int: unsafe extern "C" fn(c_int, *const c_char) -> c_int,
    pub physical_bool: unsafe extern "C" fn(c_int, *const c_char) -> bool,
    pub physical_string: unsafe extern "C" fn(c_int, *const c_char) -> *const c_char,
    pub physical_data: unsafe extern "C" fn(c_int, *const c_char, *mut usize) -> *const c_void,
    pub commit_device: unsafe extern "C" fn(Handle),
    pub release_device: unsafe extern "C" fn(Handle),
    device_error: unsafe extern "C" fn(Option<Handle>, *mut *const c_char) -> c_int,
    pub device_int: unsafe extern "C" fn(Handle, *const c_char) -> c_int,
    pub new_buffer: unsafe extern "C" fn(Handle, usize, c_int) -> Option<Handle>,
    #[cfg(unix)]
    pub new_buffer_from_fd: unsafe extern "C" fn(Handle, c_int, c_int, usize) -> Option<Handle>,
    pub read_buffer: unsafe extern "C" fn(Handle, usize, usize, *mut c_void),
    pub write_buffer: unsafe extern "C" fn(Handle, usize, usize, *const c_void),
    pub release_buffer: unsafe extern "C" fn(Handle),
    pub new_filter: unsafe extern "C" fn(Handle, *const c_char) -> Option<Handle>,
    pub release_filter: unsafe extern "C" fn(Handle),
    #[allow(clippy::type_complexity)] // As the header has it.
    pub set_image: unsafe extern "C" fn(Handle, *const c_char, Handle, c_int, usize, usize, usize, usize, usize),
    #[allow(clippy::type_complexity)] // As the header has it.
    pub set_host_image:
        unsafe extern "C" fn(Handle, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize),
    pub set_bool: unsafe extern "C" fn(Handle, *const c_char, bool),
    pub set_int: unsafe extern "C" fn(Handle, *const c_char, c_int),
    pub commit_filter: unsafe extern "C" fn(Handle),
    pub execute_filter: unsafe extern "C" fn(Handle),
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
                new_device_by_uuid: function!(b"oidnNewDeviceByUUID\0"),
                new_device_by_luid: function!(b"oidnNewDeviceByLUID\0"),
                count_devices: function!(b"oidnGetNumPhysicalDevices\0"),
                physical_int: function!(b"oidnGetPhysicalDeviceInt\0"),
                physical_bool: function!(b"oidnGetPhysicalDeviceBool\0"),
                physical_string: function!(b"oidnGetPhysicalDeviceString\0"),
                physical_data: function!(b"oidnGetPhysicalDeviceData\0"),
                commit_device: function!(b"oidnCommitDevice\0"),
                release_device: function!(b"oidnReleaseDevice\0"),
                device_error: function!(b"oidnGetDeviceError\0"),
                device_int: function!(b"oidnGetDeviceInt\0"),
                new_buffer: function!(b"oidnNewBufferWithStorage\0"),
                #[cfg(unix)]
                new_buffer_from_fd: function!(b"oidnNewSharedBufferFromFD\0"),
                read_buffer: function!(b"oidnReadBuffer\0"),
                write_buffer: function!(b"oidnWriteBuffer\0"),
                release_buffer: function!(b"oidnReleaseBuffer\0"),
                new_filter: function!(b"oidnNewFilter\0"),
                release_filter: function!(b"oidnReleaseFilter\0"),
                set_image: function!(b"oidnSetFilterImage\0"),
                set_host_image: function!(b"oidnSetSharedFilterImage\0"),
                set_bool: function!(b"oidnSetFilterBool\0"),
                set_int: function!(b"oidnSetFilterInt\0"),
                commit_filter: function!(b"oidnCommitFilter\0"),
                execute_filter: function!(b"oidnExecuteFilter\0"),
                _library: library,
            })
        }
    }

    /// Message of the first error since the last question: of a device, or of this thread where it has to do with none.
    pub fn error(&self, device: Option<Handle>) -> Option<String> {
        let mut message = std::ptr::null();
        // SAFETY: the library sets the message to a string that lives until the next call, or leaves it.
        unsafe {
            let code = (self.device_error)(device, &raw mut message);
            let told = (!message.is_null()).then(|| CStr::from_ptr(message).to_string_lossy().into_owned());
            (code != 0).then(|| told.unwrap_or_else(|| format!("error {code}")))
        }
    }

    /// Failure of what has just been tried.
    pub fn failed(&self, device: Option<Handle>) -> DenoiseError {
        DenoiseError::Failed(self.error(device).unwrap_or_else(|| "it gives no reason".into()))
    }
}

pub fn text(name: &str) -> CString {
    CString::new(name).unwrap_or_default()
}
