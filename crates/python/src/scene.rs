//! A scene: the text of a scene file, and meshes and images in memory.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use numpy::{PyReadonlyArray2, PyReadonlyArray3};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use raggio_scene::{AssetOptions, Assets, Bitmap, Camera, Mesh, Scene, scene_text};
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, Value};

use crate::errors::{guarded, scene_error};
use crate::host::on_threads;
use crate::{meshes, values};

/// Camera that checks stand in for where a scene has none yet.
const ANY_CAMERA: &str = "camera = { position = [0, 0, 1], look_at = [0, 0, 0], vertical_fov_degrees = 40 }\n";
/// Beginning of the names of what is in memory.
const MEMORY: &str = "memory:";
const NEW: &str = "version = 1\n";

/// Text of a scene file, what it names in memory, and numbers of its objects.
#[pyclass(frozen, module = "raggio._raggio")]
pub struct SceneText {
    inner: Mutex<Inner>,
}

struct Inner {
    document: DocumentMut,
    /// Path of the scene's file; of a scene without one, its name in messages.
    path: PathBuf,
    assets: Assets,
    /// Meshes in memory, by the names under which the text has them.
    meshes: HashMap<String, Arc<Mesh>>,
    /// Meshes that were placed, by the names under which the text has them: the mesh's name, and three rows of a matrix.
    placed: HashMap<String, (String, [f64; 12])>,
    /// Images in memory, by the names under which the text has them.
    images: HashMap<String, Arc<Bitmap>>,
    /// Number of names that were given to what is in memory.
    given: usize,
    /// Numbers of the `[[shapes]]` and of the shapes of the file that was loaded.
    own_entries: usize,
    own_shapes: usize,
    /// Numbers of the `[[shapes]]` that were added.
    ids: Vec<i32>,
    /// The scene that was made of the text as it is.
    read: Option<Arc<Scene>>,
    revision: u64,
}

/// A scene that has been read, with the number of each shape.
pub struct ReadScene {
    pub scene: Arc<Scene>,
    pub ids: Vec<i32>,
    pub revision: u64,
}

impl SceneText {
    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reads the text, unless that has been done, at the moment `time` or at its own.
    pub fn read(&self, time: Option<f64>) -> PyResult<ReadScene> {
        let mut inner = self.lock();
        let scene = inner.read_at(time)?;
        let own = inner.own_entries;
        let id = |(number, entry): (usize, usize)| {
            if entry < own { number as i32 + 1 } else { inner.ids[entry - own] }
        };
        let ids = scene.shapes.iter().map(|shape| shape.entry).enumerate().map(id).collect();
        Ok(ReadScene { scene, ids, revision: inner.revision })
    }
}

impl Inner {
    fn new(text: &str, path: PathBuf, assets: Assets) -> PyResult<Self> {
        let document = text.parse().map_err(scene_error)?;
        Ok(Self {
            document,
            path,
            assets,
            meshes: HashMap::new(),
            placed: HashMap::new(),
            images: HashMap::new(),
            given: 0,
            own_entries: 0,
            own_shapes: 0,
            ids: vec![],
            read: None,
            revision: 0,
        })
    }

    fn read(&mut self) -> PyResult<Arc<Scene>> {
        if let Some(scene) = &self.read {
            return Ok(scene.clone());
        }
        let mut text = self.document.to_string();
        if !self.document.contains_key("camera") {
            text.insert_str(0, ANY_CAMERA);
        }
        let scene = Scene::parse_with(&text, &self.path, &mut self.assets).map_err(scene_error)?;
        Ok(self.read.insert(Arc::new(scene)).clone())
    }

    /// Reads the text at another moment than its own.
    fn read_at(&mut self, time: Option<f64>) -> PyResult<Arc<Scene>> {
        let own = self.assets.options().time_seconds;
        if time.is_none() || time == own {
            return self.read();
        }
        self.assets.set_time(time);
        let kept = self.read.take();
        let read = self.read();
        self.read = kept;
        self.assets.set_time(own);
        read
    }

    fn changed(&mut self) {
        self.read = None;
        self.revision += 1;
    }

