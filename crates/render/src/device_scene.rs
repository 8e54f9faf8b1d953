//! The one translator from a scene to what kernels read.

use glam::{DMat4, DVec4, Vec3};
use raggio_kernels::{
    Box as DeviceBox, Camera as DeviceCamera, CameraMedium, MAX_NESTED_MEDIA, Material as DeviceMaterial, Plane,
    Rectangle, SceneBuffers, SceneCounts, ShapeKind, ShapeReference, Sky, Sphere, Work,
};
use raggio_scene::{
    Camera, Environment, Filter, Geometry, Material, Reflection, RenderSettings, Scene, Shape, rotation,
};

use crate::bounds::bounds;
use crate::hierarchy::Hierarchy;
use crate::media::media_around;

/// A scene as flat buffers, and the settings that every dispatch repeats.
#[derive(Clone, Debug)]
pub struct DeviceScene {
    /// What the kernels read.
    pub buffers: SceneBuffers,
    /// Resolution, depth and the like; the portion of work is filled in by the renderer.
    pub work: Work,
    /// For each place in `buffers.order`, the shape's index in the scene.
    pub shape_of_place: Vec<u32>,
}

/// A scene that no device can hold.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TranslationError {
    /// More bodies around the camera than a path remembers.
    #[error("the camera is inside {found} dielectric bodies at once, and a path can remember {limit}")]
    TooManyMedia {
        /// How many there are.
        found: usize,
        /// How many there may be.
        limit: usize,
    },
}

impl DeviceScene {
    /// Translates `scene`.
    pub fn new(scene: &Scene) -> Result<Self, TranslationError> {
        let mut buffers = SceneBuffers {
            camera: vec![device_camera(&scene.camera, &scene.render)],
            sky: vec![device_sky(&scene.environment)],
            materials: scene.materials.iter().map(device_material).collect(),
            ..SceneBuffers::default()
        };
        let references: Vec<_> = scene.shapes.iter().map(|shape| add_shape(&mut buffers, shape)).collect();

        // Shapes without bounds come first, for they are tried one by one; the others in the order of the leaves.
        let (unbounded, bounded): (Vec<u32>, Vec<u32>) =
            (0..scene.shapes.len() as u32).partition(|&i| bounds(&scene.shapes[i as usize].geometry).is_none());
        let hierarchy = Hierarchy::build(scene, &bounded, unbounded.len() as u32);
        let shape_of_place = [unbounded.as_slice(), &hierarchy.order].concat();
        buffers.order = shape_of_place.iter().map(|&i| references[i as usize]).collect();
        buffers.nodes = hierarchy.nodes;
        buffers.camera_media = camera_media(scene, &shape_of_place)?;
        buffers.counts = vec![SceneCounts {
            shapes: buffers.order.len() as u32,
            unbounded: unbounded.len() as u32,
            nodes: buffers.nodes.len() as u32,
            camera_media: buffers.camera_media.len() as u32,
        }];
        Ok(Self { buffers, work: settings(&scene.render), shape_of_place })
    }

    /// Looks at the same scene from another camera, or with other settings: `scene` differs from the one this was made
    /// of in nothing else. Takes no longer for large scenes than for small ones, unless bodies surround the camera.
    pub fn set_view(&mut self, scene: &Scene) -> Result<(), TranslationError> {
        self.buffers.camera = vec![device_camera(&scene.camera, &scene.render)];
        self.buffers.camera_media = camera_media(scene, &self.shape_of_place)?;
        for counts in &mut self.buffers.counts {
            counts.camera_media = self.buffers.camera_media.len() as u32;
        }
        self.work = settings(&scene.render);
        Ok(())
    }

    /// Shapes in it.
    pub fn shapes(&self) -> usize {
        self.buffers.order.len()
    }
}

/// The dielectric bodies around the camera, outermost first.
fn camera_media(scene: &Scene, shape_of_place: &[u32]) -> Result<Vec<CameraMedium>, TranslationError> {
    let around = media_around(scene);
    let (found, limit) = (around.len(), MAX_NESTED_MEDIA as usize);
    if found > limit {
        return Err(TranslationError::TooManyMedia { found, limit });
    }
    let place = |shape: &u32| shape_of_place.iter().position(|s| s == shape).unwrap_or_default() as u32;
    let medium = |shape| CameraMedium { shape: place(shape), material: scene.shapes[*shape as usize].material as u32 };
    Ok(around.iter().map(medium).collect())
}

