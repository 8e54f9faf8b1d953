//! Functions of the kernels without randomness, against their definitions in double precision.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};
use raggio_render::{Probe, ToneMapper};
use raggio_tests::{Pcg, TestDevice, for_each_device, parse};

use crate::samplers::anywhere;

/// Tone mapper Khronos PBR Neutral, as its specification puts it.
fn neutral(color: DVec3) -> DVec3 {
    let low = color.min_element();
    let offset = if low < 0.08 { low - 6.25 * low * low } else { 0.04 };
    let color = color - offset;
    let peak = color.max_element();
    let start = 0.8 - 0.04;
    if peak < start {
        return color;
    }
    let room = 1.0 - start;
    let new_peak = 1.0 - room * room / (peak + room - start);
    let grey = 1.0 - 1.0 / (0.15 * (peak - new_peak) + 1.0);
    (color * new_peak / peak).lerp(DVec3::splat(new_peak), grey)
}

/// Tone mapper of Hill's fit of the ACES reference and output transforms.
fn aces(color: DVec3) -> DVec3 {
    let rows = |r: [[f64; 3]; 3]| DMat3::from_cols_array_2d(&r).transpose();
    let input = rows([[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]]);
    let output = rows([[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]]);
    let v = input * color;
    let fit = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.432951) + 0.238081);
    (output * fit).clamp(DVec3::ZERO, DVec3::ONE)
}

/// Tone mapper of Wrensch's approximation of AgX, made linear again.
fn agx(color: DVec3) -> DVec3 {
    let inset = DMat3::from_cols(
        DVec3::new(0.842479062253094, 0.0423282422610123, 0.0423756549057051),
        DVec3::new(0.0784335999999992, 0.878468636469772, 0.0784336),
        DVec3::new(0.0792237451477643, 0.0791661274605434, 0.879142973793104),
    );
    let stops = |x: f64| ((x.max(1e-10).log2() + 12.47393) / 16.5).clamp(0.0, 1.0);
    let curve = |x: f64| {
        [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232]
            .iter()
            .fold(0.0, |sum, coefficient| sum * x + coefficient)
    };
    let v = DVec3::from_array((inset * color).to_array().map(|x| curve(stops(x))));
    DVec3::from_array((inset.inverse() * v).to_array().map(|x| x.clamp(0.0, 1.0).powf(2.2)))
}

/// Tone mapper of Hable's curve, exposure bias and white included.
fn filmic(color: DVec3) -> DVec3 {
    let curve = |x: f64| (x * (0.15 * x + 0.05) + 0.004) / (x * (0.15 * x + 0.5) + 0.06) - 0.02 / 0.3;
    DVec3::from_array(color.to_array().map(|x| (curve(2.0 * x) / curve(11.2)).clamp(0.0, 1.0)))
}

/// Tone mapper of Reinhard's equation 4, of luminance.
fn reinhard(color: DVec3) -> DVec3 {
    let luminance = color.dot(DVec3::new(0.2126, 0.7152, 0.0722));
    (color * (1.0 + luminance / 16.0) / (1.0 + luminance)).clamp(DVec3::ZERO, DVec3::ONE)
}

#[test]
fn tone_mappers_are_what_they_are_called() {
    let mut random = Pcg::new(3);
    let mut color = || DVec3::from_array([0; 3].map(|_| 10f64.powf(random.between(-4.0, 3.0)))).as_vec3();
    let mut colors: Vec<_> = (0..1000).map(|_| color()).collect();
    colors.extend([0.0, 0.04, 0.08, 0.76, 0.8, 1.0].map(glam::Vec3::splat));
    let definition = |mapper, color: DVec3| match mapper {
        ToneMapper::Neutral => neutral(color),
        ToneMapper::Agx => agx(color),
        ToneMapper::Aces => aces(color),
        ToneMapper::Filmic => filmic(color),
        ToneMapper::Reinhard => reinhard(color),
        ToneMapper::None => color.clamp(DVec3::ZERO, DVec3::ONE),
    };
    for_each_device(|device| {
        for mapper in ToneMapper::ALL {
            // Results lie between 0 and 1; the longest formula takes about twenty roundings. The terms of AgX's are as
            // large as 40, and a device's powers and logarithms are less exact.
            let allowed = if mapper == ToneMapper::Agx { 4e-5 } else { 4e-6 };
            for (color, found) in colors.iter().zip(tone_mapped(device, mapper, &colors)) {
                let expected = definition(mapper, color.as_dvec3());
                let error = (found - expected).abs().max_element();
                assert!(error < allowed, "{}, {mapper:?} of {color}: expected {expected}, found {found}", device.label);
            }
        }
    });
}

fn tone_mapped(device: TestDevice, mapper: ToneMapper, colors: &[glam::Vec3]) -> Vec<DVec3> {
    let question = |c: &glam::Vec3| [c.extend(mapper as u32 as f32).to_array(), [0.0; 4], [0.0; 4]];
    let questions: Vec<_> = colors.iter().map(question).collect();
    let answers = device.ask(&anywhere(), Probe::ToneMap, &questions);
    answers.iter().map(|answer| glam::Vec3::from_slice(&answer[0]).as_dvec3()).collect()
}

