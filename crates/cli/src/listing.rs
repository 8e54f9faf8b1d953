use std::path::Path;

use raggio_render::{Denoiser, DeviceScene, Tracer};
use raggio_scene::{AssetOptions, Assets, Counts, Scene, counted, display_name, is_model};

use crate::error::Failure;
use crate::output::{print, say};

pub fn devices() -> Result<(), Failure> {
    let (devices, trouble) = raggio_render::devices();
    let memory =
        |bytes: Option<u64>| bytes.map_or("?".into(), |b| format!("{:.1} GiB", b as f64 / (1u64 << 30) as f64));
    let width = |of: &dyn Fn(usize) -> usize| (0..devices.len()).map(of).max().unwrap_or(0);
    let id_width = width(&|i| devices[i].id.len());
    let name_width = width(&|i| devices[i].name.len());
    let driver_width = width(&|i| devices[i].driver.len());
    for device in &devices {
        let state = if device.missing.is_empty() {
            let more = match (device.has_ray_queries, device.tracer) {
                (true, Tracer::Software) => ", by ray queries with --tracer hardware",
                _ => "",
            };
            format!("ready, traces rays by {}{more}", device.tracer)
        } else {
            format!("cannot be used: lacks {}", device.missing.join(", "))
        };
        print(format_args!(
            "{:id_width$}  {:name_width$}  {:10}  {:driver_width$}  {:>10}  {state}",
            device.id,
            device.name,
            device.kind,
            device.driver,
            memory(device.memory_bytes),
        ))?;
    }
    if let Some(trouble) = trouble {
        print(format_args!("vulkan    none: {trouble}"))?;
    }
    match Denoiser::open() {
        Ok(denoiser) => {
            let gpus = denoiser.gpus();
            let gpus = gpus.iter().map(|(gpu, interface)| format!("{} ({})", gpu.name, interface.name()));
            let places: Vec<_> = gpus.chain(["the CPU".into()]).collect();
            print(format_args!("denoiser  {} on {}", denoiser.name(), places.join(", ")))
        }
        Err(error) => print(format_args!("denoiser  none: {error}")),
    }
}

pub fn check(path: &Path, options: AssetOptions) -> Result<(), Failure> {
    let mut assets = Assets::new(options);
    let scene = Scene::load_with(path, &mut assets)?;
    DeviceScene::new(&scene).map_err(|e| Failure::Input(format!("{}: {e}", display_name(path))))?;
    for warning in &scene.warnings {
        say(format_args!("warning: {warning}"));
    }
    let Counts { triangles, meshes, instances, textures } = scene.counts();
    let from_files = match (instances, textures) {
        (0, 0) => String::new(),
        (0, _) => format!(", {}", counted(textures, "texture")),
        _ => {
            let [textures, meshes] = [counted(textures, "texture"), counted(meshes, "mesh")];
            let [triangles, instances] = [counted(triangles, "triangle"), counted(instances, "instance")];
            format!(", {textures}, {meshes} with {triangles} in {instances}")
        }
    };
    print(format_args!(
        "{}: {}, {}{}, {}x{}, {}",
        display_name(path),
        counted(scene.entries.len(), "shape"),
        counted(scene.materials.len(), "material"),
        from_files,
        scene.render.width,
        scene.render.height,
        counted(scene.render.samples as usize, "sample"),
    ))?;
    if is_model(path) {
        for camera in raggio_scene::cameras(path, &mut assets) {
            print(format_args!("camera {camera}"))?;
        }
    }
    Ok(())
}

pub fn schema() -> Result<(), Failure> {
    print(raggio_scene::schema())
}
