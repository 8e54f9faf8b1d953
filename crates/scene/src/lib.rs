//! The scene of raggio as plain data.
//!
//! A scene file goes one way through this crate: TOML text is read into types that mirror the
//! file (`file`), each of whose numbers checks its own range (`number`); what needs more than one
//! key is checked while those types become a [`Scene`] (`convert`). What is wrong is gathered on the way (`review`), and every
//! error names the place in the file, what is wrong there and what would be right. Models and images that the file names are read once and
//! kept in [`Assets`]; a model without a scene gets one that shows it (`showing`).
//!
//! ```
//! let text = r#"
//! version = 1
//! [camera]
//! position = [0, 1, 4]
//! look_at = [0, 1, 0]
//! vertical_fov_degrees = 40
//! [environment]
//! colour = [1, 1, 1]
//! "#;
//! let error = raggio_scene::Scene::parse(text, "scene.toml").unwrap_err();
//! assert_eq!(
//!     error.to_string(),
//!     "scene.toml:8:1: unknown key `colour` in [environment]: did you mean `color`?"
//! );
//! ```
#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod assets;
mod convert;
mod counts;
mod curve;
mod error;
mod fault;
mod file;
mod hints;
mod load;
mod named;
mod names;
mod number;
mod reader;
mod review;
mod rock;
mod scene;
mod schema;
mod showing;
mod sky;
mod source;

pub use assets::{AssetOptions, Assets, is_model};
pub use counts::{Counts, counted};
pub use curve::Interpolation;
pub use error::SceneError;
pub use glam::{DAffine3, DMat3, DVec3, Vec3};
pub use load::scene_text;
pub use names::display_name;
pub use raggio_choice::{Choice, UnknownName};
pub use raggio_images::{Bitmap, Texels};
pub use raggio_models::{
    AlphaMode, Animation, Format as ModelFormat, Instance, Light, LightKind, Mesh, Model, ModelError, Part, Principled,
    Texture, TextureFilter, Wrap,
};
pub use scene::{
    Camera, Contents, Entry, Environment, Filter, Geometry, Integrator, Intrinsics, LightEntry, LightPlace, Material,
    Medium, Panorama, Placement, Projection, Reflection, RenderSettings, Sampler, Scene, Shape, Transform, axes_around,
    rotation,
};
pub use schema::schema;
pub use showing::cameras;
pub use sky::{Moment, Sky, SunPlace};
