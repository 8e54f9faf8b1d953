//! How the film is shown, as the user chooses it.

use raggio_render::{Comparison, Display, ToneMapper, View};

/// What turns a film into the picture on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// What of the film is shown.
    pub view: View,
    /// Stops: each doubles the brightness.
    pub exposure: f32,
    /// The curve.
    pub tone_mapper: ToneMapper,
    /// With the reference, if there is one.
    pub comparison: Comparison,
    /// Where the reference begins when both are shown side by side, 0 to 1 from the left.
    pub split: f32,
}

impl Default for Look {
    fn default() -> Self {
        let Display { exposure, tone_mapper, view, comparison, .. } = Display::default();
        Self { view, exposure, tone_mapper, comparison, split: 0.5 }
    }
}

impl Look {
    /// For a film of this width; `scale` is where the colours of the view end.
    pub fn display(self, width: u32, scale: f32) -> Display {
        let Self { view, exposure, tone_mapper, comparison, split } = self;
        Display { view, exposure, tone_mapper, comparison, scale, split: (split * width as f32) as u32 }
    }

    /// For files, which hold radiance alone.
    pub fn of_files(self) -> Display {
        Display { exposure: self.exposure, tone_mapper: self.tone_mapper, ..Display::default() }
    }
}
