//! Errors as Python's exceptions, with the sentences of the program.

use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;
use raggio_render::{DenoiseError as RenderDenoiseError, DeviceError as RenderDeviceError, RenderError};

pyo3::import_exception!(raggio._errors, SceneError);
pyo3::import_exception!(raggio._errors, DeviceError);
pyo3::import_exception!(raggio._errors, OutputError);
pyo3::import_exception!(raggio._errors, DenoiseError);
pyo3::import_exception!(raggio._errors, InternalError);

/// Words of the last panic.
static FAULT: Mutex<String> = Mutex::new(String::new());

/// Keeps the words of panics for their exceptions, in place of printing them.
pub fn keep_faults() {
    set_hook(Box::new(|info| {
        // Decoders of images may give up on damaged bytes, which becomes an error of the image.
        if !raggio_images::guarded() {
            let words = info.payload_as_str().unwrap_or("it gives no reason");
            let place = info.location().map(|place| format!(" ({place})")).unwrap_or_default();
            *FAULT.lock().unwrap_or_else(PoisonError::into_inner) = format!("{words}{place}");
        }
    }));
}

/// Runs `work` without Python's lock. A panic becomes an exception.
pub fn guarded<T: Send>(py: Python<'_>, work: impl FnOnce() -> PyResult<T> + Send) -> PyResult<T> {
    py.detach(|| catch_unwind(AssertUnwindSafe(work))).unwrap_or_else(|_| {
        let words = std::mem::take(&mut *FAULT.lock().unwrap_or_else(PoisonError::into_inner));
        Err(InternalError::new_err(format!("raggio has a fault of its own, please report it: {words}")))
    })
}

pub fn scene_error(error: impl Display) -> PyErr {
    SceneError::new_err(error.to_string())
}

pub fn device_error(error: RenderDeviceError) -> PyErr {
    DeviceError::new_err(error.to_string())
}

pub fn output_error(error: impl Display) -> PyErr {
    OutputError::new_err(error.to_string())
}

pub fn denoise_error(error: RenderDenoiseError) -> PyErr {
    DenoiseError::new_err(match error {
        RenderDenoiseError::NotFound(_) => {
            format!("{error}; `pip install pyoidn` installs it where raggio finds it")
        }
        error => error.to_string(),
    })
}

pub fn render_error(error: RenderError) -> PyErr {
    match error {
        RenderError::Device(error) => device_error(error),
        error => scene_error(error),
    }
}
