//! The one translator from a scene to what kernels read.

mod albedos;
mod materials;
mod shapes;

use std::collections::HashSet;
use std::f64::consts::PI;
use std::sync::Arc;

use glam::Vec3;
use raggio_kernels::{
    BvhNode, CameraMedium, Light as DeviceLight, LightKind as DeviceLightKind, MAX_NESTED_MEDIA, Motion, NO_TEXTURE,
    PixelFilter, SHEETS, SceneBuffers, SceneCounts, Sequence, ShapeKind, Sky as DeviceSky, Work,
};
use raggio_scene::{
    Environment, Filter, Geometry, Light, LightKind, Mesh, RenderSettings, Sampler, Scene, Sky, Texture, Wrap,
};

use crate::translation::bounds::shape_bounds;
use crate::translation::camera::device_camera;
use crate::translation::device_scene::albedos::albedos;
use crate::translation::device_scene::materials::{Materials, is_clear};
use crate::translation::device_scene::shapes::Shapes;
use crate::translation::error::TranslationError;
use crate::translation::filters::filter_table;
use crate::translation::hierarchy::{Bounds, Hierarchy, moved, room};
use crate::translation::lights::Lights;
use crate::translation::media::{Body, media_around};
use crate::translation::meshes::Meshes;
use crate::translation::motion::{frame_view, motion_rows};
use crate::translation::textures::{ColorSpace, TextureTable};

/// A scene as flat buffers, and the settings that every dispatch repeats.
#[derive(Clone, Debug)]
pub struct DeviceScene {
    /// Buffers that the kernels read.
    pub buffers: SceneBuffers,
    /// Resolution, depth and the like; the portion of work is filled in by the renderer.
    pub work: Work,
    /// Settings of the picture, as the scene has them.
    pub settings: RenderSettings,
    /// Index in the scene of the shape at each place of `buffers.order`.
    pub shape_of_place: Vec<u32>,
    boxed: Arc<Boxed>,
    meshes: Meshes,
    textures: TextureTable,
    lights: Lights,
}

/// Shapes in which hardware that traces rays lets kernels look for surfaces: all that have bounds and are no meshes.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Boxed {
    /// Places in `buffers.order`.
    pub places: Vec<u32>,
    /// Lower and upper corners of boxes around them, as much larger as the boxes of hierarchies are.
    pub boxes: Vec<[[f32; 3]; 2]>,
}

/// Rays along a path whose number is not limited: what is still left after so many is lost.
const LONGEST_PATH: u32 = 4096;

impl DeviceScene {
    /// Translates `scene`.
    ///
    /// # Errors
    /// A [`TranslationError`] when no device, or not this machine, can hold the scene.
    pub fn new(scene: &Scene) -> Result<Self, TranslationError> {
        let mut translated = Self {
            buffers: SceneBuffers::default(),
            work: Work::default(),
            settings: RenderSettings::default(),
            shape_of_place: vec![],
            boxed: Arc::default(),
            meshes: Meshes::default(),
            textures: TextureTable::default(),
            lights: Lights::default(),
        };
        translated.update(scene)?;
        Ok(translated)
    }

    /// Translates another scene. Lists over meshes that both have stay what they are, and where shapes have only moved
    /// their hierarchy is refitted.
    ///
    /// # Errors
    /// The errors of [`DeviceScene::new`]; what this was is lost then.
    pub fn update(&mut self, scene: &Scene) -> Result<(), TranslationError> {
        self.meshes.hold(&meshes_of(scene))?;
        let old = std::mem::take(&mut self.buffers);
        self.meshes.share(&mut self.buffers);
        self.textures.begin();
        self.buffers.constants_mut().sky = device_sky(&scene.environment, &mut self.textures)?;
        let materials = Materials::new(&scene.materials, scene.air.as_ref(), &mut self.textures)?;
        let properties = [materials.absorbing(), materials.scattering(), materials.seamless()];
        self.buffers.materials = materials.materials.into();
        self.buffers.principled = materials.principled.into();
        (self.buffers.textures, self.buffers.texels) = self.textures.finish();
        self.buffers.albedos = albedos();
        self.buffers.motion = vec![Motion::default()].into();
        let (suns, points) = lights(&scene.lights);
        let (sun_count, point_count) = (suns.len() as u32, points.len() as u32);
        self.buffers.lights = Arc::new([points, suns].concat());
        let mut shapes = Shapes::new(&scene.materials);
        let references: Vec<_> = scene.shapes.iter().map(|shape| shapes.add(shape, &self.meshes)).collect();
        shapes.share(&mut self.buffers);

        let boxes: Vec<_> = scene.shapes.iter().map(|shape| self.bounds(&shape.geometry)).collect();
        self.arrange(&boxes, &old.nodes);
        self.buffers.order = Arc::new(self.shape_of_place.iter().map(|&i| references[i as usize]).collect());
        self.boxed = Arc::new(self.boxes_without_meshes(&boxes));
        let counts = &mut self.buffers.constants_mut().counts;
        counts.lights = point_count;
        counts.suns = sun_count;
        [counts.absorbing, counts.scattering, counts.seamless] = properties.map(u32::from);
        counts.clear = u32::from(scene.materials.iter().any(is_clear));
        self.lights.share(&mut self.buffers);
        self.set_view(scene)
    }

