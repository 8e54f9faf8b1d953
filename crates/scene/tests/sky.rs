//! Skies by day: the sun's place, and radiance beside that of Mitsuba 3.9's `sunsky`.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use raggio_scene::{Environment, LightKind, Scene, Sky, SunPlace, Texels};

fn scene(environment: &str) -> Scene {
    let text = format!(
        "version = 1\n[camera]\nposition = [0, 1, 4]\nlook_at = [0, 1, 0]\nvertical_fov_degrees = 40\n[environment]\n{environment}"
    );
    Scene::parse(&text, "scene.toml").expect("the scene is right")
}

fn sky(environment: &str) -> Sky {
    let Environment::Sky(sky) = scene(environment).environment else { panic!("a sky") };
    sky
}

/// Texel that is seen in `direction`.
fn texel(sky: &Sky, direction: DVec3) -> DVec3 {
    let Texels::Rgb32F(texels) = &sky.image.texels else { panic!("floats") };
    let direction = direction.normalize();
    let u = 0.5 + direction.x.atan2(-direction.z) / TAU;
    let v = direction.y.acos() / PI;
    let place = |at: f64, size: u32| ((at * f64::from(size)) as u32).min(size - 1);
    let (x, y) = (place(u, sky.image.width), place(v, sky.image.height));
    glam::Vec3::from(texels[(y * sky.image.width + x) as usize]).as_dvec3()
}

#[test]
fn by_direction_with_defaults() {
    let sky = sky("sun_direction = [1, 2, 0]");
    assert!(sky.sun.direction().abs_diff_eq(DVec3::new(1.0, 2.0, 0.0).normalize(), 1e-7));
    assert_eq!((sky.turbidity, sky.sun_intensity, sky.rotation_degrees, sky.intensity), (3.0, 1.0, 0.0, 1.0));
    assert_eq!(sky.ground_albedo, glam::Vec3::splat(0.2));
}

/// The example of NREL's report on its solar position algorithm: zenith 50.11 degrees, azimuth 194.34.
#[test]
fn by_place_and_time() {
    let [zenith, azimuth] = [50.111_62f64, 194.340_24].map(f64::to_radians);
    let (sine, cosine) = zenith.sin_cos();
    let expected = DVec3::new(azimuth.sin() * sine, cosine, -azimuth.cos() * sine);
    let place = "latitude_degrees = 39.742476\nlongitude_degrees = -105.1786\n";
    for time in ["2003-10-17T12:30:30-07:00", "2003-10-17T19:30:30Z", "\"2003-10-17 12:30:30-07:00\""] {
        let sky = sky(&format!("{place}time = {time}\n"));
        assert!(matches!(sky.sun, SunPlace::Moment { .. }));
        let off = sky.sun.direction().angle_between(expected).to_degrees();
        assert!(off < 0.01, "{time}: {off} degrees off");
    }
}

/// Mitsuba's z axis is up, and its y axis our -z.
#[test]
fn radiance_is_that_of_mitsuba() {
    let sky = sky("sun_direction = [0.5, 0.8660254, 0]");
    let cases = [
        ([0.0, 1.0, 0.0], [0.03489806, 0.05343746, 0.10063641]),
        ([1.0, 0.2, 0.0], [0.10970271, 0.16583598, 0.25534385]),
        ([-1.0, 0.2, 0.0], [0.07683841, 0.12620296, 0.20719245]),
        ([0.0, 1.0, -1.0], [0.03174729, 0.05732504, 0.11386503]),
        ([0.45, 0.9, 0.0], [0.1365148, 0.16199702, 0.19900467]),
    ];
    for (direction, expected) in cases {
        let (found, expected) = (texel(&sky, direction.into()), DVec3::from(expected));
        let off = ((found - expected) / expected).abs().max_element();
        assert!(off < 0.01, "{direction:?}: {found}, not {expected}");
    }
}

/// Two models of the sun, of 1999 and 2013, agree on one that is high.
#[test]
fn the_sun_is_about_that_of_mitsuba() {
    let scene = scene("sun_direction = [0.5, 0.8660254, 0]");
    let [sun] = &scene.lights[..] else { panic!("one light") };
    let LightKind::Sun { half_angle } = sun.kind else { panic!("a sun") };
    let radiance = glam::Vec3::from(sun.intensity).as_dvec3() / (PI * f64::from(half_angle).sin().powi(2));
    let expected = DVec3::new(21873.3, 18316.1, 14105.9);
    assert!(((radiance - expected) / expected).abs().max_element() < 0.08, "{radiance}, not {expected}");
    assert!(sun.direction.abs_diff_eq(-DVec3::new(0.5, 0.866_025_4, 0.0), 1e-6));
}

/// Low suns are red and dim, and haze dims them more.
#[test]
fn air_reddens_the_sun() {
    let sun = |elevation: f64, turbidity: f64| {
        let (y, x) = elevation.to_radians().sin_cos();
        let [r, g, b] = scene(&format!("sun_direction = [{x}, {y}, 0]\nturbidity = {turbidity}")).lights[0].intensity;
        assert!(r >= g && g >= b, "{elevation}: {r}, {g}, {b}");
        [r, b / r]
    };
    for [high, low] in [[sun(60.0, 3.0), sun(10.0, 3.0)], [sun(30.0, 2.0), sun(30.0, 6.0)]] {
        assert!(low[0] < 0.8 * high[0] && low[1] < high[1], "{low:?} {high:?}");
    }
}

#[test]
fn a_turn_and_factors() {
    let scene = |rest: &str| scene(&format!("sun_direction = [1, 1, 0]\n{rest}"));
    let plain = scene("").lights[0].clone();
    let turned = scene("rotation_degrees = 90\nintensity = 2\nsun_intensity = 3");
    let sun = &turned.lights[0];
    assert!(sun.direction.abs_diff_eq(DVec3::new(0.0, -1.0, 1.0).normalize(), 1e-6), "{}", sun.direction);
    assert!((sun.intensity[0] / plain.intensity[0] - 6.0).abs() < 1e-5);
    assert!(scene("sun_intensity = 0").lights.is_empty());
    assert!(scene("intensity = 0").lights.is_empty());
}
