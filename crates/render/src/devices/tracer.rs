//! The choice of who finds what rays meet.

use raggio_choice::choice;
use raggio_vulkan::{DeviceKind, PhysicalDevice};

choice! {
    /// Who finds the surfaces that rays meet on a GPU. The CPU always does so by software.
    pub enum Tracer: "tracer" {
        /// hardware where a GPU has it and the scene fits what it needs, software elsewhere
        Auto = "auto",
        /// walks through hierarchies by the kernels themselves
        Software = "software",
        /// hardware that traces rays (VK_KHR_ray_query), or an error
        Hardware = "hardware",
    }
}

#[expect(clippy::derivable_impls, reason = "`choice!` takes no mark at a variant")]
impl Default for Tracer {
    fn default() -> Self {
        Self::Auto
    }
}

impl Tracer {
    /// Whether kernels are to ask hardware on `physical`, if it fits the scene. Software devices, which only pretend to have such
    /// hardware, are left to those who ask for it.
    pub(crate) fn asks(self, physical: &PhysicalDevice) -> bool {
        match self {
            Self::Auto => physical.has_ray_queries() && physical.kind != DeviceKind::Software,
            Self::Software => false,
            Self::Hardware => true,
        }
    }
}