    /// Path at which the text finds what it calls `name`.
    fn path_of(&self, name: &str) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(name)
    }

    /// Places a mesh in memory, under a name for the text.
    fn place(&mut self, placed: String, name: &str, mesh: Arc<Mesh>, rows: [f64; 12]) {
        let path = self.path_of(&placed);
        self.assets.give_model(path, meshes::model(name, mesh, meshes::affine(rows)));
        self.placed.insert(placed, (name.into(), rows));
    }

    /// Keeps an image in memory, under a name for the text.
    fn keep_image(&mut self, name: String, image: Arc<Bitmap>) {
        let path = self.path_of(&name);
        self.assets.give_image(path, image.clone());
        self.images.insert(name, image);
    }

    fn new_name(&mut self) -> String {
        self.given += 1;
        format!("{MEMORY}{}", self.given)
    }

    /// Forgets what a value that is gone has named in memory, unless the text still does.
    fn forget(&mut self, value: Option<Item>) {
        let gone = value.map(|value| value.to_string()).unwrap_or_default();
        if !gone.contains(MEMORY) {
            return;
        }
        let text = self.document.to_string();
        for name in gone.split('"').filter(|name| name.starts_with(MEMORY)) {
            if !text.contains(&format!("\"{name}\"")) {
                let path = self.path_of(name);
                self.assets.take_back(&path);
                self.placed.remove(name);
                self.images.remove(name);
            }
        }
    }
}

