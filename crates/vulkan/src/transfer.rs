use std::ops::Range;
use std::sync::Arc;

use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::VulkanError;

/// Most bytes that are on their way at once.
const STAGING_BYTES: usize = 64 << 20;

impl Buffer {
    /// Makes a device buffer that holds `bytes`. `what` names it in errors.
    pub fn with_bytes(device: &Arc<Device>, what: &str, bytes: &[u8]) -> Result<Self, VulkanError> {
        let buffer = Self::new(device, what, bytes.len() as u64, Location::Device)?;
        let part = STAGING_BYTES.min(bytes.len());
        let mut staging = Self::new(device, what, part as u64, Location::Upload)?;
        for (i, bytes) in bytes.chunks(STAGING_BYTES).enumerate() {
            staging.mapped_mut()[..bytes.len()].copy_from_slice(bytes);
            let part = 0..bytes.len() as u64;
            device.run(|passes| passes.copy_range(&staging, part, &buffer, (i * STAGING_BYTES) as u64))?;
        }
        Ok(buffer)
    }

    /// Makes a device buffer of `size` bytes, all zero. `what` names it in errors.
    pub fn zeroed(device: &Arc<Device>, what: &str, size: u64) -> Result<Self, VulkanError> {
        let buffer = Self::new(device, what, size, Location::Device)?;
        device.run(|passes| passes.clear(&buffer))?;
        Ok(buffer)
    }

    /// Returns all bytes of the buffer, copied to the host.
    pub fn read(&self) -> Result<Vec<u8>, VulkanError> {
        self.read_range(0..self.size())
    }

    /// Returns a range of the buffer's bytes, copied to the host.
    ///
    /// # Panics
    /// If the range reaches past the end.
    pub fn read_range(&self, range: Range<u64>) -> Result<Vec<u8>, VulkanError> {
        let size = range.end - range.start;
        let staging = Self::new(&self.device, "staging for a read", size, Location::Readback)?;
        self.device.run(|passes| passes.copy_range(self, range, &staging, 0))?;
        Ok(staging.mapped()[..size as usize].to_vec())
    }
}
