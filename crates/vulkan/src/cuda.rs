//! CUDA's driver interface, as far as it takes to hand memory to programs of CUDA on the same device. It is found while the
//! program runs: those who have no such device need not have it.

use std::collections::HashMap;
use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::os::fd::IntoRawFd;
use std::sync::{Mutex, OnceLock, PoisonError};

use crate::device::Device;
use crate::error::VulkanError;
use crate::exported::ExportedBuffer;

/// Bytes of a pixel's sums, as films have them: five sums of three words and three counts, of which the first is that of the
/// samples.
pub const SUM_BYTES: u64 = 72;
/// Place of the number of samples in them.
pub const SAMPLES_OFFSET: u64 = 60;

/// Means of the sums, three floats a pixel: what `FixedSum::value` does on the host, bit for bit.
const MEANS: &CStr = c"
.version 6.0
.target sm_50
.address_size 64
.visible .entry means(.param .u64 sums, .param .u64 means, .param .u64 count)
{
    .reg .pred %beyond;
    .reg .b32 %r<7>;
    .reg .b64 %d<6>;
    .reg .f64 %f<4>;
    .reg .f32 %mean;
    mov.u32 %r0, %ctaid.x;
    mov.u32 %r1, %ntid.x;
    mov.u32 %r2, %tid.x;
    mul.wide.u32 %d0, %r0, %r1;
    cvt.u64.u32 %d1, %r2;
    add.u64 %d0, %d0, %d1;
    ld.param.u64 %d2, [count];
    setp.ge.u64 %beyond, %d0, %d2;
    @%beyond bra DONE;
    ld.param.u64 %d3, [sums];
    ld.param.u64 %d4, [means];
    mad.lo.u64 %d3, %d0, 72, %d3;
    mad.lo.u64 %d4, %d0, 12, %d4;
    ld.global.u32 %r3, [%d3+60];
    max.u32 %r3, %r3, 1;
    cvt.rn.f64.u32 %f0, %r3;
    mov.u32 %r0, 0;
CHANNEL:
    ld.global.u32 %r4, [%d3];
    ld.global.u32 %r5, [%d3+4];
    ld.global.u32 %r6, [%d3+8];
    mov.b64 %d5, {%r5, %r6};
    cvt.rn.f64.s64 %f1, %d5;
    cvt.rn.f64.u32 %f2, %r4;
    fma.rn.f64 %f1, %f1, 0d41F0000000000000, %f2;
    mul.rn.f64 %f1, %f1, 0d3D70000000000000;
    div.rn.f64 %f1, %f1, %f0;
    cvt.rn.f32.f64 %mean, %f1;
    st.global.f32 [%d4], %mean;
    add.u64 %d3, %d3, 12;
    add.u64 %d4, %d4, 4;
    add.u32 %r0, %r0, 1;
    setp.lt.u32 %beyond, %r0, 3;
    @%beyond bra CHANNEL;
DONE:
    ret;
}
";
/// Threads of a block.
const THREADS: u32 = 256;

/// Handle type `CU_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD`.
const OPAQUE_FD: c_uint = 1;
/// Flag `CUDA_EXTERNAL_MEMORY_DEDICATED`.
const DEDICATED: c_uint = 1;

type Handle = *mut c_void;
type Answer = c_int;

/// `CUDA_EXTERNAL_MEMORY_HANDLE_DESC`, whose union holds a file descriptor.
#[repr(C)]
struct HandleDescription {
    kind: c_uint,
    _padding: c_uint,
    descriptor: c_int,
    _rest: [c_int; 3],
    size: u64,
    flags: c_uint,
    _reserved: [c_uint; 16],
}

const _: () = assert!(size_of::<HandleDescription>() == 104 && size_of::<BufferDescription>() == 88);

/// `CUDA_EXTERNAL_MEMORY_BUFFER_DESC`.
#[repr(C)]
struct BufferDescription {
    offset: u64,
    size: u64,
    flags: c_uint,
    _reserved: [c_uint; 16],
}

