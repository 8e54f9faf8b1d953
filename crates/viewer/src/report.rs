//! Report of the viewer, when it is over.

use std::time::Instant;

use crate::clock::Pacing;
use crate::denoising::Denoising;
use crate::viewer::Viewer;

/// Report of the viewer after its end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Name of the device that traced.
    pub device: String,
    /// Name of the denoiser and of what it worked on, where there was one at the end.
    pub denoiser: Option<String>,
    /// Seconds from the start of the program to the first picture, if there was one.
    pub first_picture_seconds: Option<f64>,
    /// Statistics of the frames of each section of the script that showed something new.
    pub pacing: Vec<Pacing>,
    /// Messages of what failed in the end, in the words the user saw.
    pub failures: Vec<String>,
    /// Messages of Vulkan's validation layers, if they were on.
    pub validation_messages: Vec<String>,
}

impl Report {
    /// Report of what `viewer` did.
    pub(crate) fn of(viewer: &mut Viewer, start: Instant, validation_messages: Vec<String>) -> Self {
        viewer.clock.close_section();
        Self {
            device: viewer.tracer.device().name(),
            denoiser: viewer.denoising.as_ref().map(Denoising::describe),
            first_picture_seconds: viewer.clock.first_picture().map(|first| (first - start).as_secs_f64()),
            pacing: viewer.clock.pacing(),
            failures: viewer.notices.failures(),
            validation_messages,
        }
    }
}
