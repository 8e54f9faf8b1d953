//! Films, legends and filters of the views that the display kernel draws.

use crate::{Feature, PixelFilter, Probe, View};

impl View {
    /// Feature whose film the view is meant for.
    pub fn feature(self) -> Feature {
        match self {
            Self::Hit => Feature::Hit,
            Self::Albedo => Feature::Albedo,
            Self::Normal => Feature::Normal,
            Self::Depth => Feature::Depth,
            Self::Radiance | Self::Bounces | Self::Samples | Self::Variance => Feature::Radiance,
        }
    }

    /// Legend of the view's colours, from their first to their last; `None` for colours that mean themselves.
    pub fn legend(self, scale: f32) -> Option<String> {
        match self {
            Self::Radiance | Self::Hit | Self::Albedo => None,
            Self::Normal => Some("x, y, z from -1 to 1 as red, green, blue".into()),
            Self::Depth => Some(format!("distance: white 0, middle grey {scale}, black far away")),
            Self::Bounces => Some(format!("rays per sample: 0 to {scale}")),
            Self::Samples => Some(format!("samples: 0 to {scale}")),
            Self::Variance => Some("relative standard error of the luminance: 0.1 % to 100 %, logarithmic".into()),
        }
    }
}

impl Feature {
    /// Whether the feature's values have no mean, as numbers of things and ways of several things: one sample from the
    /// pixel's middle has to do.
    pub fn is_single(self) -> bool {
        matches!(self, Self::Object | Self::Material | Self::Motion)
    }

    /// Filter for the feature's samples, where the picture has `chosen`.
    pub fn filter(self, chosen: u32) -> u32 {
        if self.is_single() { PixelFilter::Point as u32 } else { chosen }
    }
}

impl Probe {
    /// Whether only the kernels for any scene answer the probe.
    pub fn is_full(self) -> bool {
        matches!(
            self,
            Self::Sample
                | Self::Density
                | Self::Facets
                | Self::PrincipledEval
                | Self::PrincipledSample
                | Self::PrincipledEnergy
        )
    }
}
