//! The parts of a scene as keys of the file, each with its old value, its new value and the value that its absence
//! means.

use raggio_scene::{
    Camera, Environment, Geometry, Intrinsics, LightEntry, LightPlace, Material, Medium, Placement, Projection,
    Reflection, RenderSettings, Sky, SunPlace, Transform, Vec3,
};

use crate::navigation::view_distance;

/// A value as the file would hold it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Datum {
    /// No value: the key is not there.
    Absent,
    Number(f32),
    Vector(Vec3),
    Whole(i64),
    Word(&'static str),
    Flag(bool),
    Intrinsics(Intrinsics),
    Medium(Medium),
}

/// One key of a table. It is written when it is there and `new` differs from `old`, or when it is not there and `new`
/// differs from what its absence means beside the new values of the other keys.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field {
    pub(super) key: &'static str,
    pub(super) old: Datum,
    pub(super) new: Datum,
    pub(super) absent: Datum,
}

/// A key whose old and new value are one function of the old and the new whole.
fn field<T>(key: &'static str, old: &T, new: &T, absent: Datum, datum: impl Fn(&T) -> Datum) -> Field {
    Field { key, old: datum(old), new: datum(new), absent }
}

pub(super) fn camera(old: &Camera, new: &Camera) -> Vec<Field> {
    use Datum::{Absent, Number, Vector, Word};
    // A panorama has no lens that could be in focus.
    let focus = if new.is_panoramic() { Absent } else { Number(view_distance(new)) };
    vec![
        field("position", old, new, Absent, |it| Vector(it.position)),
        field("look_at", old, new, Absent, |it| Vector(it.look_at)),
        field("up", old, new, Vector(Vec3::Y), |it| Vector(it.up)),
        field("vertical_fov_degrees", old, new, Absent, |it| match it.projection {
            Projection::Perspective { vertical_fov_degrees } => Number(vertical_fov_degrees),
            _ => Absent,
        }),
        field("intrinsics", old, new, Absent, |it| match it.projection {
            Projection::Calibrated(intrinsics) => Datum::Intrinsics(intrinsics),
            _ => Absent,
        }),
        field("orthographic_height", old, new, Absent, |it| it.orthographic_height().map_or(Absent, Number)),
        field("panorama", old, new, Absent, |it| match it.projection {
            Projection::Panoramic(panorama) => Word(panorama.name()),
            _ => Absent,
        }),
        field("aperture_radius", old, new, Number(0.0), |it| Number(it.aperture_radius)),
        field(
            "focus_distance",
            old,
            new,
            focus,
            |it| if it.is_panoramic() { Absent } else { Number(it.focus_distance) },
        ),
    ]
}

pub(super) fn material(old: &Material, new: &Material) -> Vec<Field> {
    use Datum::{Absent, Number, Vector, Whole, Word};
    // The reader's default: a lamp is black unless told otherwise.
    let color = if new.emission_strength > 0.0 { 0.0 } else { 0.8 };
    vec![
        field("color", old, new, Vector(Vec3::splat(color)), |it| Vector(it.color)),
        field("emission_color", old, new, Vector(Vec3::ONE), |it| Vector(it.emission_color)),
        field("emission_strength", old, new, Number(0.0), |it| Number(it.emission_strength)),
        field("smoothness", old, new, Number(0.0), |it| Number(it.smoothness)),
        field("refractive_index", old, new, Absent, |it| it.refractive_index.map_or(Absent, Number)),
        field("reflection", old, new, Word("fresnel"), |it| match it.reflection {
            Reflection::Fresnel => Word("fresnel"),
            Reflection::Probability(probability) => Number(probability),
        }),
        field("priority", old, new, Whole(0), |it| Whole(it.priority.into())),
        // One that stays is changed key by key.
        field("medium", old, new, Absent, |it| match (it.medium, old.medium, new.medium) {
            (None, ..) => Absent,
            (Some(_), Some(kept), Some(_)) => Datum::Medium(kept),
            (Some(medium), ..) => Datum::Medium(medium),
        }),
    ]
}

/// The keys of a medium.
pub(super) fn medium(old: &Medium, new: &Medium) -> Vec<Field> {
    use Datum::{Number, Vector};
    let coefficient = |it: Vec3| if it == Vec3::splat(it.x) { Number(it.x) } else { Vector(it) };
    vec![
        field("absorption", old, new, Number(0.0), |it| coefficient(it.absorption)),
        field("scattering", old, new, Number(0.0), |it| coefficient(it.scattering)),
        field("anisotropy", old, new, Number(0.0), |it| Number(it.anisotropy)),
    ]
}

