//! Building of structures, and what they are built from.

use std::marker::PhantomData;
use std::sync::Arc;

use ash::vk;

use super::{CORNER_BYTES, Structure, StructureKind, StructureSize, Triangles};
use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::{During, VulkanError};

/// Parts that a structure is built from.
pub(super) struct Input<'a> {
    pub kind: StructureKind,
    pub address: u64,
    pub count: u32,
    /// What the address is of stays where it is.
    pub held: PhantomData<&'a Buffer>,
}

impl Input<'_> {
    pub fn what(&self) -> &'static str {
        match self.kind {
            StructureKind::Triangles => "the structure of a mesh",
            StructureKind::Boxes => "the structure of shapes",
            StructureKind::Placed { .. } => "the structure of a scene",
        }
    }

    pub fn ty(&self) -> vk::AccelerationStructureTypeKHR {
        match self.kind {
            StructureKind::Placed { .. } => vk::AccelerationStructureTypeKHR::TOP_LEVEL,
            _ => vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL,
        }
    }

    pub fn size(&self, device: &Device) -> Result<StructureSize, VulkanError> {
        device.structure_size(self.kind, self.count)
    }

    pub fn geometry<'g>(&self) -> vk::AccelerationStructureGeometryKHR<'g> {
        let data = vk::DeviceOrHostAddressConstKHR { device_address: self.address };
        let mut geometry = vk::AccelerationStructureGeometryDataKHR::default();
        let kind = match self.kind {
            StructureKind::Triangles => {
                geometry.triangles = vk::AccelerationStructureGeometryTrianglesDataKHR::default()
                    .vertex_format(vk::Format::R32G32B32_SFLOAT)
                    .vertex_data(data)
                    .vertex_stride(CORNER_BYTES)
                    .max_vertex((3 * self.count).saturating_sub(1))
                    .index_type(vk::IndexType::NONE_KHR);
                vk::GeometryTypeKHR::TRIANGLES
            }
            StructureKind::Boxes => {
                geometry.aabbs =
                    vk::AccelerationStructureGeometryAabbsDataKHR::default()
                        .data(data)
                        .stride(size_of::<vk::AabbPositionsKHR>() as u64);
                vk::GeometryTypeKHR::AABBS
            }
            StructureKind::Placed { .. } => {
                geometry.instances = vk::AccelerationStructureGeometryInstancesDataKHR::default().data(data);
                vk::GeometryTypeKHR::INSTANCES
            }
        };
        vk::AccelerationStructureGeometryKHR::default().geometry_type(kind).geometry(geometry)
    }

    pub fn info<'g>(
        &self,
        geometry: &'g [vk::AccelerationStructureGeometryKHR<'g>],
    ) -> vk::AccelerationStructureBuildGeometryInfoKHR<'g> {
        let more = match self.kind {
            StructureKind::Triangles => vk::BuildAccelerationStructureFlagsKHR::ALLOW_COMPACTION,
            StructureKind::Placed { refits: true } => vk::BuildAccelerationStructureFlagsKHR::ALLOW_UPDATE,
            _ => vk::BuildAccelerationStructureFlagsKHR::empty(),
        };
        vk::AccelerationStructureBuildGeometryInfoKHR::default()
            .ty(self.ty())
            .flags(vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE | more)
            .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
            .geometries(geometry)
    }
}

