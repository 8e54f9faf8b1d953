//! Mirrors whose shading normal is another than the geometry's: they keep all light, and send it where a mirror would, or
//! just above the horizon of the geometry.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use raggio_scene::{Bitmap, Principled, Scene, Texels, Texture};
use raggio_tests::{Pcg, for_each_device, parse};

use crate::samplers::bsdf::{Ray, Third, ask, bumps, rays, scene_of_octahedron};

/// Image of one texel, a normal that leans by `degrees` to the right.
fn leaning(degrees: f64) -> Option<Texture> {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let texel = DVec3::new(0.5 + 0.5 * sine, 0.5, 0.5 + 0.5 * cosine).as_vec3().to_array();
    Some(Texture::new(Arc::new(Bitmap { width: 1, height: 1, texels: Texels::Rgb32F(vec![texel]) })))
}

/// Kinds of mirrors, with normals that lean by `degrees` to the right.
fn mirrors(degrees: f64) -> [(&'static str, Principled); 4] {
    let white = Principled { roughness: 0.0, base_color: [1.0; 3], ..Principled::default() };
    let mapped = Principled { normal_texture: leaning(degrees), ..white.clone() };
    let dark = Principled { base_color: [0.0; 3], specular: 0.0, clearcoat: 1.0, ..white };
    [
        ("metal", Principled { metallic: 1.0, ..mapped.clone() }),
        ("glass", Principled { transmission: 1.0, ior: 1.5, ..mapped.clone() }),
        ("sheet", Principled { transmission: 1.0, thin_walled: true, ior: 1.5, ..mapped }),
        ("coat", Principled { clearcoat_normal_texture: leaning(degrees), ..dark }),
    ]
}

/// Square in the plane z = 0 whose image has x to its right.
fn square(material: Principled) -> Scene {
    let mut scene = parse(
        "[camera]\nposition = [0, 0, 9]\nlook_at = [0, 0, 0]\nvertical_fov_degrees = 40\n[materials.a]\n\
         [[shapes]]\nmaterial = \"a\"\nrectangle = { corner = [-1, -1, 0], edge_u = [2, 0, 0], edge_v = [0, 2, 0] }\n",
    );
    scene.materials[0].principled = Some(Arc::new(material));
    scene
}

/// Ray that arrives from direction `wo`, and numbers that choose reflection.
fn question(wo: DVec3) -> (Ray, Third) {
    ((wo.as_vec3(), -wo.as_vec3(), 0.5), Third::Numbers([0.3, 0.6, 0.5, 0.0]))
}

#[test]
fn leaning_mirrors_reflect_above_the_horizon() {
    let sixty = 0.75f64.sqrt();
    let diagonal = 0.5f64.sqrt();
    // Degrees, direction to the eye, direction of the mirror, by hand: 2 (n.wo) n - wo, or that with z = 0.02.
    let cases = [
        (0.0, [0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]),
        (30.0, [0.0, 0.0, 1.0], [sixty, 0.0, 0.5]),
        (30.0, [diagonal, 0.0, diagonal], [0.258819, 0.0, 0.965926]),
        // To the left of the normal by 75 degrees: to 105 degrees on the right.
        (30.0, [-diagonal, 0.0, diagonal], [0.965926, 0.0, 0.02]),
        (45.0, [0.0, 0.0, 1.0], [1.0, 0.0, 0.02]),
        (60.0, [0.0, 0.0, 1.0], [sixty, 0.0, 0.02]),
        // n.wo is 0.4, and the mirror direction (0.4 sqrt(3), -0.6, -0.4).
        (60.0, [0.0, 0.6, 0.8], [0.4 * 3f64.sqrt(), -0.6, 0.02]),
        // An eye that grazes sees light that grazes half as much at the least.
        (60.0, [0.0, 0.9998, 0.02], [0.01732, -0.9998, 0.01]),
    ];
    for_each_device(|device| {
        for (degrees, wo, mirror) in cases {
            let wo = DVec3::from_array(wo).normalize();
            let expected = DVec3::from_array(mirror).normalize();
            for (what, material) in mirrors(degrees) {
                let found = &ask(&device, &square(material), [question(wo)].into_iter())[0];
                let what = format!("{}: {what}, {degrees} degrees, seen from {wo}", device.label);
                assert!(
                    found.delta && (found.wi.as_dvec3() - expected).length() < 1e-5,
                    "{what}: {found:?}, not {expected}"
                );
                // The coat alone shows where it leads to, and Fresnel's reflectance of it is the weight.
                let normal = (wo + expected).normalize();
                let weight = if what.contains("coat") { fresnel(normal.dot(wo)) } else { 1.0 };
                assert!((found.weight - weight as f32).abs().max_element() < 1e-5, "{what}: {found:?}, not {weight}");
            }
        }
    });
}

/// Reflectance of a boundary between 1 and 1.5.
fn fresnel(cosine: f64) -> f64 {
    let across = (1.0 - (1.0 - cosine * cosine) / 2.25).sqrt();
    let parallel = (cosine - across / 1.5) / (cosine + across / 1.5);
    let perpendicular = (cosine / 1.5 - across) / (cosine / 1.5 + across);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// White mirrors return all light, seen from wherever and leaning however.
#[test]
fn mirrors_keep_all_light() {
    for_each_device(|device| {
        let mut random = Pcg::new(31);
        let mut scenes = vec![("plain".to_owned(), scene_of_octahedron("smoothness = 1"))];
        scenes[0].1.materials[0].color = Vec3::ONE;
        let metal = Principled { metallic: 1.0, roughness: 0.0, base_color: [1.0; 3], ..Principled::default() };
        for (what, surface) in [("smooth", metal.clone()), ("bumpy", Principled { normal_texture: bumps(), ..metal })] {
            let mut scene = scene_of_octahedron("");
            scene.materials[0].principled = Some(Arc::new(surface));
            scenes.push((what.to_owned(), scene));
        }
        for (what, scene) in &scenes {
            let rays = rays(device.pick(20_000, 5000), &mut random);
            let numbers = rays.iter().map(|ray| (*ray, Third::Numbers([0; 4].map(|_| random.unit()))));
            assert_white(&format!("{}: {what}", device.label), &ask(&device, scene, numbers));
        }
        for degrees in (0..=60).step_by(10) {
            let [(_, metal), ..] = mirrors(f64::from(degrees));
            let views = (0..2000).map(|_| {
                // A third of the views graze.
                let up = if random.below(3) == 0 { 1e-3 + 0.1 * random.unit() } else { random.unit() };
                let wo = random.direction().with_z(0.0).normalize() * (1.0 - f64::from(up).powi(2)).sqrt();
                question(wo.with_z(f64::from(up)))
            });
            assert_white(&format!("{}: {degrees} degrees", device.label), &ask(&device, &square(metal), views));
        }
    });
}

/// Directions that graze so closely that rounding decides are directions still.
#[test]
fn views_that_graze_are_finite() {
    for_each_device(|device| {
        let mut random = Pcg::new(32);
        for degrees in [0.0, 1e-3, 30.0] {
            for (what, material) in mirrors(degrees) {
                let views = (0..2000).map(|_| {
                    let up = 10f64.powf(-10.0 + 7.0 * f64::from(random.unit()));
                    question((random.direction().with_z(0.0).normalize()).with_z(up))
                });
                for sample in ask(&device, &square(material.clone()), views) {
                    let sound = sample.wi.is_normalized() && sample.weight.is_finite();
                    assert!(sound, "{}: {what}, {degrees} degrees: {sample:?}", device.label);
                }
            }
        }
    });
}

#[track_caller]
fn assert_white(what: &str, samples: &[crate::samplers::bsdf::Sample]) {
    let lost = samples.iter().filter(|s| (s.weight - Vec3::ONE).abs().max_element() > 1e-5).collect::<Vec<_>>();
    assert!(lost.is_empty(), "{what}: {} of {} directions lose light, {:?} first", lost.len(), samples.len(), lost[0]);
}