pub(super) fn environment(old: &Environment, new: &Environment) -> Vec<Field> {
    use Datum::{Absent, Number, Vector};
    // What is meant by the absence of what only some environments have.
    let is_sky = matches!(new, Environment::Sky(_));
    let has_image = is_sky || matches!(new, Environment::Image { .. });
    let of_sky = |key, default: Datum, datum: fn(&Sky) -> Datum| {
        field(key, old, new, if is_sky { default } else { Absent }, |it| match it {
            Environment::Sky(sky) => datum(sky),
            _ => Absent,
        })
    };
    vec![
        field("color", old, new, Absent, |it| match it {
            Environment::Constant(color) => Vector(*color),
            _ => Absent,
        }),
        field("horizon", old, new, Absent, |it| match it {
            Environment::Gradient { horizon, .. } => Vector(*horizon),
            _ => Absent,
        }),
        field("zenith", old, new, Absent, |it| match it {
            Environment::Gradient { zenith, .. } => Vector(*zenith),
            _ => Absent,
        }),
        // The path of an image is known to the file alone: an image can be taken away, but not be put there.
        field("image", old, new, Absent, |it| match it {
            Environment::Image { .. } => Datum::Word("an image"),
            _ => Absent,
        }),
        field("sun_direction", old, new, Absent, |it| match it {
            Environment::Sky(Sky { sun: SunPlace::Direction(direction), .. }) => Vector(*direction),
            _ => Absent,
        }),
        field("latitude_degrees", old, new, Absent, |it| match it {
            Environment::Sky(Sky { sun: SunPlace::Moment { latitude_degrees, .. }, .. }) => Number(*latitude_degrees),
            _ => Absent,
        }),
        field("longitude_degrees", old, new, Absent, |it| match it {
            Environment::Sky(Sky { sun: SunPlace::Moment { longitude_degrees, .. }, .. }) => Number(*longitude_degrees),
            _ => Absent,
        }),
        // A time, too, can be taken away alone.
        field("time", old, new, Absent, |it| match it {
            Environment::Sky(Sky { sun: SunPlace::Moment { .. }, .. }) => Datum::Word("a time"),
            _ => Absent,
        }),
        of_sky("turbidity", Number(Sky::TURBIDITY), |it| Number(it.turbidity)),
        of_sky("ground_albedo", Vector(Vec3::splat(Sky::GROUND_ALBEDO)), |it| Vector(it.ground_albedo)),
        of_sky("sun_intensity", Number(1.0), |it| Number(it.sun_intensity)),
        field("rotation_degrees", old, new, if has_image { Number(0.0) } else { Absent }, |it| match it {
            Environment::Image { rotation_degrees, .. } | Environment::Sky(Sky { rotation_degrees, .. }) => {
                Number(*rotation_degrees)
            }
            _ => Absent,
        }),
        field("intensity", old, new, if has_image { Number(1.0) } else { Absent }, |it| match it {
            Environment::Image { intensity, .. } | Environment::Sky(Sky { intensity, .. }) => Number(*intensity),
            _ => Absent,
        }),
    ]
}

/// The keys of two lights of one kind.
pub(super) fn light(old: &LightEntry, new: &LightEntry) -> Vec<Field> {
    use Datum::{Number, Vector};
    let place = place(&old.place).into_iter().zip(place(&new.place));
    let place = place.map(|((key, absent, old), (.., new))| Field { key, old, new, absent });
    place
        .chain([
            field("color", old, new, Vector(Vec3::ONE), |it| Vector(it.color)),
            field("intensity", old, new, Number(1.0), |it| Number(it.intensity)),
        ])
        .collect()
}

/// Keys that say where a light is, each with the value that its absence means and its own.
fn place(place: &LightPlace) -> Vec<(&'static str, Datum, Datum)> {
    use Datum::{Absent, Number, Vector};
    match *place {
        LightPlace::Point { position } => vec![("position", Absent, Vector(position))],
        LightPlace::Spot { position, direction, inner_degrees, outer_degrees } => vec![
            ("position", Absent, Vector(position)),
            ("direction", Absent, Vector(direction)),
            ("inner_degrees", Number(0.0), Number(inner_degrees)),
            ("outer_degrees", Number(45.0), Number(outer_degrees)),
        ],
        LightPlace::Directional { direction, angle_degrees } => {
            vec![("direction", Absent, Vector(direction)), ("angle_degrees", Number(0.0), Number(angle_degrees))]
        }
    }
}