fn settings(render: &RenderSettings) -> Work {
    Work {
        width: render.width,
        height: render.height,
        seed: render.seed,
        max_depth: render.max_depth,
        point_filter: u32::from(render.filter == Filter::Point),
        surface_offset: u32::from(render.surface_offset),
        ..Work::default()
    }
}

fn device_camera(camera: &Camera, render: &RenderSettings) -> DeviceCamera {
    let eye = camera.position.as_dvec3();
    let back = (eye - camera.look_at.as_dvec3()).normalize();
    let right = camera.up.as_dvec3().cross(back).normalize();
    let up = back.cross(right);
    let world_from_view = DMat4::from_cols(right.extend(0.0), up.extend(0.0), back.extend(0.0), eye.extend(1.0));

    // The inverse of the usual perspective projection, with its planes at 1 and 2: only directions are taken from it.
    let half_height = (f64::from(camera.vertical_fov_degrees).to_radians() / 2.0).tan();
    let half_width = half_height * f64::from(render.width) / f64::from(render.height);
    let view_from_clip = DMat4::from_cols(
        DVec4::X * half_width,
        DVec4::Y * half_height,
        DVec4::W * -0.25,
        DVec4::new(0.0, 0.0, -1.0, 0.75),
    );
    DeviceCamera {
        world_from_view: rows(world_from_view),
        view_from_clip: rows(view_from_clip),
        aperture_radius: camera.aperture_radius,
        focus_distance: camera.focus_distance,
    }
}

fn rows(matrix: DMat4) -> [[f32; 4]; 4] {
    [0, 1, 2, 3].map(|i| matrix.row(i).as_vec4().to_array())
}

fn device_sky(environment: &Environment) -> Sky {
    let (horizon, zenith) = match environment {
        Environment::Constant(radiance) => (*radiance, *radiance),
        Environment::Gradient { horizon, zenith } => (*horizon, *zenith),
    };
    Sky { horizon: horizon.to_array(), zenith: zenith.to_array() }
}

fn device_material(material: &Material) -> DeviceMaterial {
    DeviceMaterial {
        color: material.color.to_array(),
        emission: (material.emission_color * material.emission_strength).to_array(),
        smoothness: material.smoothness,
        refractive_index: material.refractive_index.unwrap_or(0.0),
        reflection: match material.reflection {
            Reflection::Fresnel => -1.0,
            Reflection::Probability(p) => p,
        },
        priority: material.priority,
    }
}

/// Appends `shape` to the buffer of its kind.
fn add_shape(buffers: &mut SceneBuffers, shape: &Shape) -> ShapeReference {
    fn push<T>(buffer: &mut Vec<T>, kind: ShapeKind, shape: T) -> ShapeReference {
        buffer.push(shape);
        ShapeReference { kind: kind as u32, index: buffer.len() as u32 - 1 }
    }
    let material = shape.material as u32;
    match shape.geometry {
        Geometry::Sphere { center, radius } => {
            push(&mut buffers.spheres, ShapeKind::Sphere, Sphere { center: center.to_array(), radius, material })
        }
        Geometry::Plane { point, normal } => push(
            &mut buffers.planes,
            ShapeKind::Plane,
            Plane { point: point.to_array(), normal: normal.to_array(), material },
        ),
        Geometry::Rectangle { corner, edge_u, edge_v } => {
            let normal = edge_u.as_dvec3().cross(edge_v.as_dvec3()).normalize().as_vec3();
            let [corner, edge_u, edge_v, normal] = [corner, edge_u, edge_v, normal].map(|v: Vec3| v.to_array());
            push(&mut buffers.rectangles, ShapeKind::Rectangle, Rectangle { corner, edge_u, edge_v, normal, material })
        }
        Geometry::Box { center, size, rotation_degrees } => {
            let axes = rotation(rotation_degrees);
            let [axis_x, axis_y, axis_z] = [axes.x_axis, axes.y_axis, axes.z_axis].map(|a| a.as_vec3().to_array());
            let half_size = (size * 0.5).to_array();
            let center = center.to_array();
            push(&mut buffers.boxes, ShapeKind::Box, DeviceBox { center, half_size, axis_x, axis_y, axis_z, material })
        }
    }
}
