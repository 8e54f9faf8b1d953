//! A scene on a device, which takes samples and makes pictures of them.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use raggio_render::{
    Aov, Denoiser, DeviceInfo, Gpu, Observer, Progress, RenderRequest, Rendered, Rendering, Stop, gpu_of,
};
use raggio_scene::{Camera, Integrator, Scene};

#[cfg(target_os = "linux")]
use crate::cuda::CudaArray;
use crate::errors::{denoise_error, device_error, guarded, render_error};
use crate::film::Film;
use crate::host::{self, on_threads};
use crate::picture::{Developed, Metadata};
use crate::scene::{ReadScene, SceneText, read_camera};
use crate::values::chosen;

/// A scene on a device.
#[pyclass(frozen, module = "raggio._raggio")]
pub struct Session {
    /// Process in which the session was made: devices do not survive a fork.
    process: u32,
    device: String,
    inner: Mutex<Inner>,
}

struct Inner {
    rendering: Rendering,
    scene: Scene,
    ids: Vec<i32>,
    revision: u64,
    /// Moment at which the scene was read, if it is not the scene's own.
    time: Option<f64>,
    /// Denoiser, if pictures are to lose their noise, and the GPU on which it works if it can.
    denoiser: Option<Denoiser>,
    gpu: Option<Gpu>,
    warnings: Vec<String>,
}

/// View of a scene, and settings in place of the scene's own.
#[derive(Clone)]
struct View {
    camera: Option<Camera>,
    size: Option<(u32, u32)>,
    seed: Option<u32>,
    max_depth: Option<u32>,
    alpha: Option<bool>,
    integrator: Option<Integrator>,
}

impl View {
    fn apply(&self, scene: &mut Scene) {
        if let Some(camera) = &self.camera {
            scene.camera = camera.clone();
        }
        if let Some(size) = self.size {
            (scene.render.width, scene.render.height) = size;
        }
        scene.render.seed = self.seed.unwrap_or(scene.render.seed);
        scene.render.max_depth = self.max_depth.unwrap_or(scene.render.max_depth);
        scene.render.alpha = self.alpha.unwrap_or(scene.render.alpha);
        scene.render.integrator = self.integrator.unwrap_or(scene.render.integrator);
    }
}

