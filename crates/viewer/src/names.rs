//! Names of views, tone mappers, comparisons and presets in menus and scripts.

use raggio_render::{Comparison, ToneMapper, View};

use crate::navigation::Preset;

/// Views, in the order of the menu.
pub const VIEWS: &[(View, &str)] = &[
    (View::Radiance, "radiance"),
    (View::Hit, "hit"),
    (View::Albedo, "albedo"),
    (View::Normal, "normal"),
    (View::Depth, "depth"),
    (View::Bounces, "bounces"),
    (View::Samples, "samples"),
    (View::Variance, "variance"),
];

/// Tone mappers, in the order of the menu.
pub const TONE_MAPPERS: &[(ToneMapper, &str)] = &[
    (ToneMapper::Neutral, "Neutral"),
    (ToneMapper::Agx, "AgX"),
    (ToneMapper::Aces, "ACES"),
    (ToneMapper::Filmic, "Filmic"),
    (ToneMapper::Reinhard, "Reinhard"),
    (ToneMapper::None, "none"),
];

/// Ways to compare with a reference.
pub const COMPARISONS: &[(Comparison, &str)] = &[
    (Comparison::Off, "off"),
    (Comparison::Split, "split"),
    (Comparison::Reference, "reference"),
    (Comparison::Difference, "difference"),
];

/// The view of that name.
pub fn view_named(name: &str) -> Option<View> {
    named(VIEWS, name)
}

/// The tone mapper of that name.
pub fn tones_named(name: &str) -> Option<ToneMapper> {
    named(TONE_MAPPERS, name)
}

/// The way to compare of that name.
pub fn comparison_named(name: &str) -> Option<Comparison> {
    named(COMPARISONS, name)
}

fn named<T: Copy>(names: &[(T, &str)], name: &str) -> Option<T> {
    names.iter().find(|(_, known)| known.eq_ignore_ascii_case(name)).map(|(thing, _)| *thing)
}

/// The way to steer of that name.
pub fn preset_named(name: &str) -> Option<Preset> {
    Preset::ALL.into_iter().find(|preset| preset.name().eq_ignore_ascii_case(name))
}
