use std::ops::Range;
use std::sync::Arc;

use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::VulkanError;

/// Most bytes that are on their way at once.
const STAGING_BYTES: usize = 64 << 20;
/// Most bytes on their way to the host at once: whoever reads a little should not wait for much memory.
const READING_BYTES: u64 = 32 << 20;
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
        let mut bytes = vec![0; (range.end - range.start) as usize];
        self.read_into(range.start, &mut bytes)?;
        Ok(bytes)
    }

    /// Copies the buffer's bytes from `first` on to the host, as many as `to` has room for.
    ///
    /// # Panics
    /// If there are not as many.
    pub fn read_into(&self, first: u64, to: &mut [u8]) -> Result<(), VulkanError> {
        self.read_by(first..first + to.len() as u64, |place, bytes| to[place..][..bytes.len()].copy_from_slice(bytes))
    }

    /// Has `take` read a range of the buffer's bytes where the device has copied them to, part by part from the first on: it is
    /// given the place of each part in the range. A part may come again.
    ///
    /// # Panics
    /// If the range reaches past the end.
    pub fn read_by(&self, range: Range<u64>, mut take: impl FnMut(usize, &[u8])) -> Result<(), VulkanError> {
        match self.read_in_parts(&range, &mut take, READING_BYTES) {
            // What has been computed is worth a second try that takes less memory.
            Err(VulkanError::OutOfMemory(_)) => self.read_in_parts(&range, &mut take, SMALL_STAGING_BYTES),
            read => read,
        }
    }

    /// Reads as [`Buffer::read_by`] does, `part` bytes at a time.
    fn read_in_parts(
        &self,
        range: &Range<u64>,
        take: &mut dyn FnMut(usize, &[u8]),
        part: u64,
    ) -> Result<(), VulkanError> {
        let part = part.min(range.end - range.start);
        let staging = Self::new(&self.device, "staging for a read", part, Location::Readback)?;
        for first in range.clone().step_by(part.max(1) as usize) {
            let bytes = first..range.end.min(first + part);
            let count = (bytes.end - bytes.start) as usize;
            self.device.run(|passes| passes.copy_range(self, bytes, &staging, 0))?;
            take((first - range.start) as usize, &staging.mapped()[..count]);
        }
        Ok(())
    }
}
