//! Pictures of arrays: files, and what displays show.

use std::path::PathBuf;

use numpy::{PyArray1, PyArray3, PyArrayMethods, PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use raggio_render::{Channel, Display, Extras, Image, ImageFile, Values, show_bytes};

use crate::errors::{guarded, output_error};
use crate::host::on_threads;
use crate::meshes::pixels;
use crate::picture::Metadata;
use crate::values::chosen;

/// Picture of an array, (height, width, 3) or, with alpha, (height, width, 4).
fn image(array: &PyReadonlyArray3<'_, f32>) -> PyResult<Image> {
    if array.shape()[2] == 4 {
        let (pixels, [height, width]) = pixels::<_, 4>(array)?;
        let alpha = Some(pixels.iter().map(|pixel| pixel[3]).collect());
        let pixels = pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        return Ok(Image { width: width as u32, height: height as u32, pixels, alpha });
    }
    let (pixels, [height, width]) = pixels(array)?;
    Ok(Image { width: width as u32, height: height as u32, pixels, alpha: None })
}

fn display(exposure: f32, tone_mapper: &str) -> PyResult<Display> {
    Ok(Display { exposure, tone_mapper: chosen(tone_mapper)?, ..Display::default() })
}

/// Writes a picture to a file, whole or not at all; its ending tells the format.
#[pyfunction]
#[pyo3(signature = (path, array, *, floats, numbers, metadata, png_bits, exposure, tone_mapper))]
#[allow(clippy::too_many_arguments, reason = "all but two are named")]
pub fn write_image(
    py: Python<'_>,
    path: PathBuf,
    array: PyReadonlyArray3<'_, f32>,
    floats: Vec<(String, PyReadonlyArray2<'_, f32>)>,
    numbers: Vec<(String, PyReadonlyArray2<'_, i32>)>,
    metadata: Option<Bound<'_, Metadata>>,
    png_bits: &str,
    exposure: f32,
    tone_mapper: &str,
) -> PyResult<()> {
    let (image, display) = (image(&array)?, display(exposure, tone_mapper)?);
    let png_bits = chosen(png_bits)?;
    let mut channels = vec![];
    for (name, array) in floats {
        channels.push(Channel { name, values: Values::F32(array.to_vec()?) });
    }
    for (name, array) in numbers {
        let values = array.as_array().iter().map(|number| *number as u32).collect();
        channels.push(Channel { name, values: Values::U32(values) });
    }
    let extras = Extras { channels, metadata: metadata.map(|metadata| metadata.get().inner.clone()) };
    guarded(py, || {
        let file = ImageFile::new(&path).map_err(output_error)?.with_png_bits(png_bits);
        on_threads(|| file.write_image(&image, display, &extras).map_err(output_error))
    })
}

/// The picture as a display shows it: bytes of sRGB (height, width, 3), with alpha (height, width, 4).
#[pyfunction]
#[pyo3(signature = (array, *, exposure, tone_mapper))]
pub fn tonemap<'py>(
    py: Python<'py>,
    array: PyReadonlyArray3<'py, f32>,
    exposure: f32,
    tone_mapper: &str,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let (image, display) = (image(&array)?, display(exposure, tone_mapper)?);
    let shape = [image.height as usize, image.width as usize, array.shape()[2]];
    let bytes = guarded(py, || on_threads(|| Ok(show_bytes(&image, display))))?;
    PyArray1::from_vec(py, bytes).reshape(shape)
}

/// A PNG of the picture.
#[pyfunction]
#[pyo3(signature = (array, *, exposure, tone_mapper))]
pub fn encode_png<'py>(
    py: Python<'py>,
    array: PyReadonlyArray3<'py, f32>,
    exposure: f32,
    tone_mapper: &str,
) -> PyResult<Bound<'py, PyBytes>> {
    let (image, display) = (image(&array)?, display(exposure, tone_mapper)?);
    let bytes = guarded(py, || on_threads(|| raggio_render::encode_png(&image, display).map_err(output_error)))?;
    Ok(PyBytes::new(py, &bytes))
}
