//! Faults of devices that a test asks for.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::device::Device;
use crate::error::VulkanError;

/// Fault of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The driver has reset the device, or it went away: every call from then on fails.
    Lost,
    /// The device or the host has too little memory left for one call.
    OutOfMemory,
}

/// Faults that are still to come.
#[derive(Default)]
pub(crate) struct Faults {
    lost: AtomicBool,
    /// Calls until one fails, and how.
    due: Mutex<Option<(u64, Fault)>>,
}

impl Device {
    /// Makes every call from now on fail as if the driver had reset the device: what follows a loss can be tried out on
    /// machines that lose none.
    pub fn pretend_lost(&self) {
        self.faults.lost.store(true, Ordering::Relaxed);
    }

    /// Makes one of the calls of Vulkan that may fail do so: the next for 1. It is not made at all then. 0 takes the fault
    /// back, and a loss before with it.
    pub fn pretend_fault(&self, call: u64, fault: Fault) {
        self.faults.lost.store(false, Ordering::Relaxed);
        *self.faults.due.lock().unwrap_or_else(PoisonError::into_inner) = (call > 0).then_some((call, fault));
    }

    /// Whether a fault that [`Device::pretend_fault`] has asked for is still to come.
    pub fn fault_is_due(&self) -> bool {
        self.faults.due.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// Fails where a test has asked for it, before `call` is made.
    pub(crate) fn attempt(&self, call: &'static str) -> Result<(), VulkanError> {
        let mut due = self.faults.due.lock().unwrap_or_else(PoisonError::into_inner);
        *due = match due.take() {
            Some((1, Fault::OutOfMemory)) => return Err(VulkanError::OutOfMemory(call.into())),
            Some((1, Fault::Lost)) => {
                self.faults.lost.store(true, Ordering::Relaxed);
                None
            }
            other => other.map(|(calls, fault)| (calls - 1, fault)),
        };
        if self.faults.lost.load(Ordering::Relaxed) { Err(VulkanError::DeviceLost) } else { Ok(()) }
    }
}