    /// Tells how `scene`, which this is the translation of, has moved since `before`, the frame before it.
    pub fn move_from(&mut self, scene: &Scene, before: &Scene) {
        let camera = device_camera(&before.camera, &before.render);
        let views = [frame_view(&self.buffers.constants().camera), frame_view(&camera)];
        self.buffers.motion = vec![Motion { now: views[0], before: views[1], moves: 1 }].into();
        self.buffers.motion_rows = motion_rows(scene, before, &self.shape_of_place).into();
    }

    fn bounds(&self, geometry: &Geometry) -> Option<Bounds> {
        shape_bounds(geometry, |mesh| self.meshes.place(mesh).map_or(Bounds::EMPTY, |place| self.meshes.bounds(place)))
    }

    /// Orders shapes: first those without bounds, for they are tried one by one, then the others as the leaves stand.
    fn arrange(&mut self, boxes: &[Option<Bounds>], old: &[BvhNode]) {
        let (unbounded, bounded): (Vec<u32>, Vec<u32>) =
            (0..boxes.len() as u32).partition(|&i| boxes[i as usize].is_none());
        let held: Vec<Bounds> = boxes.iter().copied().flatten().collect();
        let same = self.shape_of_place.len() == boxes.len() && self.shape_of_place.starts_with(&unbounded);
        if same
            && let Some(nodes) =
                Hierarchy::refit(old, unbounded.len() as u32, &self.shape_of_place[unbounded.len()..], boxes)
        {
            self.buffers.nodes = Arc::new(nodes);
        } else {
            let Hierarchy { nodes, order, .. } = Hierarchy::build(&held);
            let first_place = unbounded.len() as u32;
            self.buffers.nodes = Arc::new(nodes.iter().map(|node| moved(node, 0, first_place)).collect());
            let order = order.iter().map(|&i| bounded[i as usize]);
            self.shape_of_place = unbounded.iter().copied().chain(order).collect();
        }
        let [shapes, unbounded, nodes] = [boxes.len(), unbounded.len(), self.buffers.nodes.len()].map(|n| n as u32);
        self.buffers.constants_mut().counts =
            SceneCounts { shapes, unbounded, tried: unbounded, nodes, ..SceneCounts::default() };
    }

    /// Bounded shapes that are no meshes.
    fn boxes_without_meshes(&self, boxes: &[Option<Bounds>]) -> Boxed {
        let all = boxes.iter().copied().flatten().fold(Bounds::EMPTY, Bounds::union);
        let places = self.shape_of_place.iter().zip(&*self.buffers.order).zip(0..);
        let boxed = places.filter_map(|((&shape, reference), place)| {
            let Bounds(lower, upper) =
                boxes[shape as usize].filter(|_| reference.kind != ShapeKind::Instance as u32)?;
            let room = Vec3::from(room(all));
            Some((place, [lower - room, upper + room].map(|corner| corner.to_array())))
        });
        let (places, boxes) = boxed.unzip();
        Boxed { places, boxes }
    }

    /// Bounded shapes that are no meshes.
    pub(crate) fn boxed(&self) -> &Arc<Boxed> {
        &self.boxed
    }

    /// The meshes, in the order of `buffers.meshes`.
    pub(crate) fn meshes(&self) -> impl ExactSizeIterator<Item = &Arc<Mesh>> {
        self.meshes.iter()
    }

    /// Looks at the same scene from another camera, or with other settings: `scene` differs from the one this was made
    /// of in nothing else. Takes no longer for large scenes than for small ones, unless bodies surround the camera.
    ///
    /// # Errors
    /// A [`TranslationError::TooManyMedia`] when more bodies surround the camera than a path remembers.
    pub fn set_view(&mut self, scene: &Scene) -> Result<(), TranslationError> {
        let media = camera_media(scene, &self.shape_of_place)?;
        let constants = self.buffers.constants_mut();
        constants.camera = device_camera(&scene.camera, &scene.render);
        constants.counts.camera_media = media.len() as u32;
        constants.camera_media = Default::default();
        constants.camera_media[..media.len()].copy_from_slice(&media);
        self.buffers.filter_table = filter_table(scene.render.filter).into();
        self.work = work(&scene.render);
        self.settings = scene.render.clone();
        Ok(())
    }

    /// Gives up hierarchies of meshes, which devices have taken over. Neither may this be loaded afterwards, nor
    /// [updated](Self::update).
    pub(crate) fn settle(&mut self) {
        self.buffers.mesh_nodes = Arc::default();
        self.meshes.settle();
    }

    /// Number of shapes in the scene.
    pub fn shapes(&self) -> usize {
        self.buffers.order.len()
    }

    /// Number of triangles in the scene, those of each mesh once.
    pub fn triangles(&self) -> usize {
        self.buffers.triangles.len()
    }
}

