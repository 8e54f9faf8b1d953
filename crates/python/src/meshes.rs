//! Meshes and images from arrays.

use numpy::{PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use raggio_images::Texels;
use raggio_scene::{Bitmap, DAffine3, DMat3, DVec3, Instance, Mesh, Model, Part};

use crate::errors::scene_error;

/// Rows of a C-contiguous array of `N` columns, copied.
pub fn rows<T: numpy::Element + Copy, const N: usize>(
    name: &str,
    array: &PyReadonlyArray2<'_, T>,
) -> PyResult<Vec<[T; N]>> {
    let wrong = || PyValueError::new_err(format!("{name} is of shape {:?}: give (n, {N})", array.shape()));
    if array.shape()[1] != N {
        return Err(wrong());
    }
    let (rows, rest) = array.as_slice().map_err(|_| wrong())?.as_chunks::<N>();
    debug_assert!(rest.is_empty());
    Ok(rows.to_vec())
}

/// The affine map of the first three rows of a matrix, which are 12 numbers.
pub fn affine(rows: [f64; 12]) -> DAffine3 {
    let column = |i: usize| DVec3::new(rows[i], rows[4 + i], rows[8 + i]);
    DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
}

/// A mesh that is cleaned, and the warning of what was taken away.
pub fn clean(name: &str, mut mesh: Mesh) -> PyResult<(Mesh, Option<String>)> {
    mesh.parts = vec![Part { name: name.into(), material: None, triangles: 0..mesh.triangles.len() }];
    let dropped = mesh.clean(name).map_err(scene_error)?;
    if mesh.triangles.is_empty() {
        return Err(scene_error(format!("{name}: there are no triangles with an area in this mesh")));
    }
    Ok((mesh, dropped.warning().map(|warning| format!("{name}: {warning}"))))
}

/// A model of one mesh.
pub fn model(name: &str, mesh: std::sync::Arc<Mesh>, world_from_mesh: DAffine3) -> Model {
    let instance = Instance { name: name.into(), mesh: 0, model_from_mesh: world_from_mesh };
    Model { meshes: vec![mesh], instances: vec![instance], ..Model::default() }
}

/// An image of floats (height, width, 3), linear and not negative.
pub fn radiance(array: &PyReadonlyArray3<'_, f32>) -> PyResult<Bitmap> {
    let (values, [height, width]) = pixels::<f32, 3>(array)?;
    if let Some(place) = values.iter().position(|texel| texel.iter().any(|x| !(x.is_finite() && *x >= 0.0))) {
        let (row, column) = (place / width, place % width);
        return Err(PyValueError::new_err(format!(
            "the image is {:?} at row {row}, column {column}: give finite numbers that are not negative",
            values[place]
        )));
    }
    bitmap(Texels::Rgb32F(values), width, height)
}

/// An image of bytes (height, width, 4).
pub fn bytes(array: &PyReadonlyArray3<'_, u8>) -> PyResult<Bitmap> {
    let (values, [height, width]) = pixels::<u8, 4>(array)?;
    bitmap(Texels::Rgba8(values), width, height)
}

fn bitmap(texels: Texels, width: usize, height: usize) -> PyResult<Bitmap> {
    match (u32::try_from(width), u32::try_from(height)) {
        (Ok(width @ 1..), Ok(height @ 1..)) => Ok(Bitmap { width, height, texels }),
        _ => Err(PyValueError::new_err(format!("an image cannot be of {width} x {height} pixels"))),
    }
}

/// Pixels of a C-contiguous array, and its height and width.
pub fn pixels<T: numpy::Element + Copy, const N: usize>(
    array: &PyReadonlyArray3<'_, T>,
) -> PyResult<(Vec<[T; N]>, [usize; 2])> {
    let &[height, width, channels] = array.shape() else { unreachable!("the array has three axes") };
    let wrong =
        || PyValueError::new_err(format!("the image is of shape {:?}: give (height, width, {N})", array.shape()));
    if channels != N {
        return Err(wrong());
    }
    Ok((array.as_slice().map_err(|_| wrong())?.as_chunks::<N>().0.to_vec(), [height, width]))
}
