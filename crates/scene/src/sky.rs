//! The daylit sky: its radiance by the model of Hosek and Wilkie [hosek2012sky], and the sun by that of Preetham and others
//! [preetham1999daylight].

use std::f32::consts::FRAC_PI_2;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use std::thread;

use glam::{DMat3, DVec3, Vec3};
use hw_skymodel::rgb::{Channel, SkyParams, SkyState};
use raggio_images::{Bitmap, Texels};
use raggio_models::{Light, LightKind};
use solar_positioning::delta_t;
use solar_positioning::time::JulianDate;
use solar_positioning::{Location, RefractionCorrection, SolarPositions};

/// Width of the image that a sky is baked into; it is half as high.
const WIDTH: u32 = 1024;
/// Half of the angle that the sun is wide, in radians.
const SUN_HALF_ANGLE: f64 = 0.265 * PI / 180.0;
/// Integral of the eye's curve in nanometres. Both models give radiance that this curve weighs, in W/m²/sr; divided by the
/// integral a white of 1 W/m²/sr/nm is 1, as in Mitsuba.
const CURVE_INTEGRAL: f64 = 106.750_26;

/// A clear or hazy sky by day, with the sun in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sky {
    /// Place of the sun.
    pub sun: SunPlace,
    /// Haziness of the air, 1 (pure) to 10 (hazy).
    pub turbidity: f32,
    /// Part of the light that the ground below the horizon reflects, each component 0 to 1.
    pub ground_albedo: Vec3,
    /// Factor of the light that comes straight from the sun; the sky is bright without (0), too.
    pub sun_intensity: f32,
    /// Angle by which the sky is turned about the y axis with its sun, counter-clockwise seen from above.
    pub rotation_degrees: f32,
    /// Factor of the radiance of the sky and the sun.
    pub intensity: f32,
    /// Radiance of the sky without the sun's disk, and of the ground, before it is turned: a latitude-longitude image, laid
    /// out as that of [`Environment::Image`](crate::Environment::Image).
    pub image: Arc<Bitmap>,
}

/// Place of the sun, said by its direction, or by where on the earth it is seen, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SunPlace {
    /// Unit vector toward the sun, not below the horizon.
    Direction(Vec3),
    /// The sky over a place on the earth; north is along -Z, east along +X.
    Moment {
        /// Latitude, north of the equator positive.
        latitude_degrees: f32,
        /// Longitude, east of Greenwich positive.
        longitude_degrees: f32,
        /// Point in time.
        time: Moment,
    },
}

/// A point in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Julian day, in universal time.
    pub(crate) day: f64,
    /// Terrestrial time less universal time, in seconds.
    pub(crate) delta_seconds: f64,
}

impl Moment {
    /// The moment of a date and a time of day whose clocks are `offset_minutes` ahead of universal time; `None` where there is
    /// no such date, or where the calendar's turning of the earth is not known.
    pub(crate) fn new(date: [u32; 3], time: [u32; 2], seconds: f64, offset_minutes: i32) -> Option<Self> {
        let ([year, month, day], [hour, minute]) = (date, time);
        let delta_seconds = delta_t::estimate(f64::from(year) + (f64::from(month) - 0.5) / 12.0).ok()?;
        let local = JulianDate::from_utc(year as i32, month, day, hour, minute, seconds, delta_seconds).ok()?;
        Some(Self { day: local.julian_date() - f64::from(offset_minutes) / 1440.0, delta_seconds })
    }
}

impl SunPlace {
    /// Unit vector toward the sun, which is below the horizon where its y is negative: up is +Y, north -Z, east +X.
    pub fn direction(&self) -> DVec3 {
        match *self {
            Self::Direction(direction) => direction.as_dvec3().normalize(),
            Self::Moment { latitude_degrees, longitude_degrees, time } => {
                let location = Location { latitude: latitude_degrees.into(), longitude: longitude_degrees.into() };
                let position = JulianDate::new(time.day, time.delta_seconds).and_then(|day| {
                    SolarPositions::new().at_from_julian(day, location, 0.0, Some(RefractionCorrection::standard()))
                });
                // The types of the file have seen to it that all numbers are in range.
                let position = position.expect("the place is on the earth, and the time within its calendar");
                let (azimuth, elevation) = (position.azimuth().to_radians(), position.elevation_angle().to_radians());
                let (sine, cosine) = elevation.sin_cos();
                DVec3::new(azimuth.sin() * cosine, sine, -azimuth.cos() * cosine)
            }
        }
    }
}

