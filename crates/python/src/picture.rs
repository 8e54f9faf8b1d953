//! Pictures as arrays.

use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use raggio_render::{Channel, Picture, Values};

/// Record of how a picture was made, for EXRs.
#[pyclass(frozen, module = "raggio._raggio")]
pub struct Metadata {
    pub inner: raggio_render::Metadata,
}

#[pymethods]
impl Metadata {
    /// Name of what removed the noise; `None` where nothing did.
    #[getter]
    fn denoiser(&self) -> Option<String> {
        self.inner.denoiser.clone()
    }
}

/// A picture whose film is gone.
pub struct Developed {
    width: usize,
    height: usize,
    pixels: Vec<f32>,
    channels_of_pixels: usize,
    channels: Vec<Channel>,
    metadata: Option<raggio_render::Metadata>,
    /// Fewest and most samples of any pixel.
    samples: (u32, u32),
    rays: u64,
}

impl Developed {
    /// The pixels of `shown`, with the layers of `picture`. Shapes have the numbers `ids`.
    pub fn new(picture: Picture, shown: Option<Picture>, ids: &[i32]) -> Self {
        let (samples, rays) = (picture.film.sample_range(), picture.film.rays());
        let mut channels = picture.extras.channels;
        for channel in channels.iter_mut().filter(|channel| channel.name == "object_id.I") {
            if let Values::U32(numbers) = &mut channel.values {
                let id = |number: u32| ids.get((number as usize).wrapping_sub(1)).map_or(0, |id| *id as u32);
                numbers.iter_mut().for_each(|number| *number = id(*number));
            }
        }
        let (film, metadata) = match shown {
            Some(shown) => (shown.film, shown.extras.metadata),
            None => (picture.film, picture.extras.metadata),
        };
        let mean = film.mean();
        Self {
            width: mean.width as usize,
            height: mean.height as usize,
            channels_of_pixels: if mean.alpha.is_some() { 4 } else { 3 },
            pixels: match mean.alpha {
                None => mean.pixels.into_flattened(),
                Some(alpha) => {
                    mean.pixels.into_iter().zip(alpha).flat_map(|([r, g, b], alpha)| [r, g, b, alpha]).collect()
                }
            },
            channels,
            metadata,
            samples,
            rays,
        }
    }

    /// The picture as a dictionary of arrays, which take the memory over, and of facts.
    pub fn into_dict(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let size = [self.height, self.width];
        let found = PyDict::new(py);
        found.set_item(
            "pixels",
            PyArray1::from_vec(py, self.pixels).reshape([size[0], size[1], self.channels_of_pixels])?,
        )?;
        let channels = PyDict::new(py);
        for Channel { name, values } in self.channels {
            match values {
                Values::F32(values) => channels.set_item(name, PyArray1::from_vec(py, values).reshape(size)?)?,
                Values::U32(values) => {
                    let values: Vec<i32> = values.into_iter().map(|value| value as i32).collect();
                    channels.set_item(name, PyArray1::from_vec(py, values).reshape(size)?)?;
                }
                // Kinds that there are not yet would be of no use to anybody who does not know them.
                _ => {}
            }
        }
        found.set_item("channels", channels)?;
        found.set_item("metadata", self.metadata.map(|inner| Py::new(py, Metadata { inner })).transpose()?)?;
        found.set_item("samples", self.samples)?;
        found.set_item("rays", self.rays)?;
        Ok(found)
    }
}