#[pymethods]
impl SceneText {
    /// Reads a scene or a model, and returns it with its warnings.
    #[staticmethod]
    #[pyo3(signature = (path, *, allow_outside, time_seconds, camera))]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        allow_outside: bool,
        time_seconds: Option<f64>,
        camera: Option<String>,
    ) -> PyResult<(Self, Vec<String>)> {
        guarded(py, || {
            on_threads(|| {
                let options = AssetOptions { allow_outside, time_seconds, camera, ..AssetOptions::default() };
                let mut assets = Assets::new(options);
                let scene = Scene::load_with(&path, &mut assets).map_err(scene_error)?;
                let text = scene_text(&path, &mut assets).map_err(scene_error)?;
                let mut inner = Inner::new(&text, path, assets)?;
                (inner.own_entries, inner.own_shapes) = (scene.entries.len(), scene.shapes.len());
                let warnings = scene.warnings.clone();
                inner.read = Some(Arc::new(scene));
                Ok((Self { inner: Mutex::new(inner) }, warnings))
            })
        })
    }

    /// A scene without shapes, light and camera.
    #[staticmethod]
    fn empty() -> PyResult<Self> {
        Ok(Self { inner: Mutex::new(Inner::new(NEW, PathBuf::from("scene"), Assets::default())?) })
    }

    /// A copy, which shares meshes and images in memory with this one.
    fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        guarded(py, || {
            let mut inner = self.lock();
            let scene = inner.read()?;
            let mut assets = Assets::new(inner.assets.options().clone());
            inner.assets.lend(&mut assets);
            Ok(Self {
                inner: Mutex::new(Inner {
                    document: inner.document.clone(),
                    path: inner.path.clone(),
                    assets,
                    meshes: inner.meshes.clone(),
                    placed: inner.placed.clone(),
                    images: inner.images.clone(),
                    given: inner.given,
                    own_entries: inner.own_entries,
                    own_shapes: inner.own_shapes,
                    ids: inner.ids.clone(),
                    read: Some(scene),
                    revision: inner.revision,
                }),
            })
        })
    }

    /// Paths of all files that the scene is made of, but for its own.
    fn files(&self, py: Python<'_>) -> PyResult<Vec<PathBuf>> {
        guarded(py, || {
            on_threads(|| {
                let mut inner = self.lock();
                // A copy has the scene of another, and has asked for no file yet.
                inner.read = None;
                inner.read()?;
                let mut files: Vec<_> = inner.assets.all_files().map(PathBuf::from).collect();
                files.sort();
                files.dedup();
                Ok(files)
            })
        })
    }

    /// All there is but files, for [`SceneText::restored`] in another process.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let inner = self.lock();
        let state = PyDict::new(py);
        state.set_item("text", inner.document.to_string())?;
        state.set_item("path", &inner.path)?;
        state.set_item("allow_outside", inner.assets.options().allow_outside)?;
        state.set_item("time_seconds", inner.assets.options().time_seconds)?;
        state.set_item("numbers", (inner.given, inner.own_entries, inner.own_shapes, &inner.ids))?;
        state.set_item("placed", &inner.placed)?;
        let kept = PyDict::new(py);
        for (name, mesh) in &inner.meshes {
            kept.set_item(name, meshes::arrays(py, mesh)?)?;
        }
        state.set_item("meshes", kept)?;
        let kept = PyDict::new(py);
        for (name, image) in &inner.images {
            kept.set_item(name, meshes::image_array(py, image)?)?;
        }
        state.set_item("images", kept)?;
        Ok(state)
    }

    /// The scene of a [`SceneText::state`]; its text is read when somebody asks for it.
    #[staticmethod]
    #[pyo3(signature = (*, text, path, allow_outside, time_seconds, numbers, placed, meshes, images))]
    #[allow(clippy::too_many_arguments, reason = "all are named")]
    fn restored(
        text: &str,
        path: PathBuf,
        allow_outside: bool,
        time_seconds: Option<f64>,
        numbers: (usize, usize, usize, Vec<i32>),
        placed: HashMap<String, (String, [f64; 12])>,
        meshes: HashMap<String, meshes::Arrays<'_>>,
        images: HashMap<String, Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let options = AssetOptions { allow_outside, time_seconds, ..AssetOptions::default() };
        let mut inner = Inner::new(text, path, Assets::new(options))?;
        (inner.given, inner.own_entries, inner.own_shapes, inner.ids) = numbers;
        for (name, arrays) in meshes {
            inner.meshes.insert(name, Arc::new(meshes::of_arrays(&arrays)?));
        }
        for (name, (mesh, rows)) in placed {
            let found = inner.meshes.get(&mesh).cloned().ok_or_else(|| PyKeyError::new_err(mesh.clone()))?;
            inner.place(name, &mesh, found, rows);
        }
        for (name, image) in images {
            inner.keep_image(name, Arc::new(meshes::image_of_array(&image)?));
        }
        Ok(Self { inner: Mutex::new(inner) })
    }

    /// Number that changes with each edit.
    #[getter]
    fn revision(&self) -> u64 {
        self.lock().revision
    }

    /// Number of shapes.
    #[getter]
    fn shapes(&self, py: Python<'_>) -> PyResult<usize> {
        guarded(py, || on_threads(|| Ok(self.lock().read()?.shapes.len())))
    }

    /// Text of the scene file.
    fn text(&self) -> String {
        self.lock().document.to_string()
    }

    /// Reads the text, at the moment `time` or at its own, and returns its warnings.
    #[pyo3(signature = (time=None))]
    fn check(&self, py: Python<'_>, time: Option<f64>) -> PyResult<Vec<String>> {
        guarded(py, || on_threads(|| Ok(self.lock().read_at(time)?.warnings.clone())))
    }

    /// Moment of animations and keyframes, in seconds, if one was set.
    #[getter]
    fn time(&self) -> Option<f64> {
        self.lock().assets.options().time_seconds
    }

    /// Sets the moment of animations and keyframes.
    #[setter]
    fn set_time(&self, time: Option<f64>) {
        let mut inner = self.lock();
        if inner.assets.options().time_seconds != time {
            inner.assets.set_time(time);
            inner.changed();
        }
    }

    /// Animations of the models of the scene: path of the file, name, first and last moment.
    fn animations(&self, py: Python<'_>) -> PyResult<Vec<(PathBuf, String, f64, f64)>> {
        guarded(py, || {
            on_threads(|| {
                let mut inner = self.lock();
                inner.read()?;
                let listed = inner.assets.animations();
                let listed = listed.into_iter().map(|(path, it)| {
                    let [start, end] = it.seconds;
                    (path.into(), it.name.clone(), start, end)
                });
                Ok(listed.collect())
            })
        })
    }

    /// Whether both are of the same shapes, materials, light, settings and numbers.
    fn equals(&self, py: Python<'_>, other: &Self) -> PyResult<bool> {
        guarded(py, || {
            on_threads(|| {
                if std::ptr::eq(self, other) {
                    return Ok(true);
                }
                let (one, two) = (self.read(None)?, other.read(None)?);
                Ok(one.ids == two.ids && one.scene == two.scene)
            })
        })
    }

    /// The value at `path` of the text; `None` where there is none.
    fn get<'py>(&self, py: Python<'py>, path: Vec<String>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let inner = self.lock();
        let mut found = inner.document.as_item();
        for key in &path {
            match found.get(key) {
                Some(item) => found = item,
                None => return Ok(None),
            }
        }
        values::item(py, found).map(Some)
    }

    /// Sets the value at `path`, of one or two keys, to that of a text; `None` takes it away. Where it is to be `checked`, all
    /// is read, and stays as it was if it is at fault. What only the old value had in memory is forgotten.
    #[pyo3(signature = (path, text, *, checked=false))]
    fn set(&self, py: Python<'_>, path: Vec<String>, text: Option<&str>, checked: bool) -> PyResult<()> {
        let value = text.map(parsed).transpose()?.map(Item::Value);
        guarded(py, || {
            on_threads(|| {
                let mut inner = self.lock();
                let old = put(&mut inner.document, &path, value)?;
                let before = (inner.read.take(), inner.revision);
                inner.changed();
                if checked && let Err(error) = inner.read() {
                    put(&mut inner.document, &path, old)?;
                    (inner.read, inner.revision) = before;
                    return Err(error);
                }
                inner.forget(old);
                Ok(())
            })
        })
    }

    /// Checks a shape and its material, named `name`, by themselves.
    #[staticmethod]
    fn check_shape(shape: &str, material: Option<&str>) -> PyResult<()> {
        let material = material.map_or(String::new(), |text| format!("materials = {{ material = {text} }}\n"));
        let text = format!("{NEW}{ANY_CAMERA}{material}shapes = [{shape}]\n");
        Scene::parse(&text, "shape").map(drop).map_err(|error| PyValueError::new_err(error.message))
    }

    /// Adds one of `[[shapes]]`, and returns its number: `id`, or one that no object has yet. Where it is to be `checked`, all
    /// is read, and stays as it was if it is at fault.
    #[pyo3(signature = (text, id=None, *, checked=false))]
    fn add_shape(&self, py: Python<'_>, text: &str, id: Option<i32>, checked: bool) -> PyResult<i32> {
        let Value::InlineTable(shape) = parsed(text)? else {
            return Err(PyValueError::new_err("a shape is a table"));
        };
        let mut inner = self.lock();
        let own = inner.own_shapes as i32;
        let id = match id {
            Some(id) if id > own => id,
            Some(id) if id < 1 => {
                return Err(PyValueError::new_err(format!(
                    "the id is {id}: give one from 1 on, for 0 is the background"
                )));
            }
            Some(id) => {
                let message = format!("the id {id} is that of a shape of the file, which has {own}: give a higher one");
                return Err(PyValueError::new_err(message));
            }
            None => inner.ids.iter().copied().max().unwrap_or(0).max(own) + 1,
        };
        push(inner.document.as_table_mut(), shape)?;
        inner.ids.push(id);
        inner.changed();
        drop(inner);
        if checked && let Err(error) = guarded(py, || on_threads(|| self.lock().read())) {
            self.take_last();
            return Err(error);
        }
        Ok(id)
    }

    /// Number of `[[shapes]]` that were added.
    #[getter]
    fn added(&self) -> usize {
        self.lock().ids.len()
    }

    /// Takes away the last of the `[[shapes]]` that were added.
    fn take_last(&self) {
        let mut inner = self.lock();
        if inner.ids.pop().is_some() {
            let shape = pop(inner.document.as_table_mut());
            inner.changed();
            inner.forget(shape);
        }
    }

    /// Puts a mesh into memory, and returns the name by which shapes have it, and a warning.
    #[pyo3(signature = (label, positions, triangles, normals, uvs, colors))]
    #[allow(clippy::too_many_arguments, reason = "a mesh has so many lists")]
    fn give_mesh(
        &self,
        label: &str,
        positions: PyReadonlyArray2<'_, f32>,
        triangles: PyReadonlyArray2<'_, u32>,
        normals: Option<PyReadonlyArray2<'_, f32>>,
        uvs: Option<PyReadonlyArray2<'_, f32>>,
        colors: Option<PyReadonlyArray2<'_, f32>>,
    ) -> PyResult<(String, Option<String>)> {
        let mesh = Mesh {
            positions: meshes::rows("vertices", &positions)?,
            triangles: meshes::rows("faces", &triangles)?,
            normals: normals.map(|normals| meshes::rows("normals", &normals)).transpose()?,
            uvs: [uvs.map(|uvs| meshes::rows("uvs", &uvs)).transpose()?, None],
            colors: colors.map(|colors| meshes::rows("colors", &colors)).transpose()?,
            ..Mesh::default()
        };
        let py = positions.py();
        guarded(py, || {
            let (mesh, warning) = meshes::clean(label, mesh)?;
            let mut inner = self.lock();
            let name = inner.new_name();
            inner.meshes.insert(name.clone(), Arc::new(mesh));
            Ok((name, warning))
        })
    }

    /// Places the mesh `name` in the world by the first three rows of a matrix, and returns the name of what results.
    fn place_mesh(&self, name: &str, rows: [f64; 12]) -> PyResult<String> {
        let mut inner = self.lock();
        let mesh = inner.meshes.get(name).cloned().ok_or_else(|| PyKeyError::new_err(name.to_owned()))?;
        let placed = inner.new_name();
        inner.place(placed.clone(), name, mesh, rows);
        Ok(placed)
    }

    /// Puts an image of linear radiance (height, width, 3) into memory, and returns its name.
    fn give_radiance(&self, image: PyReadonlyArray3<'_, f32>) -> PyResult<String> {
        Ok(self.give_image(meshes::radiance(&image)?))
    }

    /// Puts an image of bytes (height, width, 4) into memory, and returns its name.
    fn give_bytes(&self, image: PyReadonlyArray3<'_, u8>) -> PyResult<String> {
        Ok(self.give_image(meshes::bytes(&image)?))
    }
}

