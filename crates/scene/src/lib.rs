//! The scene of raggio as plain data.
//!
//! A scene file goes one way through this crate: TOML text is read into types that mirror the
//! file (`file`), each of whose numbers checks its own range (`number`); what needs more than one
//! key is checked while those types become a [`Scene`] (`convert`). Every error names the place
//! in the file, what is wrong there and what would be right.
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

mod convert;
mod error;
mod fault;
mod file;
mod load;
mod names;
mod number;
mod reader;
mod scene;
mod schema;
mod source;

pub use error::SceneError;
pub use glam::Vec3;
pub use load::{display_name, read_text};
pub use scene::{Camera, Environment, Filter, Geometry, Material, Reflection, RenderSettings, Scene, Shape, rotation};
pub use schema::schema;