/// Functions of the driver, which stays loaded.
struct Driver {
    device_count: unsafe extern "C" fn(*mut c_int) -> Answer,
    device_uuid: unsafe extern "C" fn(*mut [u8; 16], c_int) -> Answer,
    retain_context: unsafe extern "C" fn(*mut Handle, c_int) -> Answer,
    push_context: unsafe extern "C" fn(Handle) -> Answer,
    pop_context: unsafe extern "C" fn(*mut Handle) -> Answer,
    allocate: unsafe extern "C" fn(*mut u64, usize) -> Answer,
    free: unsafe extern "C" fn(u64) -> Answer,
    copy_in: unsafe extern "C" fn(u64, *const c_void, usize) -> Answer,
    import: unsafe extern "C" fn(*mut Handle, *const HandleDescription) -> Answer,
    map: unsafe extern "C" fn(*mut u64, Handle, *const BufferDescription) -> Answer,
    forget: unsafe extern "C" fn(Handle) -> Answer,
    load: unsafe extern "C" fn(*mut Handle, *const c_char) -> Answer,
    function: unsafe extern "C" fn(*mut Handle, Handle, *const c_char) -> Answer,
    #[allow(clippy::type_complexity)] // As the header has it.
    launch: unsafe extern "C" fn(
        Handle,
        c_uint,
        c_uint,
        c_uint,
        c_uint,
        c_uint,
        c_uint,
        c_uint,
        Handle,
        *mut *mut c_void,
        *mut *mut c_void,
    ) -> Answer,
    synchronize: unsafe extern "C" fn() -> Answer,
    error_name: unsafe extern "C" fn(Answer, *mut *const c_char) -> Answer,
    contexts: Mutex<HashMap<u32, Context>>,
    _library: libloading::Library,
}

/// A device's primary context, which all libraries in the process share, and the kernel in it.
#[derive(Clone, Copy)]
struct Context {
    raw: Handle,
    means: Handle,
}

// SAFETY: handles of contexts and functions may be used from any thread, says the driver's documentation.
unsafe impl Send for Context {}

/// The driver, if it is here and works, or the reason why not.
fn driver() -> Result<&'static Driver, VulkanError> {
    static DRIVER: OnceLock<Result<Driver, String>> = OnceLock::new();
    DRIVER.get_or_init(Driver::open).as_ref().map_err(|reason| VulkanError::Cuda(reason.clone()))
}

impl Driver {
    fn open() -> Result<Self, String> {
        let name = if cfg!(windows) { "nvcuda.dll" } else { "libcuda.so.1" };
        // SAFETY: the driver's constructors do nothing but prepare it; names and types are those of `cuda.h` since version 11.
        unsafe {
            let library = libloading::Library::new(name).map_err(|e| format!("there is no driver ({e})"))?;
            macro_rules! function {
                ($name:literal) => {
                    *library.get($name).map_err(|e| e.to_string())?
                };
            }
            let start: unsafe extern "C" fn(c_uint) -> Answer = function!(b"cuInit\0");
            let driver = Self {
                device_count: function!(b"cuDeviceGetCount\0"),
                device_uuid: function!(b"cuDeviceGetUuid\0"),
                retain_context: function!(b"cuDevicePrimaryCtxRetain\0"),
                push_context: function!(b"cuCtxPushCurrent_v2\0"),
                pop_context: function!(b"cuCtxPopCurrent_v2\0"),
                allocate: function!(b"cuMemAlloc_v2\0"),
                free: function!(b"cuMemFree_v2\0"),
                copy_in: function!(b"cuMemcpyHtoD_v2\0"),
                import: function!(b"cuImportExternalMemory\0"),
                map: function!(b"cuExternalMemoryGetMappedBuffer\0"),
                forget: function!(b"cuDestroyExternalMemory\0"),
                load: function!(b"cuModuleLoadData\0"),
                function: function!(b"cuModuleGetFunction\0"),
                launch: function!(b"cuLaunchKernel\0"),
                synchronize: function!(b"cuCtxSynchronize\0"),
                error_name: function!(b"cuGetErrorName\0"),
                contexts: Mutex::default(),
                _library: library,
            };
            driver.check("cuInit", start(0)).map_err(|error| error.to_string())?;
            Ok(driver)
        }
    }