impl SceneText {
    fn give_image(&self, image: Bitmap) -> String {
        let mut inner = self.lock();
        let name = inner.new_name();
        inner.keep_image(name.clone(), Arc::new(image));
        name
    }
}

/// Checks a camera, which is a table.
#[pyfunction]
pub fn check_camera(text: &str) -> PyResult<()> {
    read_camera(text).map(drop)
}

/// Reads a camera, which is a table.
pub fn read_camera(text: &str) -> PyResult<Camera> {
    let scene = Scene::parse(&format!("{NEW}camera = {text}\nenvironment = {{ color = [1, 1, 1] }}\n"), "camera");
    scene.map(|scene| scene.camera).map_err(|error| PyValueError::new_err(error.message))
}

fn parsed(text: &str) -> PyResult<Value> {
    text.parse().map_err(|error| PyValueError::new_err(format!("{error}")))
}

/// Puts a value at `path`, or takes it away, and returns what was there.
fn put(document: &mut DocumentMut, path: &[String], value: Option<Item>) -> PyResult<Option<Item>> {
    let (key, tables) = path.split_last().ok_or_else(|| PyKeyError::new_err("a value has a name"))?;
    let mut table = document.as_item_mut();
    for key in tables {
        let root = table.as_table_like_mut().ok_or_else(|| PyKeyError::new_err(key.clone()))?;
        table = root.entry(key).or_insert(Item::Table(Table::new()));
    }
    let table = table.as_table_like_mut().ok_or_else(|| PyKeyError::new_err(key.clone()))?;
    Ok(match value {
        Some(value) => table.insert(key, value),
        None => table.remove(key),
    })
}

/// Takes the last shape away.
fn pop(root: &mut Table) -> Option<Item> {
    match root.get_mut("shapes") {
        Some(Item::ArrayOfTables(shapes)) => Some(Item::Table(shapes.remove(shapes.len() - 1))),
        Some(Item::Value(Value::Array(shapes))) => Some(Item::Value(shapes.remove(shapes.len() - 1))),
        _ => None,
    }
}

/// Appends a shape, in the way in which the text has the others.
fn push(root: &mut Table, shape: InlineTable) -> PyResult<()> {
    match root.entry("shapes").or_insert(Item::ArrayOfTables(ArrayOfTables::new())) {
        Item::ArrayOfTables(shapes) => shapes.push(shape.into_table()),
        Item::Value(Value::Array(shapes)) => push_inline(shapes, shape),
        _ => return Err(PyValueError::new_err("`shapes` is no list")),
    }
    Ok(())
}

fn push_inline(shapes: &mut Array, shape: InlineTable) {
    shapes.push_formatted(Value::InlineTable(shape).decorated("\n    ", ""));
}
