//! Report of the viewer, when it is over.

use crate::clock::Pacing;
use crate::viewer::Viewer;

/// Report of the viewer after its end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Name of the device that traced.
    pub device: String,
    /// Statistics of the frames of each section of the script that showed something new.
    pub pacing: Vec<Pacing>,
    /// Messages of what failed in the end, in the words the user saw.
    pub failures: Vec<String>,
    /// Messages of Vulkan's validation layers, if they were on.
    pub validation_messages: Vec<String>,
}

impl Report {
    /// Report of what `viewer` did.
    pub(crate) fn of(viewer: &mut Viewer, validation_messages: Vec<String>) -> Self {
        viewer.clock.close_section();
        Self {
            device: viewer.tracer.device().name(),
            pacing: viewer.clock.pacing(),
            failures: viewer.notices.failures(),
            validation_messages,
        }
    }
}
