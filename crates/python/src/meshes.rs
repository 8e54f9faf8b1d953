//! Meshes and images from arrays.

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
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

/// A mesh as arrays: the name of its only part, positions, triangles, normals, texture coordinates, colours.
pub type Arrays<'py> = (
    String,
    PyReadonlyArray2<'py, f32>,
    PyReadonlyArray2<'py, u32>,
    Option<PyReadonlyArray2<'py, f32>>,
    Option<PyReadonlyArray2<'py, f32>>,
    Option<PyReadonlyArray2<'py, f32>>,
);

/// A mesh in memory as arrays, for [`of_arrays`].
pub fn arrays<'py>(py: Python<'py>, mesh: &Mesh) -> PyResult<Bound<'py, PyTuple>> {
    let name = mesh.parts.first().map_or("", |part| &part.name);
    let optional = |rows: Option<&Vec<[f32; 3]>>| rows.map(|rows| array(py, rows)).transpose();
    let uvs = mesh.uvs[0].as_ref().map(|rows| array(py, rows)).transpose()?;
    let colors = mesh.colors.as_ref().map(|rows| array(py, rows)).transpose()?;
    (name, array(py, &mesh.positions)?, array(py, &mesh.triangles)?, optional(mesh.normals.as_ref())?, uvs, colors)
        .into_pyobject(py)
}

/// The mesh of [`arrays`], which has been cleaned before.
pub fn of_arrays((name, positions, triangles, normals, uvs, colors): &Arrays<'_>) -> PyResult<Mesh> {
    let triangles = rows("faces", triangles)?;
    Ok(Mesh {
        positions: rows("vertices", positions)?,
        normals: normals.as_ref().map(|normals| rows("normals", normals)).transpose()?,
        uvs: [uvs.as_ref().map(|uvs| rows("uvs", uvs)).transpose()?, None],
        colors: colors.as_ref().map(|colors| rows("colors", colors)).transpose()?,
        parts: vec![Part { name: name.as_str().into(), material: None, triangles: 0..triangles.len() }],
        triangles,
        ..Mesh::default()
    })
}

/// An image in memory as an array, for [`image_of_array`].
pub fn image_array<'py>(py: Python<'py>, image: &Bitmap) -> PyResult<Bound<'py, PyAny>> {
    let [height, width] = [image.height, image.width].map(|side| side as usize);
    match &image.texels {
        Texels::Rgb32F(texels) => {
            Ok(PyArray1::from_slice(py, texels.as_flattened()).reshape([height, width, 3])?.into_any())
        }
        Texels::Rgba8(texels) => {
            Ok(PyArray1::from_slice(py, texels.as_flattened()).reshape([height, width, 4])?.into_any())
        }
        Texels::Rgba16(_) => Err(PyValueError::new_err("no image in memory has 16 bits")),
    }
}

/// The image of [`image_array`].
pub fn image_of_array(array: &Bound<'_, PyAny>) -> PyResult<Bitmap> {
    match array.extract::<PyReadonlyArray3<'_, f32>>() {
        Ok(array) => radiance(&array),
        Err(_) => bytes(&array.extract()?),
    }
}

/// Rows as an array, copied.
fn array<'py, T: numpy::Element + Copy, const N: usize>(
    py: Python<'py>,
    rows: &[[T; N]],
) -> PyResult<Bound<'py, PyArray2<T>>> {
    PyArray1::from_slice(py, rows.as_flattened()).reshape([rows.len(), N])
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