/// Builds structures from what each is made of or, if there is an old one of the same parts, from that, and waits. Then `more` is
/// recorded in the same submission.
pub(super) fn build(
    device: &Arc<Device>,
    work: &[(Input<'_>, &Structure, Option<&Structure>)],
    more: impl FnOnce(vk::CommandBuffer),
) -> Result<(), VulkanError> {
    let loader = device.structure_loader()?;
    let alignment = device.physical.structures.map_or(1, |limits| limits.scratch_alignment);
    // Each has a part of one buffer, whose own address may be less aligned.
    let mut places = Vec::with_capacity(work.len());
    let mut end = 0;
    for (input, ..) in work {
        places.push(end);
        end = (end + input.size(device)?.scratch).next_multiple_of(alignment);
    }
    let scratch = Buffer::new(device, "room to build structures", end + alignment, Location::Device)?;
    let first = scratch.known_address().next_multiple_of(alignment);

    let geometries: Vec<_> = work.iter().map(|(input, ..)| [input.geometry()]).collect();
    let infos: Vec<_> = work
        .iter()
        .zip(&geometries)
        .zip(&places)
        .map(|(((input, made, old), geometry), place)| {
            let mut info = input
                .info(geometry)
                .dst_acceleration_structure(made.raw)
                .scratch_data(vk::DeviceOrHostAddressKHR { device_address: first + place });
            if let Some(old) = old {
                info = info.mode(vk::BuildAccelerationStructureModeKHR::UPDATE).src_acceleration_structure(old.raw);
            }
            info
        })
        .collect();
    let counts: Vec<_> = work
        .iter()
        .map(|(input, ..)| [vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(input.count)])
        .collect();
    let ranges: Vec<&[_]> = counts.iter().map(<[_; 1]>::as_slice).collect();
    device.run(|passes| {
        // SAFETY: the command buffer is recording. Inputs, structures and scratch memory live until the submission has been
        // waited for; sizes are those that the driver has asked for.
        passes.build(|commands| unsafe { loader.cmd_build_acceleration_structures(commands, &infos, &ranges) });
        passes.build(more);
    })
}

/// Structures of `meshes`, which are built at once and compacted.
pub(super) fn compacted(device: &Arc<Device>, meshes: &[Triangles]) -> Result<Vec<Arc<Structure>>, VulkanError> {
    let loader = device.structure_loader()?;
    let large = |mesh: &Triangles| {
        let input = mesh.input();
        Structure::empty(device, &input, input.size(device)?.structure, vec![])
    };
    let large = meshes.iter().map(large).collect::<Result<Vec<_>, _>>()?;
    let raw: Vec<_> = large.iter().map(|structure| structure.raw).collect();
    let sizes = Sizes::new(device, raw.len() as u32)?;
    let work: Vec<_> = meshes.iter().zip(&large).map(|(mesh, made)| (mesh.input(), made, None)).collect();
    build(device, &work, |commands| {
        let kind = vk::QueryType::ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR;
        // SAFETY: the command buffer is recording, and the pool has as many queries.
        unsafe {
            device.raw.cmd_reset_query_pool(commands, sizes.pool, 0, raw.len() as u32);
            loader.cmd_write_acceleration_structures_properties(commands, &raw, kind, sizes.pool, 0);
        }
    })?;

    let small = meshes.iter().zip(sizes.read(raw.len())?);
    let small = small.map(|(mesh, bytes)| Structure::empty(device, &mesh.input(), bytes, vec![]));
    let small = small.collect::<Result<Vec<_>, _>>()?;
    device.run(|passes| {
        passes.build(|commands| {
            for (from, to) in large.iter().zip(&small) {
                let info = vk::CopyAccelerationStructureInfoKHR::default()
                    .src(from.raw)
                    .dst(to.raw)
                    .mode(vk::CopyAccelerationStructureModeKHR::COMPACT);
                // SAFETY: the command buffer is recording; both live until the submission has been waited for.
                unsafe { loader.cmd_copy_acceleration_structure(commands, &info) };
            }
        });
    })?;
    Ok(small.into_iter().map(Arc::new).collect())
}

/// Place for the sizes that structures have when they are compacted.
struct Sizes {
    pool: vk::QueryPool,
    device: Arc<Device>,
}

impl Sizes {
    fn new(device: &Arc<Device>, count: u32) -> Result<Self, VulkanError> {
        let kind = vk::QueryType::ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR;
        let info = vk::QueryPoolCreateInfo::default().query_type(kind).query_count(count);
        device.attempt("vkCreateQueryPool")?;
        // SAFETY: the device is alive; the pool is destroyed in `Drop`.
        let pool = unsafe { device.raw.create_query_pool(&info, None) }.during("vkCreateQueryPool")?;
        Ok(Self { pool, device: device.clone() })
    }

    fn read(&self, count: usize) -> Result<Vec<u64>, VulkanError> {
        let mut sizes = vec![0u64; count];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        self.device.attempt("vkGetQueryPoolResults")?;
        // SAFETY: the submission that writes as many has been waited for.
        unsafe { self.device.raw.get_query_pool_results(self.pool, 0, &mut sizes, flags) }
            .during("vkGetQueryPoolResults")?;
        Ok(sizes)
    }
}

impl Drop for Sizes {
    fn drop(&mut self) {
        // SAFETY: the submission that used the pool has been waited for.
        unsafe { self.device.raw.destroy_query_pool(self.pool, None) };
    }
}
