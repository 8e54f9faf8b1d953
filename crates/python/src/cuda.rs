//! Pictures in the memory of CUDA's devices, as other libraries take them.
#![allow(unsafe_code)] // DLPack hands pointers from library to library.

use std::ffi::{CStr, c_void};
use std::sync::Arc;

use numpy::{PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::exceptions::PyBufferError;
use pyo3::ffi;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use raggio_render::CudaMemory;

use crate::errors::{device_error, guarded};

/// Kind of device `kDLCUDA`.
const CUDA: i32 = 2;
/// Kind of number `kDLFloat`.
const FLOAT: u8 = 2;
/// Name of a capsule that nobody has taken yet.
const UNTAKEN: &CStr = c"dltensor";

/// An array of floats (height, width, channels) in the memory of a device of CUDA.
#[pyclass(frozen, module = "raggio")]
pub struct CudaArray {
    memory: Arc<CudaMemory>,
    shape: [usize; 3],
}

impl CudaArray {
    pub fn new(memory: CudaMemory, shape: [usize; 3]) -> Self {
        Self { memory: Arc::new(memory), shape }
    }
}

#[pymethods]
impl CudaArray {
    /// Shape: height, width and channels.
    #[getter]
    fn shape(&self) -> (usize, usize, usize) {
        let [height, width, channels] = self.shape;
        (height, width, channels)
    }

    /// Number by which CUDA calls the device.
    #[getter]
    fn device(&self) -> u32 {
        self.memory.ordinal()
    }

    /// Place of the array in the device's memory, as CuPy, Numba and PyTorch know it.
    #[getter]
    fn __cuda_array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let interface = PyDict::new(py);
        interface.set_item("shape", self.shape())?;
        interface.set_item("typestr", if cfg!(target_endian = "little") { "<f4" } else { ">f4" })?;
        interface.set_item("data", (self.memory.pointer(), false))?;
        interface.set_item("strides", py.None())?;
        // All that has been written is there: nobody has to wait for a stream.
        interface.set_item("stream", py.None())?;
        interface.set_item("version", 3)?;
        Ok(interface)
    }

    /// Device as DLPack calls it.
    fn __dlpack_device__(&self) -> (i32, u32) {
        (CUDA, self.memory.ordinal())
    }

    /// The array as a capsule of DLPack, which shares its memory.
    #[pyo3(signature = (*, stream=None, max_version=None, dl_device=None, copy=None))]
    fn __dlpack__(
        &self,
        py: Python<'_>,
        stream: Option<Py<PyAny>>,
        max_version: Option<(u32, u32)>,
        dl_device: Option<(i32, u32)>,
        copy: Option<bool>,
    ) -> PyResult<Py<PyAny>> {
        // All streams see what is there, and the oldest version is known to everybody.
        let _ = (stream, max_version);
        if dl_device.is_some_and(|device| device != self.__dlpack_device__()) {
            return Err(PyBufferError::new_err("the array is on another device"));
        }
        if copy == Some(true) {
            return Err(PyBufferError::new_err("the array is shared: copy it where it arrives"));
        }
        let tensor = Box::into_raw(Managed::boxed(self.memory.clone(), self.shape));
        // SAFETY: the capsule owns the tensor until somebody takes it, who then calls its deleter; the interpreter is held.
        unsafe {
            let capsule = ffi::PyCapsule_New(tensor.cast(), UNTAKEN.as_ptr(), Some(drop_untaken));
            if capsule.is_null() {
                delete(tensor);
            }
            Bound::from_owned_ptr_or_err(py, capsule).map(Bound::unbind)
        }
    }

    fn __repr__(&self) -> String {
        let [height, width, channels] = self.shape;
        format!("<raggio.CudaArray ({height}, {width}, {channels}) float32 on cuda:{}>", self.memory.ordinal())
    }
}

/// `DLManagedTensor`, with what it is made of behind it.
#[repr(C)]
struct Managed {
    data: *mut c_void,
    device_kind: i32,
    device: i32,
    dimensions: i32,
    code: u8,
    bits: u8,
    lanes: u16,
    shape: *mut i64,
    strides: *mut i64,
    offset: u64,
    context: *mut c_void,
    deleter: Option<unsafe extern "C" fn(*mut Managed)>,
    // What follows is ours.
    sides: [i64; 3],
    _memory: Arc<CudaMemory>,
}

impl Managed {
    fn boxed(memory: Arc<CudaMemory>, shape: [usize; 3]) -> Box<Self> {
        let mut tensor = Box::new(Self {
            data: memory.pointer() as *mut c_void,
            device_kind: CUDA,
            device: memory.ordinal() as i32,
            dimensions: 3,
            code: FLOAT,
            bits: 32,
            lanes: 1,
            shape: std::ptr::null_mut(),
            // Rows follow one another.
            strides: std::ptr::null_mut(),
            offset: 0,
            context: std::ptr::null_mut(),
            deleter: Some(delete),
            sides: shape.map(|side| side as i64),
            _memory: memory,
        });
        tensor.shape = tensor.sides.as_mut_ptr();
        tensor
    }
}

/// Gives a tensor's share of the memory back.
unsafe extern "C" fn delete(tensor: *mut Managed) {
    // SAFETY: whoever calls this has the tensor, which came out of a box, and has no more use for it.
    drop(unsafe { Box::from_raw(tensor) });
}

/// Deletes the tensor of a capsule that nobody has taken: takers give it another name.
unsafe extern "C" fn drop_untaken(capsule: *mut ffi::PyObject) {
    // SAFETY: Python calls this with a capsule of ours while the interpreter is held.
    unsafe {
        if ffi::PyCapsule_IsValid(capsule, UNTAKEN.as_ptr()) == 1 {
            delete(ffi::PyCapsule_GetPointer(capsule, UNTAKEN.as_ptr()).cast());
        }
    }
}

/// Number of CUDA's devices.
#[pyfunction]
pub fn cuda_devices(py: Python<'_>) -> PyResult<u32> {
    guarded(py, || CudaMemory::devices().map_err(|error| device_error(error.into())))
}

/// Copies a picture (height, width, channels) to a device of CUDA.
#[pyfunction]
pub fn to_cuda(py: Python<'_>, array: PyReadonlyArray3<'_, f32>, device: u32) -> PyResult<CudaArray> {
    let shape = [array.shape()[0], array.shape()[1], array.shape()[2]];
    let numbers = array.as_slice()?;
    guarded(py, || {
        let memory = CudaMemory::upload(numbers, device).map_err(|error| device_error(error.into()))?;
        Ok(CudaArray::new(memory, shape))
    })
}
