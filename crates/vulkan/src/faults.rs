//! Faults of devices that a test asks for.

use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::device::Device;
use crate::error::VulkanError;

/// Fault of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The driver has reset the device: every call from then on fails, until the device is opened again.
    Lost,
    /// The device went away: every call from then on fails, and so does opening it again.
    Gone,
    /// The device or the host has too little memory left for one call.
    OutOfMemory,
    /// There is too little memory for any call from then on.
    NoMemory,
}

/// Faults that are still to come, also to the device once it is opened again.
#[derive(Default)]
pub(crate) struct Faults(Mutex<Pretended>);

#[derive(Default)]
struct Pretended {
    /// Calls until one fails, and how.
    due: Option<(u64, Fault)>,
    /// Fault of all calls.
    lasting: Option<Fault>,
}

impl Faults {
    fn lock(&self) -> MutexGuard<'_, Pretended> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Fails where the device is to be gone; a reset is over.
    pub fn reopen(&self) -> Result<(), VulkanError> {
        let mut faults = self.lock();
        if faults.lasting == Some(Fault::Gone) {
            return Err(VulkanError::DeviceLost);
        }
        faults.lasting = faults.lasting.filter(|fault| *fault != Fault::Lost);
        Ok(())
    }
}

impl Device {
    /// Makes every call from now on fail as if the driver had reset the device: what follows a loss can be tried out on
    /// machines that lose none.
    pub fn pretend_lost(&self) {
        self.faults.lock().lasting = Some(Fault::Lost);
    }

    /// Makes one of the calls of Vulkan that may fail do so: the next for 1. It is not made at all then. 0 takes the fault
    /// back, and one that lasts with it.
    pub fn pretend_fault(&self, call: u64, fault: Fault) {
        *self.faults.lock() = Pretended { due: (call > 0).then_some((call, fault)), lasting: None };
    }

    /// Whether a fault that [`Device::pretend_fault`] has asked for is still to come.
    pub fn fault_is_due(&self) -> bool {
        self.faults.lock().due.is_some()
    }

    /// Fails where a test has asked for it, before `call` is made.
    pub(crate) fn attempt(&self, call: &'static str) -> Result<(), VulkanError> {
        let mut faults = self.faults.lock();
        let now = match faults.due.take() {
            Some((1, fault)) => Some(fault),
            other => {
                faults.due = other.map(|(calls, fault)| (calls - 1, fault));
                None
            }
        };
        faults.lasting = faults.lasting.or(now.filter(|fault| *fault != Fault::OutOfMemory));
        match faults.lasting.or(now) {
            None => Ok(()),
            Some(Fault::Lost | Fault::Gone) => Err(VulkanError::DeviceLost),
            Some(Fault::OutOfMemory | Fault::NoMemory) => Err(VulkanError::OutOfMemory(call.into())),
        }
    }
}