    fn check(&self, call: &str, answer: Answer) -> Result<(), VulkanError> {
        if answer == 0 {
            return Ok(());
        }
        let mut name = std::ptr::null();
        // SAFETY: the name, if there is one, is a constant of the driver's.
        let name = unsafe {
            let known = (self.error_name)(answer, &raw mut name) == 0 && !name.is_null();
            if known { CStr::from_ptr(name).to_string_lossy().into_owned() } else { answer.to_string() }
        };
        Err(VulkanError::Cuda(format!("{call}: {name}")))
    }

    fn devices(&self) -> Result<u32, VulkanError> {
        let mut count = 0;
        // SAFETY: the driver writes one number.
        self.check("cuDeviceGetCount", unsafe { (self.device_count)(&raw mut count) })?;
        Ok(count.max(0) as u32)
    }

    /// The device of this UUID.
    fn ordinal(&self, uuid: [u8; 16]) -> Result<u32, VulkanError> {
        for ordinal in 0..self.devices()? {
            let mut found = [0; 16];
            // SAFETY: the driver writes 16 bytes.
            self.check("cuDeviceGetUuid", unsafe { (self.device_uuid)(&raw mut found, ordinal as c_int) })?;
            if found == uuid {
                return Ok(ordinal);
            }
        }
        Err(VulkanError::Cuda("the device is none of CUDA's".into()))
    }

    /// Does `work` in the primary context of a device.
    fn within<T>(&self, ordinal: u32, work: impl FnOnce(Context) -> Result<T, VulkanError>) -> Result<T, VulkanError> {
        let mut contexts = self.contexts.lock().unwrap_or_else(PoisonError::into_inner);
        let known = contexts.get(&ordinal).copied();
        let raw = match known {
            Some(context) => context.raw,
            None => {
                let mut raw = std::ptr::null_mut();
                // SAFETY: the driver writes a handle; the context is kept for as long as the process lives.
                let answer = unsafe { (self.retain_context)(&raw mut raw, ordinal as c_int) };
                self.check("cuDevicePrimaryCtxRetain", answer)?;
                raw
            }
        };
        // SAFETY: the context is alive; what was current before becomes so again below.
        self.check("cuCtxPushCurrent", unsafe { (self.push_context)(raw) })?;
        let done = known.map_or_else(|| self.prepare(raw), Ok).and_then(|context| {
            contexts.insert(ordinal, context);
            work(context)
        });
        let mut popped = std::ptr::null_mut();
        // SAFETY: what was pushed above is popped.
        let answer = unsafe { (self.pop_context)(&raw mut popped) };
        done.and_then(|done| self.check("cuCtxPopCurrent", answer).map(|()| done))
    }

    /// Loads the kernel into the current context.
    fn prepare(&self, raw: Handle) -> Result<Context, VulkanError> {
        let (mut module, mut means) = (std::ptr::null_mut(), std::ptr::null_mut());
        // SAFETY: the text ends with a zero, and the module has a function of this name.
        unsafe {
            self.check("cuModuleLoadData", (self.load)(&raw mut module, MEANS.as_ptr()))?;
            self.check("cuModuleGetFunction", (self.function)(&raw mut means, module, c"means".as_ptr()))?;
        }
        Ok(Context { raw, means })
    }

    /// Memory of the current context.
    fn allocate(&'static self, ordinal: u32, bytes: usize) -> Result<CudaMemory, VulkanError> {
        let mut pointer = 0;
        // SAFETY: the driver writes an address; `Drop` frees it.
        self.check("cuMemAlloc", unsafe { (self.allocate)(&raw mut pointer, bytes.max(4)) })?;
        Ok(CudaMemory { driver: self, ordinal, pointer })
    }

    /// Means of the sums of `pixels` pixels at the address `sums`.
    fn means(&'static self, context: Context, ordinal: u32, sums: u64, pixels: u64) -> Result<CudaMemory, VulkanError> {
        let means = self.allocate(ordinal, pixels as usize * 3 * size_of::<f32>())?;
        let blocks = u32::try_from(pixels.div_ceil(THREADS.into())).unwrap_or(u32::MAX).max(1);
        let mut arguments = [sums, means.pointer, pixels];
        let mut places = arguments.each_mut().map(|argument| std::ptr::from_mut(argument).cast::<c_void>());
        let (none, stream) = (std::ptr::null_mut(), std::ptr::null_mut());
        // SAFETY: the kernel takes three numbers of 64 bits, reads the sums and writes the means of so many pixels.
        unsafe {
            let launched =
                (self.launch)(context.means, blocks, 1, 1, THREADS, 1, 1, 0, stream, places.as_mut_ptr(), none);
            self.check("cuLaunchKernel", launched)?;
            self.check("cuCtxSynchronize", (self.synchronize)())?;
        }
        Ok(means)
    }
}

