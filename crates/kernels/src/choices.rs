//! Names of the choices that the kernels offer.

use raggio_choice::choice;

use crate::{Comparison, ToneMapper, View};

choice! {
    impl ToneMapper: "tone mapper" {
        /// Khronos PBR Neutral: colours stay what they are, highlights roll off.
        Neutral = "neutral",
        /// AgX, the default of Blender: bright colours fade to white as on film.
        Agx = "agx",
        /// Curve of ACES, like that of film.
        Aces = "aces",
        /// Hable's film curve of Uncharted 2.
        Filmic = "filmic",
        /// Reinhard's curve of luminance, with 4 as white.
        Reinhard = "reinhard",
        /// Cut at 1.
        None = "none",
    }
}

choice! {
    impl View: "view" {
        /// Photograph: exposed and tone-mapped.
        Radiance = "radiance",
        /// White where there is a surface.
        Hit = "hit",
        /// Colour of the first surface.
        Albedo = "albedo",
        /// Normal of the first surface.
        Normal = "normal",
        /// Distance of the first surface.
        Depth = "depth",
        /// Rays to a sample, in false colour.
        Bounces = "bounces",
        /// Number of samples, in false colour.
        Samples = "samples",
        /// Relative standard error of the luminance, in false colour.
        Variance = "variance",
    }
}

choice! {
    impl Comparison: "comparison" {
        /// No comparison.
        Off = "off",
        /// Reference to the right of a line, the film to its left.
        Split = "split",
        /// Reference alone.
        Reference = "reference",
        /// Difference between film and reference.
        Difference = "difference",
    }
}