#[pymethods]
impl Session {
    /// Brings a scene to a device.
    #[new]
    #[pyo3(signature = (
        scene, *, name, camera, time, size, samples, seed, max_depth, alpha, noise, time_limit, device, tracer, threads, aovs,
        denoise, label=false, integrator=None
    ))]
    #[allow(clippy::too_many_arguments, reason = "all but one are named")]
    fn new(
        py: Python<'_>,
        scene: &SceneText,
        name: String,
        camera: Option<String>,
        time: Option<f64>,
        size: Option<(u32, u32)>,
        samples: Option<u32>,
        seed: Option<u32>,
        max_depth: Option<u32>,
        alpha: Option<bool>,
        noise: Option<f32>,
        time_limit: Option<f32>,
        device: String,
        tracer: String,
        threads: usize,
        aovs: Vec<String>,
        denoise: bool,
        label: bool,
        integrator: Option<String>,
    ) -> PyResult<Self> {
        let layers: Vec<Aov> = aovs.iter().map(|name| chosen(name)).collect::<PyResult<_>>()?;
        let stop = Stop { samples: samples.map(|samples| 0..samples), noise, time_limit };
        let request = RenderRequest { name, layers, denoise, label, stop, ..RenderRequest::default() };
        let camera = camera.as_deref().map(read_camera).transpose()?;
        let integrator = integrator.as_deref().map(chosen).transpose()?;
        let view = View { camera, size, seed, max_depth, alpha, integrator };
        guarded(py, || {
            // What cannot be had is told before any time is spent.
            let denoiser = if denoise { Some(Denoiser::open().map_err(denoise_error)?) } else { None };
            let warnings = Mutex::new(vec![]);
            let warn = |warning: &str| warnings.lock().unwrap_or_else(PoisonError::into_inner).push(warning.to_owned());
            let device = host::device(&device, &tracer, threads, warn)?;
            let warnings = warnings.into_inner().unwrap_or_else(PoisonError::into_inner);
            let device_name = device.name();
            let inner = on_threads(|| {
                let ReadScene { scene, ids, revision } = scene.read(time)?;
                let mut scene = Scene::clone(&scene);
                view.apply(&mut scene);
                let rendering = Rendering::begin(&scene, &*device, request).map_err(render_error)?;
                let gpu = gpu_of(&*device);
                Ok(Inner { rendering, scene, ids, revision, time, denoiser, gpu, warnings })
            })?;
            Ok(Self { process: std::process::id(), device: device_name, inner: Mutex::new(inner) })
        })
    }

    /// Name of the device.
    #[getter]
    fn device(&self) -> &str {
        &self.device
    }

    /// Warnings since the last call.
    fn take_warnings(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        guarded(py, || Ok(std::mem::take(&mut self.lock()?.warnings)))
    }

    /// Begins anew with another view of `scene`, and brings what has changed of it to the device.
    #[pyo3(signature = (scene, *, camera, time, size, seed, max_depth, alpha))]
    #[allow(clippy::too_many_arguments, reason = "all but one are named")]
    fn look(
        &self,
        py: Python<'_>,
        scene: &SceneText,
        camera: Option<String>,
        time: Option<f64>,
        size: Option<(u32, u32)>,
        seed: Option<u32>,
        max_depth: Option<u32>,
        alpha: Option<bool>,
    ) -> PyResult<()> {
        let camera = camera.as_deref().map(read_camera).transpose()?;
        let view = View { camera, size, seed, max_depth, alpha, integrator: None };
        guarded(py, || {
            on_threads(|| {
                let mut inner = self.lock()?;
                let inner = &mut *inner;
                let ReadScene { scene, ids, revision } = scene.read(time)?;
                let same = revision == inner.revision && time == inner.time;
                if !same {
                    (inner.scene, inner.ids) = (Scene::clone(&scene), ids);
                    (inner.revision, inner.time) = (revision, time);
                } else {
                    (inner.scene.camera, inner.scene.render) = (scene.camera.clone(), scene.render.clone());
                }
                view.apply(&mut inner.scene);
                let Inner { rendering, scene, .. } = inner;
                let done = if same { rendering.look(scene) } else { rendering.change(scene) };
                done.map_err(render_error)
            })
        })
    }

    /// Changes how many samples each pixel is to have.
    fn set_target(&self, py: Python<'_>, samples: u32) -> PyResult<()> {
        guarded(py, || {
            self.lock()?.rendering.set_target(samples);
            Ok(())
        })
    }

    /// Takes samples until there are enough, or something ends it early: then that is returned.
    #[pyo3(signature = (report=None))]
    fn sample(&self, py: Python<'_>, report: Option<Py<PyAny>>) -> PyResult<Option<Py<PyAny>>> {
        let ended = guarded(py, || {
            let mut inner = self.lock()?;
            let mut listener = Listener::new(report);
            let done = inner.rendering.sample(&mut listener);
            inner.warnings.append(&mut listener.warnings);
            Ok(listener.stopped.or(done.map_err(device_error).err()))
        })?;
        Ok(ended.map(|error| error.into_value(py).into_any()))
    }

    /// The picture of the samples that there are in the memory of CUDA's device, which is this one; `None` where it would have
    /// to go through the host.
    #[cfg(target_os = "linux")]
    fn cuda(&self, py: Python<'_>) -> PyResult<Option<CudaArray>> {
        guarded(py, || {
            let mut inner = self.lock()?;
            let Inner { rendering, scene, denoiser, .. } = &mut *inner;
            if denoiser.is_some() {
                return Ok(None);
            }
            let shape = [scene.render.height as usize, scene.render.width as usize, 3];
            let means = rendering.means_in_cuda().map_err(device_error)?;
            Ok(means.map(|means| CudaArray::new(means, shape)))
        })
    }

    /// The picture of the samples that there are, as a dictionary, and what has ended its making early.
    #[pyo3(signature = (report=None))]
    fn develop<'py>(
        &self,
        py: Python<'py>,
        report: Option<Py<PyAny>>,
    ) -> PyResult<(Bound<'py, PyDict>, Option<Py<PyAny>>)> {
        self.developed(py, report, |rendering, listener| rendering.develop(listener, None).map_err(device_error))
    }

    /// The picture of a film that others have sampled in `seconds` and that is called `name`, as [`Session::develop`] makes it.
    #[pyo3(signature = (film, name, seconds, report=None))]
    fn develop_film<'py>(
        &self,
        py: Python<'py>,
        film: &Film,
        name: PathBuf,
        seconds: f64,
        report: Option<Py<PyAny>>,
    ) -> PyResult<(Bound<'py, PyDict>, Option<Py<PyAny>>)> {
        self.developed(py, report, |rendering, listener| {
            let film = film.lock().clone();
            rendering.develop_film(film, &name, seconds, listener).map_err(render_error)
        })
    }

    /// Film of the samples from `first` to before `end`, with its label, and the seconds that they took. It may lack some where
    /// something has ended it early; then that is returned too.
    #[pyo3(signature = (first, end, report=None))]
    fn film(
        &self,
        py: Python<'_>,
        first: u32,
        end: u32,
        report: Option<Py<PyAny>>,
    ) -> PyResult<(Film, f64, Option<Py<PyAny>>)> {
        let (film, seconds, ended) = guarded(py, || {
            let mut inner = self.lock()?;
            let mut listener = Listener::new(report);
            inner.rendering.restart_with(first..end).map_err(device_error)?;
            inner.rendering.sample(&mut listener).map_err(device_error)?;
            let rendered = inner.rendering.develop(&mut listener, None).map_err(device_error)?;
            inner.warnings.append(&mut listener.warnings);
            if let Some(failure) = rendered.failure {
                return Err(device_error(failure));
            }
            Ok((Film::new(rendered.picture.film), rendered.progress.seconds, listener.stopped))
        })?;
        Ok((film, seconds, ended.map(|error| error.into_value(py).into_any())))
    }
}

