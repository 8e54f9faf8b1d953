//! The Python module `raggio`, as far as it is Rust: `raggio._raggio`.
//!
//! Arrays and texts come in, arrays go out; what users see of it is in `python/raggio`. A scene is the text of a scene file,
//! whose meshes and images may be in memory. Whatever takes time runs without Python's lock.

#[cfg(target_os = "linux")]
mod cuda;
mod errors;
mod film;
mod host;
mod images;
mod meshes;
mod picture;
mod scene;
mod session;
mod values;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Rust's part of the module `raggio`.
#[pymodule]
mod _raggio {
    use super::*;

    #[cfg(target_os = "linux")]
    #[pymodule_export]
    use super::cuda::{CudaArray, cuda_devices, to_cuda};
    #[pymodule_export]
    use super::film::Film;
    #[pymodule_export]
    use super::images::{encode_png, tonemap, write_image};
    #[pymodule_export]
    use super::picture::Metadata;
    #[pymodule_export]
    use super::scene::{SceneText, check_camera};
    #[pymodule_export]
    use super::session::{Session, devices, forget_after_fork, metadata};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        super::errors::keep_faults();
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add("AOVS", super::values::names::<raggio_render::Aov>())?;
        module.add("TONE_MAPPERS", super::values::names::<raggio_render::ToneMapper>())
    }

    /// Runs the program `raggio` with `arguments`, the first of which is its name; returns its exit status.
    #[pyfunction]
    fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
        py.detach(|| raggio_cli::main(arguments))
    }

    /// Ends in a fault, for tests of what becomes of one.
    #[pyfunction]
    fn panic_for_tests(py: Python<'_>) -> PyResult<()> {
        super::errors::guarded(py, || panic!("a fault on purpose"))
    }
}
