//! Structures that hardware traces rays by (`VK_KHR_acceleration_structure`).

mod build;

use std::ffi::CStr;
use std::marker::PhantomData;
use std::ops::Range;
use std::sync::Arc;

use ash::{khr, vk};
use bytemuck::{Pod, Zeroable};

use self::build::{Input, build, compacted};
use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::{During, VulkanError};

/// Extensions by which kernels ask hardware for rays; the last is one that the first needs.
pub(crate) const EXTENSIONS: [&CStr; 3] =
    [khr::acceleration_structure::NAME, khr::ray_query::NAME, khr::deferred_host_operations::NAME];

/// Most bytes of structures that are built at once, and not compacted yet, unless a single one is larger.
const BATCH_BYTES: u64 = 256 << 20;

/// Largest number of a placed structure, of which drivers keep 24 bits.
const MOST_PLACES: u64 = 1 << 24;

/// Limits of a device's structures.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StructureLimits {
    scratch_alignment: u64,
    most_primitives: u64,
    most_placed: u64,
}

impl StructureLimits {
    /// Limits of the device at `handle`; `None` where kernels cannot ask for rays.
    pub fn of(instance: &ash::Instance, handle: vk::PhysicalDevice) -> Option<Self> {
        // SAFETY: `handle` came from this instance.
        let known = unsafe { instance.enumerate_device_extension_properties(handle) }.ok()?;
        let is_offered = |name: &&CStr| known.iter().any(|e| e.extension_name_as_c_str() == Ok(*name));
        if !EXTENSIONS.iter().all(is_offered) {
            return None;
        }
        let mut structures = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default();
        let mut ray_queries = vk::PhysicalDeviceRayQueryFeaturesKHR::default();
        let mut features =
            vk::PhysicalDeviceFeatures2::default().push_next(&mut structures).push_next(&mut ray_queries);
        let mut limits = vk::PhysicalDeviceAccelerationStructurePropertiesKHR::default();
        let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut limits);
        // SAFETY: as above; the device offers the extensions that the chained structures are of.
        unsafe {
            instance.get_physical_device_features2(handle, &mut features);
            instance.get_physical_device_properties2(handle, &mut properties);
        }
        let has_both = structures.acceleration_structure == vk::TRUE && ray_queries.ray_query == vk::TRUE;
        has_both.then_some(Self {
            scratch_alignment: u64::from(limits.min_acceleration_structure_scratch_offset_alignment).max(1),
            most_primitives: limits.max_primitive_count,
            most_placed: limits.max_instance_count.min(MOST_PLACES),
        })
    }
}

/// What a structure holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StructureKind {
    /// Triangles, compacted once it is built.
    Triangles,
    /// Boxes, in which kernels look for surfaces themselves.
    Boxes,
    /// Other structures.
    Placed {
        /// Whether it may be refitted where they move.
        refits: bool,
    },
}

/// Bytes that a structure takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StructureSize {
    /// Bytes of the structure itself, before it is compacted.
    pub structure: u64,
    /// Bytes that are needed while it is built.
    pub scratch: u64,
}

impl StructureSize {
    /// Bytes of both.
    pub fn total(self) -> u64 {
        self.structure + self.scratch
    }
}

/// Triangles in a buffer: three corners of three floats, each of which has 16 bytes, of a device that asks for rays.
#[derive(Clone)]
pub struct Triangles {
    /// Buffer with the triangles, 48 bytes each.
    pub buffer: Arc<Buffer>,
    /// Triangles of one structure.
    pub range: Range<u32>,
}

/// Bytes of a corner of a triangle, and of the triangle.
const CORNER_BYTES: u64 = 16;
const TRIANGLE_BYTES: u64 = 3 * CORNER_BYTES;

/// Structure that stands somewhere in another.
#[derive(Clone)]
pub struct Placed {
    /// Map from the structure's space to the world, by rows; it has an inverse.
    pub world_from_structure: [[f32; 4]; 3],
    /// Number that kernels find it by, below 2^24.
    pub number: u32,
    /// Whether kernels are asked about each triangle that a ray may meet.
    pub has_holes: bool,
    /// Structure of triangles or boxes.
    pub structure: Arc<Structure>,
}

/// A placed structure as drivers read it: `VkAccelerationStructureInstanceKHR`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct PlacedRecord {
    transform: [[f32; 4]; 3],
    /// 24 bits for the number, 8 for a mask, all of which are set.
    number_and_mask: u32,
    /// 24 bits that queries do not use, 8 for flags.
    flags: u32,
    address: u64,
}

const _: () = assert!(size_of::<PlacedRecord>() == size_of::<vk::AccelerationStructureInstanceKHR>());

