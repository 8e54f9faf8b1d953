use std::ops::Range;
use std::sync::Arc;

use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::VulkanError;

impl Buffer {
    /// A device buffer that holds `bytes`.
    pub fn with_bytes(device: &Arc<Device>, what: &str, bytes: &[u8]) -> Result<Self, VulkanError> {
        let buffer = Self::new(device, what, bytes.len() as u64, Location::Device)?;
        if !bytes.is_empty() {
            let mut staging = Self::new(device, what, bytes.len() as u64, Location::Upload)?;
            staging.mapped_mut()[..bytes.len()].copy_from_slice(bytes);
            device.run(|passes| passes.copy(&staging, &buffer))?;
        }
        Ok(buffer)
    }

    /// A device buffer of zeros.
    pub fn zeroed(device: &Arc<Device>, what: &str, size: u64) -> Result<Self, VulkanError> {
        let buffer = Self::new(device, what, size, Location::Device)?;
        device.run(|passes| passes.clear(&buffer))?;
        Ok(buffer)
    }

    /// Its bytes, copied to the host.
    pub fn read(&self) -> Result<Vec<u8>, VulkanError> {
        self.read_range(0..self.size())
    }

    /// Some of its bytes, copied to the host.
    ///
    /// # Panics
    /// If the range reaches past the end.
    pub fn read_range(&self, range: Range<u64>) -> Result<Vec<u8>, VulkanError> {
        let size = range.end - range.start;
        let staging = Self::new(&self.device, "staging for a read", size, Location::Readback)?;
        self.device.run(|passes| passes.copy_range(self, range, &staging))?;
        Ok(staging.mapped()[..size as usize].to_vec())
    }
}