pub(super) fn placement(old: &Placement, new: &Placement) -> Vec<Field> {
    use Datum::{Number, Vector};
    vec![
        field("translation", old, new, Vector(Vec3::ZERO), |it| Vector(it.translation)),
        field("rotation_degrees", old, new, Vector(Vec3::ZERO), |it| Vector(it.rotation_degrees)),
        field("scale", old, new, Number(1.0), |it| factor(it.scale)),
    ]
}

pub(super) fn transform(old: &Transform, new: &Transform) -> Vec<Field> {
    use Datum::{Number, Vector};
    vec![
        field("translation", old, new, Vector(Vec3::ZERO), |it| Vector(it.translation)),
        field("rotation_degrees", old, new, Vector(Vec3::ZERO), |it| Vector(it.rotation_degrees)),
        field("scale", old, new, Number(1.0), |it| factor(it.scale)),
    ]
}

/// One factor where all are equal.
fn factor(scale: Vec3) -> Datum {
    match scale.to_array() {
        [x, y, z] if x == y && y == z => Datum::Number(x),
        _ => Datum::Vector(scale),
    }
}

pub(super) fn render(old: &RenderSettings, new: &RenderSettings) -> Vec<Field> {
    use Datum::{Flag, Whole, Word};
    let default = RenderSettings::default();
    let whole = |key, number: fn(&RenderSettings) -> u32| {
        field(key, old, new, Whole(number(&default).into()), |it| Whole(number(it).into()))
    };
    vec![
        whole("width", |it| it.width),
        whole("height", |it| it.height),
        whole("samples", |it| it.samples),
        whole("max_depth", |it| it.max_depth),
        whole("seed", |it| it.seed),
        field("sampler", old, new, Word(default.sampler.name()), |it| Word(it.sampler.name())),
        field("filter", old, new, Word(default.filter.name()), |it| Word(it.filter.name())),
        field("clamp", old, new, Datum::Absent, |it| it.clamp.map_or(Datum::Absent, Datum::Number)),
        field("alpha", old, new, Flag(default.alpha), |it| Flag(it.alpha)),
        field("surface_offset", old, new, Flag(true), |it| Flag(it.surface_offset)),
    ]
}

/// The keys of two geometries of one kind.
pub(super) fn geometry(old: &Geometry, new: &Geometry) -> Vec<Field> {
    let (old, new) = (data(old), data(new));
    let pairs = old.into_iter().zip(new);
    pairs.map(|((key, old), (_, new))| Field { key, old, new, absent: absent(key) }).collect()
}

fn data(geometry: &Geometry) -> Vec<(&'static str, Datum)> {
    use Datum::{Number, Vector};
    match *geometry {
        Geometry::Sphere { center, radius } => vec![("center", Vector(center)), ("radius", Number(radius))],
        Geometry::Plane { point, normal } => vec![("point", Vector(point)), ("normal", Vector(normal))],
        Geometry::Rectangle { corner, edge_u, edge_v } => {
            vec![("corner", Vector(corner)), ("edge_u", Vector(edge_u)), ("edge_v", Vector(edge_v))]
        }
        Geometry::Disk { center, normal, radius } => {
            vec![("center", Vector(center)), ("normal", Vector(normal)), ("radius", Number(radius))]
        }
        Geometry::Cylinder { base, top, radius, capped } => {
            let round = [("base", Vector(base)), ("top", Vector(top)), ("radius", Number(radius))];
            [round.to_vec(), vec![("capped", Datum::Flag(capped))]].concat()
        }
        Geometry::Cone { base, top, radius, top_radius, capped } => {
            let round = [("base", Vector(base)), ("top", Vector(top)), ("radius", Number(radius))];
            [round.to_vec(), vec![("top_radius", Number(top_radius)), ("capped", Datum::Flag(capped))]].concat()
        }
        Geometry::Box { center, size, rotation_degrees } => {
            vec![("center", Vector(center)), ("size", Vector(size)), ("rotation_degrees", Vector(rotation_degrees))]
        }
        // The file holds the placement of a mesh instead.
        Geometry::Mesh { .. } => vec![],
    }
}

fn absent(key: &str) -> Datum {
    match key {
        "rotation_degrees" => Datum::Vector(Vec3::ZERO),
        "top_radius" => Datum::Number(0.0),
        "capped" => Datum::Flag(true),
        _ => Datum::Absent,
    }
}

/// Whether one geometry is the other in another place.
pub(super) fn is_moved(old: &Geometry, new: &Geometry) -> bool {
    // The place is the first key of every kind, and of those between two points the second as well.
    let two = matches!(old, Geometry::Cylinder { .. } | Geometry::Cone { .. });
    let rest = |geometry: &Geometry| data(geometry).split_off(if two { 2 } else { 1 }.min(data(geometry).len()));
    old.key() == new.key() && rest(old) == rest(new)
}