impl PlacedRecord {
    fn of(placed: &Placed) -> Self {
        let holes = match placed.has_holes {
            true => vk::GeometryInstanceFlagsKHR::FORCE_NO_OPAQUE,
            false => vk::GeometryInstanceFlagsKHR::FORCE_OPAQUE,
        };
        let flags = vk::GeometryInstanceFlagsKHR::TRIANGLE_FACING_CULL_DISABLE | holes;
        Self {
            transform: placed.world_from_structure,
            number_and_mask: placed.number | 0xff << 24,
            flags: flags.as_raw() << 24,
            address: placed.structure.address,
        }
    }
}

/// Structure by which hardware finds surfaces.
pub struct Structure {
    pub(crate) raw: vk::AccelerationStructureKHR,
    address: u64,
    kind: StructureKind,
    count: u32,
    memory: Buffer,
    // Structures that stand in this one are kept alive.
    _placed: Vec<Arc<Structure>>,
}

impl Structure {
    /// Builds a structure of each of `meshes`, and compacts it. Those of meshes that are small are built together.
    ///
    /// # Panics
    /// If a range reaches past its buffer.
    pub fn of_triangles(device: &Arc<Device>, meshes: &[Triangles]) -> Result<Vec<Arc<Self>>, VulkanError> {
        let mut built = Vec::with_capacity(meshes.len());
        let (mut first, mut bytes) = (0, 0);
        for (place, mesh) in meshes.iter().enumerate() {
            let size = mesh.size(device)?.total();
            if place > first && bytes + size > BATCH_BYTES {
                built.extend(compacted(device, &meshes[first..place])?);
                (first, bytes) = (place, 0);
            }
            bytes += size;
        }
        if first < meshes.len() {
            built.extend(compacted(device, &meshes[first..])?);
        }
        Ok(built)
    }

    /// Builds a structure of `boxes`, each given by its lower and upper corner.
    pub fn of_boxes(device: &Arc<Device>, boxes: &[[[f32; 3]; 2]]) -> Result<Arc<Self>, VulkanError> {
        let buffer = Buffer::with_bytes(device, "boxes of shapes", bytemuck::cast_slice(boxes))?;
        let (kind, count) = (StructureKind::Boxes, boxes.len() as u32);
        let input = Input { kind, address: buffer.known_address(), count, held: PhantomData };
        let made = Self::empty(device, &input, input.size(device)?.structure, vec![])?;
        build(device, &[(input, &made, None)], |_| ())?;
        Ok(Arc::new(made))
    }

    /// Builds a structure of `placed` others; `refits` says that it may be [refitted](Self::refitted) later.
    pub fn of_placed(device: &Arc<Device>, placed: &[Placed], refits: bool) -> Result<Arc<Self>, VulkanError> {
        Self::place(device, placed, refits, None)
    }

    /// A structure like `self`, in which the same structures stand elsewhere: it takes less time than to build one.
    ///
    /// # Panics
    /// If it cannot be refitted, or there are others.
    pub fn refitted(&self, placed: &[Placed]) -> Result<Arc<Self>, VulkanError> {
        let device = self.memory.device.clone();
        assert_eq!((self.kind, self.count), (StructureKind::Placed { refits: true }, placed.len() as u32));
        Self::place(&device, placed, true, Some(self))
    }

    fn place(
        device: &Arc<Device>,
        placed: &[Placed],
        refits: bool,
        old: Option<&Self>,
    ) -> Result<Arc<Self>, VulkanError> {
        let records: Vec<_> = placed.iter().map(PlacedRecord::of).collect();
        let buffer = Buffer::with_bytes(device, "places of shapes", bytemuck::cast_slice(&records))?;
        let (kind, count) = (StructureKind::Placed { refits }, placed.len() as u32);
        let input = Input { kind, address: buffer.known_address(), count, held: PhantomData };
        let mut below: Vec<_> = placed.iter().map(|placed| placed.structure.clone()).collect();
        below.sort_unstable_by_key(|structure| structure.address);
        below.dedup_by_key(|structure| structure.address);
        let made = Self::empty(device, &input, input.size(device)?.structure, below)?;
        build(device, &[(input, &made, old)], |_| ())?;
        Ok(Arc::new(made))
    }

