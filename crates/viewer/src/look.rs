//! Display of the film, as the user chooses it.

use raggio_render::{Comparison, Display, ToneMapper, View};

/// Settings that turn a film into the picture on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Quantity that is shown: radiance, normals, depth and the like.
    pub view: View,
    /// Exposure in stops, each of which doubles the brightness.
    pub exposure: f32,
    /// Tone mapper, the curve from radiance to the display.
    pub tone_mapper: ToneMapper,
    /// Comparison with the reference, if there is one.
    pub comparison: Comparison,
    /// Place where the reference begins when both are shown side by side, 0 to 1 from the left.
    pub split: f32,
}

impl Default for Look {
    fn default() -> Self {
        let Display { exposure, tone_mapper, view, comparison, .. } = Display::default();
        Self { view, exposure, tone_mapper, comparison, split: 0.5 }
    }
}

impl Look {
    /// Settings for a film of this width in pixels; `scale` is the value at which the colours of the view end.
    pub fn display(self, width: u32, scale: f32) -> Display {
        let Self { view, exposure, tone_mapper, comparison, split } = self;
        Display { view, exposure, tone_mapper, comparison, scale, split: (split * width as f32) as u32 }
    }

    /// Settings for files, which hold radiance alone.
    pub fn of_files(self) -> Display {
        Display { exposure: self.exposure, tone_mapper: self.tone_mapper, ..Display::default() }
    }
}
