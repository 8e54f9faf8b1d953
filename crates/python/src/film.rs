//! Films: sums of samples, which add up from wherever they come.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use raggio_render::{Film as Sums, FilmError, Picture};

use crate::errors::{guarded, output_error, scene_error};
use crate::picture::Developed;

/// A film with its label.
#[pyclass(frozen, module = "raggio._raggio")]
pub struct Film {
    inner: Mutex<Sums>,
}

impl Film {
    pub fn new(film: Sums) -> Self {
        Self { inner: Mutex::new(film) }
    }

    pub fn lock(&self) -> MutexGuard<'_, Sums> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl Film {
    /// Reads a film from its file.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        guarded(py, || Sums::read(&path).map(Self::new).map_err(film_error))
    }

    /// Reads a film from the bytes of its file.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, bytes: PyReadonlyArray1<'_, u8>) -> PyResult<Self> {
        let bytes = bytes.as_slice()?;
        guarded(py, || Sums::from_bytes(bytes, Path::new("a film on its way")).map(Self::new).map_err(film_error))
    }

    /// The bytes of its file.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<u8>>> {
        let bytes = guarded(py, || self.lock().to_bytes().map_err(film_error))?;
        Ok(PyArray1::from_vec(py, bytes))
    }

    /// Adds the samples of another film, and leaves this one as it was where that is of another picture or has samples that
    /// this one has.
    fn merge(&self, py: Python<'_>, other: &Self) -> PyResult<()> {
        guarded(py, || self.lock().merge(&other.lock()).map_err(scene_error))
    }

    /// Samples that all pixels have: the first of each range, and the one after its last; in order. `None` where it has some in
    /// a part of its rows alone.
    #[getter]
    fn ranges(&self) -> Option<Vec<(u32, u32)>> {
        let film = self.lock();
        let all = 0..film.height();
        let portions = film.label().map(|label| label.portions()).unwrap_or_default();
        portions.iter().map(|part| (part.rows == all).then_some((part.samples.start, part.samples.end))).collect()
    }

    /// Width and height in pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        let film = self.lock();
        (film.width(), film.height())
    }

    /// Writes the film to its file, whole or not at all.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        guarded(py, || self.lock().write(&path).map_err(film_error))
    }

    /// The picture of its samples, without layers, as a dictionary.
    fn develop<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let developed = guarded(py, || Ok(Developed::new(Picture::of_film(self.lock().clone()), None, &[])))?;
        developed.into_dict(py)
    }
}

fn film_error(error: FilmError) -> PyErr {
    match error {
        FilmError::Unwritable { .. } => output_error(error),
        error => scene_error(error),
    }
}
