use std::path::Path;

use raggio_render::DeviceScene;
use raggio_scene::Scene;

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
            "ready".into()
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
        ));
    }
    if let Some(trouble) = trouble {
        print(format_args!("vulkan    none: {trouble}"));
    }
    Ok(())
}

pub fn check(path: &Path) -> Result<(), Failure> {
    let scene = Scene::load(path)?;
    DeviceScene::new(&scene).map_err(|e| Failure::Input(format!("{}: {e}", path.display())))?;
    for warning in &scene.warnings {
        say(format_args!("warning: {warning}"));
    }
    let count = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
    print(format_args!(
        "{}: {}, {}, {}x{}, {}",
        path.display(),
        count(scene.shapes.len(), "shape"),
        count(scene.materials.len(), "material"),
        scene.render.width,
        scene.render.height,
        count(scene.render.samples as usize, "sample"),
    ));
    Ok(())
}

pub fn schema() -> Result<(), Failure> {
    print(raggio_scene::schema());
    Ok(())
}
