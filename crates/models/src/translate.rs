//! Translation of PLY, STL and OBJ into a [`Model`]: one mesh, placed once.

use std::sync::Arc;

use glam::DAffine3;

use crate::mesh::MeshFile;
use crate::model::{Instance, Material, Model};

impl MeshFile {
    /// The mesh as a model called `name`, with `materials` for those that its parts name. A file without triangles gives
    /// a model without meshes.
    pub(crate) fn into_model(self, name: &str, materials: Vec<Material>) -> Model {
        let Self { mesh, dropped, mut warnings, .. } = self;
        warnings.extend(dropped.warning());
        let mut model = Model { materials, warnings, ..Model::default() };
        if !mesh.triangles.is_empty() {
            model.meshes.push(Arc::new(mesh));
            model.instances.push(Instance { name: name.into(), mesh: 0, model_from_mesh: DAffine3::IDENTITY });
        }
        model
    }
}