/// Black stays black, greys get no darker as they get brighter, and nothing leaves what a display can show.
#[test]
fn tone_mappers_keep_to_what_a_display_shows() {
    let greys: Vec<_> = (0..600).map(|i| glam::Vec3::splat(2f32.powf(i as f32 / 10.0 - 30.0))).collect();
    let mut random = Pcg::new(4);
    let mut extreme = || match random.below(4) {
        0 => -random.log_between(1e-3, 3e38),
        1 => random.log_between(1e9, 3e38),
        _ => random.log_between(1e-30, 10.0),
    };
    let mut extremes: Vec<_> = (0..1000).map(|_| DVec3::from_array([(); 3].map(|()| extreme())).as_vec3()).collect();
    extremes.extend([1e30, -1e30, f32::INFINITY, f32::NEG_INFINITY].map(glam::Vec3::splat));
    for_each_device(|device| {
        for mapper in ToneMapper::ALL {
            let what = format!("{} {mapper:?}", device.label);
            let black = tone_mapped(device, mapper, &[glam::Vec3::ZERO])[0];
            assert!(black.max_element() < 1e-6, "{what}: black becomes {black}");
            for pair in tone_mapped(device, mapper, &greys).windows(2) {
                assert!(pair[1].cmpge(pair[0] - 1e-6).all(), "{what}: {} then {}", pair[0], pair[1]);
            }
            for (color, found) in extremes.iter().zip(tone_mapped(device, mapper, &extremes)) {
                let shown = found.cmpge(DVec3::ZERO).all() && found.cmple(DVec3::ONE).all();
                assert!(shown, "{what} of {color}: {found}");
            }
        }
    });
}

/// Rays go through the corners and the middle of the picture, from a camera that is turned, tilted and not square.
#[test]
fn pixels_become_rays() {
    let half = 25f64.to_radians().tan();
    rays_are("vertical_fov_degrees = 50", |x, y| {
        DVec3::new(half * 320.0 / 180.0 * (x / 160.0 - 1.0), half * (1.0 - y / 90.0), 1.0)
    });
}

/// Rays of a measured camera are those that its matrix projects to the pixel; a picture of another size has it in
/// proportion, and more to the sides.
#[test]
fn pixels_become_rays_by_intrinsics() {
    let projected = |x: f64, y: f64, [fx, fy]: [f64; 2], [cx, cy]: [f64; 2], skew: f64| {
        let down = (y - cy) / fy;
        DVec3::new((x - cx - skew * down) / fx, -down, 1.0)
    };
    let keys = "intrinsics = { focal = [250, 300], principal_point = [100.5, 120.25], skew = 12, size = [320, 180] }";
    rays_are(keys, |x, y| projected(x, y, [250.0, 300.0], [100.5, 120.25], 12.0));
    let keys = "intrinsics = { focal = [125, 150], principal_point = [50.25, 60.125], skew = 6, size = [160, 90] }";
    rays_are(keys, |x, y| projected(x, y, [250.0, 300.0], [100.5, 120.25], 12.0));
    // A square picture of 90 pixels is 180 high; what is 70 to either side is added.
    let keys = "intrinsics = { focal = [125, 150], principal_point = [50, 60], skew = 6, size = [90, 90] }";
    rays_are(keys, |x, y| projected(x, y, [250.0, 300.0], [100.0 + 70.0, 120.0], 12.0));
    // The middle is where a picture has it that says nothing.
    let focal = 90.0 / 25f64.to_radians().tan();
    let keys = format!("intrinsics = {{ focal = [{focal}, {focal}], size = [320, 180] }}");
    rays_are(&keys, |x, y| projected(x, y, [focal; 2], [160.0, 90.0], 0.0));
}

/// Rays of a panorama go around from left to right, and from straight up to straight down.
#[test]
fn pixels_become_rays_all_around() {
    rays_are("panorama = \"latitude-longitude\"", |x, y| {
        let (longitude, latitude) = (TAU * (x / 320.0 - 0.5), PI * (0.5 - y / 180.0));
        DVec3::new(latitude.cos() * longitude.sin(), latitude.sin(), latitude.cos() * longitude.cos())
    });
}

/// Asserts that the rays of a camera with these keys go where `expected` says, from points in pixels of a picture of 320 x
/// 180, along right, up and forward.
fn rays_are(keys: &str, expected: impl Fn(f64, f64) -> DVec3 + Sync) {
    let scene = parse(&format!(
        "[camera]\nposition = [1, 2, 3]\nlook_at = [-4, 1, 7]\nup = [0.2, 1, 0.1]\n{keys}\n\
         [render]\nwidth = 320\nheight = 180\n",
    ));
    let forward = (DVec3::new(-4.0, 1.0, 7.0) - DVec3::new(1.0, 2.0, 3.0)).normalize();
    let right = forward.cross(DVec3::new(0.2, 1.0, 0.1)).normalize();
    let up = right.cross(forward);
    for_each_device(|device| {
        for (x, y) in
            [(0.0, 0.0), (320.0, 0.0), (0.0, 180.0), (320.0, 180.0), (160.0, 90.0), (10.5, 100.25), (-1.5, 183.0)]
        {
            let [along_right, along_up, along] = expected(x, y).to_array();
            let expected = (along * forward + along_right * right + along_up * up).normalize();
            let question = [[x as f32, y as f32, 320.0, 180.0], [0.0; 4], [0.0; 4]];
            let answer = device.ask(&scene, Probe::Camera, &[question])[0];
            let origin = glam::Vec3::from_slice(&answer[0]);
            let direction = glam::Vec3::from_slice(&answer[1]).as_dvec3();
            assert_eq!(origin, glam::Vec3::new(1.0, 2.0, 3.0), "{}: pinhole rays start at the eye", device.label);
            let error = (direction - expected).length();
            assert!(error < 2e-6, "{}, {keys}, pixel ({x}, {y}): {direction}, not {expected}", device.label);
        }
    });
}