impl Sky {
    /// Turbidity where a file says none: a clear day.
    pub const TURBIDITY: f32 = 3.0;
    /// Albedo of the ground where a file says none, in all colours.
    pub const GROUND_ALBEDO: f32 = 0.2;

    /// A clear day with the sun in `direction`, which is not below the horizon.
    pub fn of(sun: SunPlace) -> Self {
        let (turbidity, ground_albedo) = (Self::TURBIDITY, Vec3::splat(Self::GROUND_ALBEDO));
        let image = bake(sun.direction(), turbidity, ground_albedo, 1.0).into();
        Self { sun, turbidity, ground_albedo, sun_intensity: 1.0, rotation_degrees: 0.0, intensity: 1.0, image }
    }

    /// The sun's disk; `None` where it gives no light.
    pub fn sun(&self) -> Option<Light> {
        let toward = DMat3::from_rotation_y(f64::from(self.rotation_degrees).to_radians()) * self.sun.direction();
        let factor = f64::from(self.sun_intensity) * f64::from(self.intensity);
        let intensity = (sun_irradiance(toward.y, self.turbidity.into()) * factor).as_vec3().to_array();
        let kind = LightKind::Sun { half_angle: SUN_HALF_ANGLE as f32 };
        let light = Light { name: String::new(), kind, position: DVec3::ZERO, direction: -toward, intensity };
        (intensity != [0.0; 3]).then_some(light)
    }
}

/// Image of a sky and of the ground below it, without the sun's disk: see [`Sky::image`]. The ground is a diffuse plane that
/// the sky and the sun light.
pub(crate) fn bake(toward: DVec3, turbidity: f32, ground_albedo: Vec3, sun_intensity: f32) -> Bitmap {
    let height = WIDTH / 2;
    let elevation = (toward.y.clamp(0.0, 1.0).asin() as f32).min(FRAC_PI_2);
    let params = SkyParams { elevation, turbidity, albedo: ground_albedo.to_array() };
    let model = SkyState::new(&params).expect("the types of the file keep to the model's ranges");

    // Rows of the upper half, each with the sum of its radiance.
    let step = PI / f64::from(height);
    let row = |row: u32| {
        let (sine, cosine) = ((f64::from(row) + 0.5) * step).sin_cos();
        let mut sum = DVec3::ZERO;
        let texel = |column: u32| {
            let longitude = ((f64::from(column) + 0.5) / f64::from(WIDTH) - 0.5) * TAU;
            let direction = DVec3::new(longitude.sin() * sine, cosine, -longitude.cos() * sine);
            let radiance = radiance(&model, direction, toward);
            sum += radiance;
            radiance.as_vec3().to_array()
        };
        let texels: Vec<_> = (0..WIDTH).map(texel).collect();
        (texels, sum * (cosine * sine * step * step))
    };
    let rows: Vec<u32> = (0..height / 2).collect();
    let share = rows.len().div_ceil(thread::available_parallelism().map_or(1, usize::from));
    let rows: Vec<_> = thread::scope(|scope| {
        let begin = |rows: &'_ [u32]| {
            let rows = rows.to_vec();
            scope.spawn(|| rows.into_iter().map(&row).collect::<Vec<_>>())
        };
        let threads: Vec<_> = rows.chunks(share).map(begin).collect();
        threads.into_iter().flat_map(|thread| thread.join().expect("no row fails")).collect()
    });
    let mut irradiance: DVec3 = rows.iter().map(|(_, sum)| *sum).sum();
    irradiance += sun_irradiance(toward.y, turbidity.into()) * (f64::from(sun_intensity) * toward.y.max(0.0));
    let ground = (ground_albedo.as_dvec3() * irradiance / PI).as_vec3().to_array();
    let mut texels: Vec<_> = rows.into_iter().flat_map(|(texels, _)| texels).collect();
    texels.resize((WIDTH * height) as usize, ground);
    Bitmap { width: WIDTH, height, texels: Texels::Rgb32F(texels) }
}

/// Radiance of the sky from a unit vector above the horizon.
fn radiance(model: &SkyState, direction: DVec3, toward: DVec3) -> DVec3 {
    let zenith_angle = direction.y.acos() as f32;
    let from_sun = direction.dot(toward).clamp(-1.0, 1.0).acos() as f32;
    let channel = |channel| f64::from(model.radiance(zenith_angle, from_sun, channel)).max(0.0) / CURVE_INTEGRAL;
    DVec3::new(channel(Channel::R), channel(Channel::G), channel(Channel::B))
}