/// The different meshes of a scene.
fn meshes_of(scene: &Scene) -> Vec<Arc<Mesh>> {
    let mut known = HashSet::new();
    let meshes = scene.shapes.iter().filter_map(|shape| match &shape.geometry {
        Geometry::Mesh { mesh, .. } => Some(mesh),
        _ => None,
    });
    meshes.filter(|mesh| known.insert(Arc::as_ptr(mesh))).cloned().collect()
}

/// The bodies around the camera, outermost first: the air is one.
fn camera_media(scene: &Scene, shape_of_place: &[u32]) -> Result<Vec<CameraMedium>, TranslationError> {
    let around = media_around(scene);
    // The last material is that of the air.
    let air = scene.air.map(|_| scene.materials.len() as u32);
    let air = air.map(|material| CameraMedium { shape: SHEETS | material, material });
    let (found, limit) = (around.len() + usize::from(air.is_some()), MAX_NESTED_MEDIA as usize);
    if found > limit {
        return Err(TranslationError::TooManyMedia { found, limit });
    }
    let place = |shape: u32| shape_of_place.iter().position(|s| *s == shape).unwrap_or_default() as u32;
    let medium = |body: &Body| CameraMedium { shape: place(body.shape), material: body.material as u32 };
    Ok(air.into_iter().chain(around.iter().map(medium)).collect())
}

fn work(render: &RenderSettings) -> Work {
    Work {
        width: render.width,
        height: render.height,
        seed: render.seed,
        sequence: match render.sampler {
            Sampler::Sobol => Sequence::Sobol,
            Sampler::Pcg => Sequence::Pcg,
        } as u32,
        max_depth: if render.max_depth == 0 { LONGEST_PATH } else { render.max_depth },
        filter: match render.filter {
            Filter::Box => PixelFilter::Box,
            Filter::Point => PixelFilter::Point,
            Filter::BlackmanHarris | Filter::Mitchell => PixelFilter::Tabulated,
        } as u32,
        clamp: render.clamp.unwrap_or(f32::INFINITY),
        transparent: u32::from(render.alpha),
        surface_offset: u32::from(render.surface_offset),
        ..Work::default()
    }
}

fn device_sky(environment: &Environment, textures: &mut TextureTable) -> Result<DeviceSky, TranslationError> {
    let gradient = |horizon: &Vec3, zenith: &Vec3| DeviceSky {
        horizon: horizon.to_array(),
        zenith: zenith.to_array(),
        image: NO_TEXTURE,
        intensity: 1.0,
    };
    Ok(match environment {
        Environment::Constant(radiance) => gradient(radiance, radiance),
        Environment::Gradient { horizon, zenith } => gradient(horizon, zenith),
        Environment::Image { image, rotation_degrees, intensity }
        | Environment::Sky(Sky { image, rotation_degrees, intensity, .. }) => {
            // A turn about the y axis moves the image to the side.
            let turns = (f64::from(*rotation_degrees) / 360.0).rem_euclid(1.0) as f32;
            let texture = Texture {
                transform: [[1.0, 0.0, turns], [0.0, 1.0, 0.0]],
                wrap: [Wrap::Repeat, Wrap::ClampToEdge],
                ..Texture::new(image.clone())
            };
            let image = textures.add(&texture, ColorSpace::Srgb)?;
            DeviceSky { image, intensity: *intensity, ..DeviceSky::default() }
        }
    })
}

/// Suns that shine, and lights without size.
fn lights(lights: &[Light]) -> (Vec<DeviceLight>, Vec<DeviceLight>) {
    let lights = lights.iter().map(device_light);
    let is_sun = |light: &DeviceLight| light.kind == DeviceLightKind::Sun as u32;
    let (suns, points): (Vec<_>, Vec<_>) = lights.partition(is_sun);
    // Each sun has its emitter, which a light of no power has not.
    (suns.into_iter().filter(|sun| sun.intensity != [0.0; 3]).collect(), points)
}

fn device_light(light: &Light) -> DeviceLight {
    // KHR_lights_punctual: how a spot fades between its two angles.
    let mut intensity = light.intensity;
    let (kind, angle_scale, angle_offset) = match light.kind {
        LightKind::Directional => (DeviceLightKind::Directional, 0.0, 1.0),
        LightKind::Point => (DeviceLightKind::Point, 0.0, 1.0),
        LightKind::Sun { half_angle } => {
            let half_angle = f64::from(half_angle);
            // A disk of the radiance 1 causes the irradiance pi sin^2 on what faces it.
            let disk = PI * half_angle.sin().powi(2);
            intensity = intensity.map(|component| (f64::from(component) / disk) as f32);
            (DeviceLightKind::Sun, 0.0, (2.0 * (0.5 * half_angle).sin().powi(2)) as f32)
        }
        LightKind::Spot { inner, outer } => {
            let (inner, outer) = (f64::from(inner).cos(), f64::from(outer).cos());
            // Equal angles are a hard edge.
            let scale = 1.0 / (inner - outer).max(1e-6);
            (DeviceLightKind::Spot, scale as f32, (-outer * scale) as f32)
        }
    };
    DeviceLight {
        position: light.position.as_vec3().to_array(),
        kind: kind as u32,
        direction: light.direction.as_vec3().to_array(),
        angle_scale,
        intensity,
        angle_offset,
    }
}
