use std::sync::Arc;

use ash::vk;

use crate::device::Device;
use crate::error::{During, VulkanError};

/// Pipelines that a driver has compiled, to be kept for the next time.
pub struct PipelineCache {
    pub(crate) raw: vk::PipelineCache,
    pub(crate) device: Arc<Device>,
}

/// Identity of a device and its driver, as far as what the driver compiles depends on them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Compiler {
    vendor: u32,
    device: u32,
    driver_version: u32,
    cache_uuid: [u8; vk::UUID_SIZE],
}

/// Bytes of the header that drivers begin their data with: length, version, vendor, device, UUID.
const HEADER_BYTES: usize = 16 + vk::UUID_SIZE;

impl Compiler {
    pub(crate) fn of(properties: &vk::PhysicalDeviceProperties) -> Self {
        Self {
            vendor: properties.vendor_id,
            device: properties.device_id,
            driver_version: properties.driver_version,
            cache_uuid: properties.pipeline_cache_uuid,
        }
    }

    /// All of the identity, for hashes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let words = [self.vendor, self.device, self.driver_version];
        words.into_iter().flat_map(u32::to_le_bytes).chain(self.cache_uuid).collect()
    }

    /// Whether `data` begins as this driver's data does. Drivers have to check that too, and not all do.
    pub fn knows(&self, data: &[u8]) -> bool {
        let Some(header) = data.get(..HEADER_BYTES) else { return false };
        let word = |place: usize| u32::from_le_bytes([0, 1, 2, 3].map(|i| header[4 * place + i]));
        let version = vk::PipelineCacheHeaderVersion::ONE.as_raw() as u32;
        let length = word(0) as usize;
        (HEADER_BYTES..=data.len()).contains(&length)
            && (word(1), word(2), word(3)) == (version, self.vendor, self.device)
            && header[16..] == self.cache_uuid
    }
}

impl PipelineCache {
    /// Makes a cache with the pipelines of `data`, which is [known](Compiler::knows) to the device's driver or else ignored. It
    /// has to be whole: drivers trust it.
    pub fn new(device: &Arc<Device>, data: &[u8]) -> Result<Self, VulkanError> {
        let data = if device.physical.compiler.knows(data) { data } else { &[] };
        let info = vk::PipelineCacheCreateInfo::default().initial_data(data);
        device.attempt("vkCreatePipelineCache")?;
        // SAFETY: `data` lives until the call returns, and its header is this driver's.
        let raw = unsafe { device.raw.create_pipeline_cache(&info, None) }.during("vkCreatePipelineCache")?;
        Ok(Self { raw, device: device.clone() })
    }

    /// Takes over the pipelines of `data`, which may be such as [`PipelineCache::new`] is given.
    pub fn merge(&self, data: &[u8]) -> Result<(), VulkanError> {
        let other = Self::new(&self.device, data)?;
        self.device.attempt("vkMergePipelineCaches")?;
        // SAFETY: both caches are this device's and alive. Drivers lock the one that is written by themselves.
        unsafe { self.device.raw.merge_pipeline_caches(self.raw, &[other.raw]) }.during("vkMergePipelineCaches")
    }

    /// All pipelines of the cache, for this driver alone.
    pub fn data(&self) -> Result<Vec<u8>, VulkanError> {
        self.device.attempt("vkGetPipelineCacheData")?;
        // SAFETY: the cache is alive. Drivers lock it by themselves.
        unsafe { self.device.raw.get_pipeline_cache_data(self.raw) }.during("vkGetPipelineCacheData")
    }
}

impl Drop for PipelineCache {
    fn drop(&mut self) {
        // SAFETY: pipelines are made while the cache is borrowed, so that none is being made now.
        unsafe { self.device.raw.destroy_pipeline_cache(self.raw, None) };
    }
}
