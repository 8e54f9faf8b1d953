use std::ops::Range;
use std::sync::Arc;

use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::VulkanError;

/// Most bytes that are on their way at once.
const STAGING_BYTES: usize = 64 << 20;
/// Most bytes on their way at once where memory is short.
const SMALL_STAGING_BYTES: u64 = 1 << 20;

impl Buffer {
    /// Makes a device buffer that holds `bytes`. `what` names it in errors.
    pub fn with_bytes(device: &Arc<Device>, what: &str, bytes: &[u8]) -> Result<Self, VulkanError> {
        let buffer = Self::new(device, what, bytes.len() as u64, Location::Device)?;
        buffer.write(bytes)?;
        Ok(buffer)
    }

    /// Copies `bytes` to the beginning of the buffer.
    ///
    /// # Panics
    /// If there are more than the buffer has.
    pub fn write(&self, bytes: &[u8]) -> Result<(), VulkanError> {
        let part = STAGING_BYTES.min(bytes.len());
        let mut staging = Self::new(&self.device, self.what(), part as u64, Location::Upload)?;
        for (i, bytes) in bytes.chunks(STAGING_BYTES).enumerate() {
            staging.mapped_mut()[..bytes.len()].copy_from_slice(bytes);
            let part = 0..bytes.len() as u64;
            self.device.run(|passes| passes.copy_range(&staging, part, self, (i * STAGING_BYTES) as u64))?;
        }
        Ok(())
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
        match self.read_in_parts(range.clone(), STAGING_BYTES as u64) {
            // What has been computed is worth a second try that takes less memory.
            Err(VulkanError::OutOfMemory(_)) => self.read_in_parts(range, SMALL_STAGING_BYTES),
            read => read,
        }
    }

    /// Reads as [`Buffer::read_range`] does, `part` bytes at a time.
    fn read_in_parts(&self, range: Range<u64>, part: u64) -> Result<Vec<u8>, VulkanError> {
        let size = range.end - range.start;
        let staging = Self::new(&self.device, "staging for a read", size.min(part), Location::Readback)?;
        let mut bytes = Vec::with_capacity(size as usize);
        for first in range.clone().step_by(part as usize) {
            let taken = first..range.end.min(first + part);
            let length = (taken.end - taken.start) as usize;
            self.device.run(|passes| passes.copy_range(self, taken, &staging, 0))?;
            bytes.extend(&staging.mapped()[..length]);
        }
        Ok(bytes)
    }
}