/// Memory of a device of CUDA.
pub struct CudaMemory {
    driver: &'static Driver,
    ordinal: u32,
    pointer: u64,
}

impl CudaMemory {
    /// Number of CUDA's devices; an error says why there are none.
    ///
    /// # Errors
    /// A [`VulkanError::Cuda`] where there is no driver, or it does not work.
    pub fn devices() -> Result<u32, VulkanError> {
        driver()?.devices()
    }

    /// Whether CUDA has the device too.
    pub fn knows(device: &Device) -> bool {
        driver().and_then(|driver| driver.ordinal(device.physical().uuid)).is_ok()
    }

    /// Copies numbers to the device that CUDA calls `ordinal`.
    ///
    /// # Errors
    /// A [`VulkanError::Cuda`] where there is no such device, or it has no memory left.
    pub fn upload(numbers: &[f32], ordinal: u32) -> Result<Self, VulkanError> {
        let driver = driver()?;
        let devices = driver.devices()?;
        if ordinal >= devices {
            return Err(VulkanError::Cuda(format!("there is no device {ordinal}: this machine has {devices}")));
        }
        driver.within(ordinal, |_| {
            let memory = driver.allocate(ordinal, size_of_val(numbers))?;
            // SAFETY: as many bytes were allocated.
            let answer = unsafe { (driver.copy_in)(memory.pointer, numbers.as_ptr().cast(), size_of_val(numbers)) };
            driver.check("cuMemcpyHtoD", answer).map(|()| memory)
        })
    }

    /// Means of the sums in `film`, three floats a pixel, on the same device without a way through the host.
    ///
    /// # Errors
    /// A [`VulkanError`] where CUDA does not have the device, or no memory is left.
    pub fn means_of(film: &ExportedBuffer) -> Result<Self, VulkanError> {
        let driver = driver()?;
        let ordinal = driver.ordinal(film.device_uuid())?;
        let (size, pixels) = (film.allocated_bytes(), film.size() / SUM_BYTES);
        let descriptor = film.handle()?;
        driver.within(ordinal, |context| {
            let description = HandleDescription {
                kind: OPAQUE_FD,
                _padding: 0,
                // The driver takes it over.
                descriptor: descriptor.into_raw_fd(),
                _rest: [0; 3],
                size,
                flags: DEDICATED,
                _reserved: [0; 16],
            };
            let part = BufferDescription { offset: 0, size: film.size(), flags: 0, _reserved: [0; 16] };
            let (mut external, mut sums) = (std::ptr::null_mut(), 0);
            // SAFETY: the descriptions are of memory that `film` has exported and keeps; what is imported is given back below.
            unsafe {
                driver.check("cuImportExternalMemory", (driver.import)(&raw mut external, &raw const description))?;
                let mapped = (driver.map)(&raw mut sums, external, &raw const part);
                let means = driver
                    .check("cuExternalMemoryGetMappedBuffer", mapped)
                    .and_then(|()| driver.means(context, ordinal, sums, pixels));
                if sums != 0 {
                    (driver.free)(sums);
                }
                (driver.forget)(external);
                means
            }
        })
    }

    /// Number by which CUDA calls the device.
    pub fn ordinal(&self) -> u32 {
        self.ordinal
    }

    /// Address of the memory on the device.
    pub fn pointer(&self) -> u64 {
        self.pointer
    }
}

impl Drop for CudaMemory {
    fn drop(&mut self) {
        let pointer = self.pointer;
        // SAFETY: the memory was allocated on this device, and nobody else frees it.
        let free = |_| self.driver.check("cuMemFree", unsafe { (self.driver.free)(pointer) });
        let _ = self.driver.within(self.ordinal, free);
    }
}