/// Wavelengths of the tables, in nanometres: the first, and the step from each to the next.
const WAVELENGTHS: (f64, f64) = (380.0, 10.0);
/// Radiance of the sun outside the atmosphere, in 100 W/(m² nm sr), and the absorption of ozone, per centimetre of it
/// [preetham1999daylight].
const SPECTRUM: [(f64, f64); 38] = [
    (165.5, 0.0),
    (162.3, 0.0),
    (211.2, 0.0),
    (258.8, 0.0),
    (258.2, 0.0),
    (242.3, 0.0),
    (267.6, 0.0),
    (296.6, 0.003),
    (305.4, 0.006),
    (300.6, 0.009),
    (306.6, 0.014),
    (288.3, 0.021),
    (287.1, 0.03),
    (278.2, 0.04),
    (271.0, 0.048),
    (272.3, 0.063),
    (263.6, 0.075),
    (255.0, 0.085),
    (250.6, 0.103),
    (253.1, 0.12),
    (253.5, 0.12),
    (251.3, 0.115),
    (246.3, 0.125),
    (241.7, 0.12),
    (236.8, 0.105),
    (232.1, 0.09),
    (228.2, 0.079),
    (223.4, 0.067),
    (219.7, 0.057),
    (215.3, 0.048),
    (211.0, 0.036),
    (207.3, 0.028),
    (202.4, 0.023),
    (198.7, 0.018),
    (194.3, 0.014),
    (190.7, 0.011),
    (186.3, 0.01),
    (182.6, 0.009),
];
/// Ozone over the ground, in centimetres.
const OZONE: f64 = 0.35;

/// Irradiance, in linear Rec. 709, of what faces a sun whose direction has this `height` (the sine of its elevation), after
/// Rayleigh's scattering, aerosols and ozone have taken their part on the way [preetham1999daylight].
fn sun_irradiance(height: f64, turbidity: f64) -> DVec3 {
    let zenith_degrees = height.clamp(0.0, 1.0).acos().to_degrees();
    let mass = 1.0 / (height.max(0.0) + 0.15 * (93.885 - zenith_degrees).powf(-1.253));
    let aerosols = (0.046_083_658_220_5 * turbidity - 0.045_860_259_285_22).max(0.0);
    let mut xyz = DVec3::ZERO;
    for (index, (radiance, ozone)) in SPECTRUM.into_iter().enumerate() {
        let wavelength = WAVELENGTHS.0 + WAVELENGTHS.1 * index as f64;
        let micrometers = wavelength / 1000.0;
        let depth = 0.008735 * micrometers.powf(-4.08) + aerosols * micrometers.powf(-1.3) + OZONE * ozone;
        xyz += eye(wavelength) * (100.0 * radiance * (-mass * depth).exp() * WAVELENGTHS.1);
    }
    let rgb = DVec3::new(
        3.240_479 * xyz.x - 1.537_15 * xyz.y - 0.498_535 * xyz.z,
        -0.969_256 * xyz.x + 1.875_991 * xyz.y + 0.041_556 * xyz.z,
        0.055_648 * xyz.x - 0.204_043 * xyz.y + 1.057_311 * xyz.z,
    );
    // A deep red is outside Rec. 709.
    rgb.max(DVec3::ZERO) * (PI * SUN_HALF_ANGLE.sin().powi(2) / CURVE_INTEGRAL)
}

/// The eye's curves x, y and z (CIE 1931) at `wavelength`, in nanometres [wyman2013colors].
fn eye(wavelength: f64) -> DVec3 {
    let lobe = |middle: f64, below: f64, above: f64| {
        let t = (wavelength - middle) / if wavelength < middle { below } else { above };
        (-0.5 * t * t).exp()
    };
    DVec3::new(
        1.056 * lobe(599.8, 37.9, 31.0) + 0.362 * lobe(442.0, 16.0, 26.7) - 0.065 * lobe(501.1, 20.4, 26.2),
        0.821 * lobe(568.8, 46.9, 40.5) + 0.286 * lobe(530.9, 16.3, 31.1),
        1.217 * lobe(437.0, 11.8, 36.0) + 0.681 * lobe(459.0, 26.0, 13.8),
    )
}