impl Session {
    /// A picture that `develop` makes, as a dictionary, and what has ended its making early.
    fn developed<'py>(
        &self,
        py: Python<'py>,
        report: Option<Py<PyAny>>,
        develop: impl FnOnce(&mut Rendering, &mut Listener) -> PyResult<Rendered> + Send,
    ) -> PyResult<(Bound<'py, PyDict>, Option<Py<PyAny>>)> {
        let (developed, seconds, finished, ended) = guarded(py, || {
            let mut inner = self.lock()?;
            let inner = &mut *inner;
            let mut listener = Listener::new(report);
            let rendered = develop(&mut inner.rendering, &mut listener)?;
            inner.warnings.append(&mut listener.warnings);
            let shown = match (&inner.denoiser, &rendered.failure) {
                (Some(denoiser), None) => {
                    inner.gpu.iter().for_each(|gpu| denoiser.prefer(gpu));
                    let denoised = rendered.picture.denoised(denoiser).map_err(denoise_error)?;
                    let complaint = denoiser.complaint();
                    inner.warnings.extend(complaint);
                    Some(denoised)
                }
                _ => None,
            };
            let ended = listener.stopped.or(rendered.failure.map(device_error));
            let developed = Developed::new(rendered.picture, shown, &inner.ids);
            Ok((developed, rendered.progress.seconds, rendered.finished, ended))
        })?;
        let found = developed.into_dict(py)?;
        found.set_item("seconds", seconds)?;
        found.set_item("finished", finished)?;
        Ok((found, ended.map(|error| error.into_value(py).into_any())))
    }

    fn lock(&self) -> PyResult<MutexGuard<'_, Inner>> {
        if self.process != std::process::id() {
            return Err(PyRuntimeError::new_err(
                "this renderer was made before the process was forked, and its device is the parent's: make a new one here",
            ));
        }
        Ok(self.inner.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Reports progress to Python, and breaks off where Python has an exception.
struct Listener {
    report: Option<Py<PyAny>>,
    warnings: Vec<String>,
    stopped: Option<PyErr>,
}

impl Listener {
    fn new(report: Option<Py<PyAny>>) -> Self {
        Self { report, warnings: vec![], stopped: None }
    }
}

impl Observer for Listener {
    fn warn(&mut self, warning: &str) {
        self.warnings.push(warning.to_owned());
    }

    fn progress(&mut self, progress: &Progress) -> ControlFlow<()> {
        if self.stopped.is_some() {
            return ControlFlow::Break(());
        }
        let told = Python::attach(|py| {
            // Signals are for the main thread; others find none here.
            py.check_signals()?;
            match &self.report {
                Some(report) => report.call1(py, (progress.fraction, progress.samples, progress.seconds)).map(drop),
                None => Ok(()),
            }
        });
        match told {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.stopped = Some(error);
                ControlFlow::Break(())
            }
        }
    }
}

/// Record of how a picture with `samples` was made elsewhere, and by which denoiser, if any.
#[pyfunction]
#[pyo3(signature = (scene, *, name, camera, size, samples, seed, max_depth, alpha, denoiser))]
#[allow(clippy::too_many_arguments, reason = "all but one are named")]
pub fn metadata(
    py: Python<'_>,
    scene: &SceneText,
    name: &str,
    camera: Option<String>,
    size: Option<(u32, u32)>,
    samples: u32,
    seed: Option<u32>,
    max_depth: Option<u32>,
    alpha: Option<bool>,
    denoiser: Option<String>,
) -> PyResult<Metadata> {
    let camera = camera.as_deref().map(read_camera).transpose()?;
    let view = View { camera, size, seed, max_depth, alpha, integrator: None };
    guarded(py, || {
        let mut scene = Scene::clone(&on_threads(|| scene.read(None))?.scene);
        view.apply(&mut scene);
        let mut inner = raggio_render::Metadata::new(&scene, name);
        (inner.samples, inner.denoiser) = (samples, denoiser);
        Ok(Metadata { inner })
    })
}

/// Lines of the devices of this machine: word, name, kind, driver, memory in bytes, what is missing, whether there are ray
/// queries, the tracer; and why there is no Vulkan, if there is none.
#[pyfunction]
#[allow(clippy::type_complexity, reason = "a row of a table")]
pub fn devices(
    py: Python<'_>,
) -> PyResult<(Vec<(String, String, &'static str, String, Option<u64>, Vec<String>, bool, &'static str)>, Option<String>)>
{
    guarded(py, || {
        let (found, error) = raggio_render::devices();
        let line = |info: DeviceInfo| {
            let DeviceInfo { id, name, kind, driver, memory_bytes, missing, has_ray_queries, tracer } = info;
            (id, name, kind, driver, memory_bytes, missing, has_ray_queries, tracer.name())
        };
        Ok((found.into_iter().map(line).collect(), error.map(|error| error.to_string())))
    })
}

/// Leaves to the parent what a forked child cannot use; called in the child.
#[pyfunction]
pub fn forget_after_fork() {
    host::forget();
}