    /// Makes a structure that has yet to be built from `input`, of `bytes` bytes.
    fn empty(device: &Arc<Device>, input: &Input<'_>, bytes: u64, placed: Vec<Arc<Self>>) -> Result<Self, VulkanError> {
        let memory = Buffer::new(device, input.what(), bytes, Location::Structure)?;
        let loader = device.structure_loader()?;
        let info = vk::AccelerationStructureCreateInfoKHR::default().buffer(memory.raw).size(bytes).ty(input.ty());
        device.attempt("vkCreateAccelerationStructureKHR")?;
        // SAFETY: the buffer was made for structures, is as large as this one, and lives as long as it does.
        let raw =
            unsafe { loader.create_acceleration_structure(&info, None) }.during("vkCreateAccelerationStructureKHR")?;
        let info = vk::AccelerationStructureDeviceAddressInfoKHR::default().acceleration_structure(raw);
        // SAFETY: the structure was just made.
        let address = unsafe { loader.get_acceleration_structure_device_address(&info) };
        Ok(Self { raw, address, kind: input.kind, count: input.count, memory, _placed: placed })
    }

    /// Bytes of the structure.
    pub fn size(&self) -> u64 {
        self.memory.size()
    }

    /// Number of triangles, boxes or structures in it.
    pub fn parts(&self) -> u32 {
        self.count
    }
}

impl Drop for Structure {
    fn drop(&mut self) {
        if let Some(loader) = &self.memory.device.structures {
            // SAFETY: every submission is waited for while what it uses is borrowed, and sets and other structures keep this
            // one alive. Its memory goes after it.
            unsafe { loader.destroy_acceleration_structure(self.raw, None) };
        }
    }
}

impl Triangles {
    fn size(&self, device: &Device) -> Result<StructureSize, VulkanError> {
        device.structure_size(StructureKind::Triangles, self.range.len() as u32)
    }

    fn input(&self) -> Input<'_> {
        let end = u64::from(self.range.end) * TRIANGLE_BYTES;
        assert!(end <= self.buffer.size(), "triangles are inside their buffer");
        let address = self.buffer.known_address() + u64::from(self.range.start) * TRIANGLE_BYTES;
        Input { kind: StructureKind::Triangles, address, count: self.range.len() as u32, held: PhantomData }
    }
}

impl Device {
    /// Bytes that a structure of `count` parts takes.
    ///
    /// # Errors
    /// A [`VulkanError::TooLarge`] or [`VulkanError::TooManyParts`] when the device has no structures so large, a
    /// [`VulkanError::Unfit`] when it has none.
    pub fn structure_size(&self, kind: StructureKind, count: u32) -> Result<StructureSize, VulkanError> {
        let input = Input { kind, address: 0, count, held: PhantomData };
        let Some(limits) = self.physical.structures else { return Err(self.has_no_structures()) };
        let most = match kind {
            StructureKind::Placed { .. } => limits.most_placed,
            _ => limits.most_primitives,
        };
        if u64::from(count) > most {
            let (what, name) = (input.what().into(), self.physical.name.clone());
            return Err(VulkanError::TooManyParts { what, name, parts: u64::from(count), limit: most });
        }
        let geometry = [input.geometry()];
        let info = input.info(&geometry);
        let mut sizes = vk::AccelerationStructureBuildSizesInfoKHR::default();
        let loader = self.structure_loader()?;
        // SAFETY: the structures live until the call returns. It reads no address.
        unsafe {
            let kind = vk::AccelerationStructureBuildTypeKHR::DEVICE;
            loader.get_acceleration_structure_build_sizes(kind, &info, &[count], &mut sizes);
        }
        let size = StructureSize {
            structure: sizes.acceleration_structure_size,
            scratch: sizes.build_scratch_size.max(sizes.update_scratch_size),
        };
        let (largest, limit) = (size.structure.max(size.scratch), self.physical.max_buffer_size);
        if largest > limit { Err(self.too_large(input.what(), largest, limit)) } else { Ok(size) }
    }

    /// Most bytes that structures of meshes with so many triangles take at once while they are built, the finished ones among
    /// them.
    pub fn room_for_triangles(&self, counts: impl IntoIterator<Item = u32>) -> Result<u64, VulkanError> {
        let (mut all, mut with_scratch, mut largest) = (0, 0, 0);
        for count in counts {
            let size = self.structure_size(StructureKind::Triangles, count)?;
            all += size.structure;
            with_scratch += size.total();
            largest = largest.max(size.total());
        }
        // What is compacted stands beside the last batch, which has several structures or the largest.
        Ok(all + largest.max(BATCH_BYTES.min(with_scratch)))
    }

    fn structure_loader(&self) -> Result<&khr::acceleration_structure::Device, VulkanError> {
        self.structures.as_ref().ok_or_else(|| self.has_no_structures())
    }

    fn has_no_structures(&self) -> VulkanError {
        VulkanError::Unfit { name: self.physical.name.clone(), missing: "VK_KHR_ray_query".into() }
    }
}

impl Buffer {
    /// Address of a buffer of a device that has structures: all its buffers have one.
    fn known_address(&self) -> u64 {
        self.address().unwrap_or_default()
    }
}
