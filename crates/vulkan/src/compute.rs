use std::ffi::CString;
use std::sync::Arc;

use ash::vk;

use crate::buffer::Buffer;
use crate::cache::PipelineCache;
use crate::device::Device;
use crate::error::{During, VulkanError};
use crate::structure::Structure;

/// Descriptors in a descriptor set.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SetLayout {
    /// Way to the set's lists.
    pub lists: Lists,
    /// Binding of a structure that hardware traces rays by, if there is one.
    pub structure: Option<u32>,
}

/// Way in which a descriptor set refers to lists.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Lists {
    /// Storage buffers at these bindings.
    Buffers(Vec<u32>),
    /// Uniform buffer at binding 0 with the addresses of buffers, one behind the other.
    Addresses,
}

impl Lists {
    fn bindings(&self) -> &[u32] {
        match self {
            Self::Buffers(bindings) => bindings,
            Self::Addresses => &[0],
        }
    }

    fn descriptors(&self) -> vk::DescriptorType {
        match self {
            Self::Buffers(_) => vk::DescriptorType::STORAGE_BUFFER,
            Self::Addresses => vk::DescriptorType::UNIFORM_BUFFER,
        }
    }
}

/// A SPIR-V module with the layout that its entry points share: descriptor sets, one push block.
pub struct Module {
    pub(crate) layout: vk::PipelineLayout,
    pub(crate) push_bytes: u32,
    sets: Vec<(SetLayout, vk::DescriptorSetLayout)>,
    shader: vk::ShaderModule,
    device: Arc<Device>,
}

/// Entry point of a module, ready to run.
pub struct Pipeline {
    pub(crate) raw: vk::Pipeline,
    pub(crate) module: Arc<Module>,
}

/// Buffers bound to one descriptor set.
pub struct BindingSet {
    pub(crate) raw: vk::DescriptorSet,
    pub(crate) index: u32,
    pool: vk::DescriptorPool,
    pub(crate) module: Arc<Module>,
    // What the set refers to is kept alive.
    _buffers: Vec<Arc<Buffer>>,
    _structure: Option<Arc<Structure>>,
}

impl Module {
    /// Makes a module of `spirv`; `sets` lists what each descriptor set holds, `push_bytes` is the size of the push
    /// block.
    pub fn new(
        device: &Arc<Device>,
        spirv: &[u8],
        sets: &[SetLayout],
        push_bytes: u32,
    ) -> Result<Arc<Self>, VulkanError> {
        let mut module = Self {
            layout: vk::PipelineLayout::null(),
            push_bytes,
            sets: Vec::new(),
            shader: vk::ShaderModule::null(),
            device: device.clone(),
        };
        // The code is copied for its alignment: SPIR-V is made of 32-bit words.
        let code: Vec<u32> = bytemuck::allocation::pod_collect_to_vec(spirv);
        // SAFETY: the structures live until the calls return. The SPIR-V is ours and was validated in tests. `module`
        // destroys what was made when a later call fails.
        unsafe {
            let info = vk::ShaderModuleCreateInfo::default().code(&code);
            device.attempt("vkCreateShaderModule")?;
            module.shader = device.raw.create_shader_module(&info, None).during("vkCreateShaderModule")?;
            for set in sets {
                let slot = |(binding, kind)| {
                    vk::DescriptorSetLayoutBinding::default()
                        .binding(binding)
                        .descriptor_type(kind)
                        .descriptor_count(1)
                        .stage_flags(vk::ShaderStageFlags::COMPUTE)
                };
                let lists = set.lists.bindings().iter().map(|&binding| (binding, set.lists.descriptors()));
                let structure = set.structure.map(|binding| (binding, vk::DescriptorType::ACCELERATION_STRUCTURE_KHR));
                let slots: Vec<_> = lists.chain(structure).map(slot).collect();
                let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&slots);
                device.attempt("vkCreateDescriptorSetLayout")?;
                let layout =
                    device.raw.create_descriptor_set_layout(&info, None).during("vkCreateDescriptorSetLayout")?;
                module.sets.push((set.clone(), layout));
            }
            let push = [vk::PushConstantRange::default().stage_flags(vk::ShaderStageFlags::COMPUTE).size(push_bytes)];
            let layouts: Vec<_> = module.sets.iter().map(|(_, layout)| *layout).collect();
            let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&layouts).push_constant_ranges(&push);
            device.attempt("vkCreatePipelineLayout")?;
            module.layout = device.raw.create_pipeline_layout(&info, None).during("vkCreatePipelineLayout")?;
        }
        Ok(Arc::new(module))
    }

    /// Whether the module's kernels can be given `set`: sets of modules that lay them out alike are interchangeable.
    pub(crate) fn takes(&self, set: &BindingSet) -> bool {
        Arc::ptr_eq(&self.device, &set.module.device) && self.set_layout(set.index) == set.module.set_layout(set.index)
    }

    fn set_layout(&self, index: u32) -> Option<&SetLayout> {
        self.sets.get(index as usize).map(|(layout, _)| layout)
    }

    /// Makes the pipeline of the entry point `name`, whose specialization constants are `constants`, each at the place of
    /// its number. What `cache` has is not compiled again, and what is compiled is in it then. Several threads may do so at once.
    ///
    /// # Panics
    /// If the cache is another device's.
    pub fn pipeline(
        self: &Arc<Self>,
        name: &str,
        constants: &[u32],
        cache: Option<&PipelineCache>,
    ) -> Result<Pipeline, VulkanError> {
        assert!(cache.is_none_or(|cache| Arc::ptr_eq(&cache.device, &self.device)), "the cache is this device's");
        let entry = CString::new(name).unwrap_or_default();
        let place = |id: u32| vk::SpecializationMapEntry { constant_id: id, offset: 4 * id, size: 4 };
        let places: Vec<_> = (0..constants.len() as u32).map(place).collect();
        let constants = vk::SpecializationInfo::default().map_entries(&places).data(bytemuck::cast_slice(constants));
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(self.shader)
            .name(&entry)
            .specialization_info(&constants);
        let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(self.layout)];
        self.device.attempt("vkCreateComputePipelines")?;
        let cache = cache.map_or(vk::PipelineCache::null(), |cache| cache.raw);
        // SAFETY: module, layout and cache belong to this device; the first two outlive the pipeline. Drivers lock the cache
        // by themselves.
        let created = unsafe { self.device.raw.create_compute_pipelines(cache, &info, None) };
        let raw = created.map_err(|(_, result)| match result {
            // What drivers answer that cannot compile a kernel.
            vk::Result::ERROR_UNKNOWN
            | vk::Result::ERROR_INITIALIZATION_FAILED
            | vk::Result::ERROR_INVALID_SHADER_NV => {
                let physical = self.device.physical();
                VulkanError::Kernels { name: physical.name.clone(), driver: physical.driver.clone(), result }
            }
            other => VulkanError::of("vkCreateComputePipelines", other),
        })?[0];
        Ok(Pipeline { raw, module: self.clone() })
    }

    /// Makes a set for descriptor set `index` that refers to `buffers`, by binding number, or by address in their
    /// order, and to `structure`.
    ///
    /// # Panics
    /// If the set has a structure and there is none, or the other way round.
    pub fn bind(
        self: &Arc<Self>,
        index: u32,
        buffers: &[(u32, Arc<Buffer>)],
        structure: Option<&Arc<Structure>>,
    ) -> Result<BindingSet, VulkanError> {
        let layout = &self.sets[index as usize].0;
        assert_eq!(layout.structure.is_some(), structure.is_some(), "a structure is there if the kernels ask for it");
        if layout.lists != Lists::Addresses {
            buffers.iter().try_for_each(|(_, buffer)| buffer.check_bindable())?;
            return self.descriptors(index, buffers, &[], structure);
        }
        let addresses: Option<Vec<u64>> = buffers.iter().map(|(_, buffer)| buffer.address()).collect();
        let addresses = addresses.ok_or_else(|| VulkanError::Unfit {
            name: self.device.physical.name.clone(),
            missing: "bufferDeviceAddress".into(),
        })?;
        let table = Buffer::with_bytes(&self.device, "addresses", bytemuck::cast_slice(&addresses))?;
        self.descriptors(index, &[(0, Arc::new(table))], buffers, structure)
    }

    /// Makes a set of descriptors; it keeps the buffers `reached` through them alive.
    fn descriptors(
        self: &Arc<Self>,
        index: u32,
        buffers: &[(u32, Arc<Buffer>)],
        reached: &[(u32, Arc<Buffer>)],
        structure: Option<&Arc<Structure>>,
    ) -> Result<BindingSet, VulkanError> {
        let device = &self.device.raw;
        let (layout, raw_layout) = &self.sets[index as usize];
        let kind = layout.lists.descriptors();
        let of_lists = vk::DescriptorPoolSize::default().ty(kind).descriptor_count(buffers.len().max(1) as u32);
        let of_structures =
            vk::DescriptorPoolSize::default().ty(vk::DescriptorType::ACCELERATION_STRUCTURE_KHR).descriptor_count(1);
        let sizes = [of_lists, of_structures];
        let sizes = &sizes[..if structure.is_some() { 2 } else { 1 }];
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(sizes);
        self.device.attempt("vkCreateDescriptorPool")?;
        // SAFETY: the structures live until the calls return; the pool is destroyed by the set, which is made before
        // anything can fail again.
        let mut set = unsafe {
            let pool = device.create_descriptor_pool(&info, None).during("vkCreateDescriptorPool")?;
            let kept = buffers.iter().chain(reached).map(|(_, buffer)| buffer.clone()).collect();
            let (module, structure) = (self.clone(), structure.cloned());
            BindingSet { raw: vk::DescriptorSet::null(), index, pool, module, _buffers: kept, _structure: structure }
        };
        let layouts = [*raw_layout];
        let allocate = vk::DescriptorSetAllocateInfo::default().descriptor_pool(set.pool).set_layouts(&layouts);
        let infos: Vec<_> = buffers
            .iter()
            .map(|(_, buffer)| [vk::DescriptorBufferInfo::default().buffer(buffer.raw).range(vk::WHOLE_SIZE)])
            .collect();
        let structures: Vec<_> = structure.iter().map(|structure| structure.raw).collect();
        let mut of_structures =
            vk::WriteDescriptorSetAccelerationStructureKHR::default().acceleration_structures(&structures);
        self.device.attempt("vkAllocateDescriptorSets")?;
        // SAFETY: the pool has room for this one set; buffers and structure live as long as the set does.
        unsafe {
            set.raw = device.allocate_descriptor_sets(&allocate).during("vkAllocateDescriptorSets")?[0];
            let mut writes: Vec<_> = buffers
                .iter()
                .zip(&infos)
                .map(|((binding, _), info)| {
                    vk::WriteDescriptorSet::default()
                        .dst_set(set.raw)
                        .dst_binding(*binding)
                        .descriptor_type(kind)
                        .buffer_info(info)
                })
                .collect();
            if let (Some(binding), Some(_)) = (layout.structure, structure) {
                let write = vk::WriteDescriptorSet::default()
                    .dst_set(set.raw)
                    .dst_binding(binding)
                    .descriptor_type(vk::DescriptorType::ACCELERATION_STRUCTURE_KHR)
                    .descriptor_count(1)
                    .push_next(&mut of_structures);
                writes.push(write);
            }
            device.update_descriptor_sets(&writes, &[]);
        }
        Ok(set)
    }
}

impl Drop for Module {
    fn drop(&mut self) {
        // SAFETY: pipelines and sets keep the module alive, so none is left; null handles are allowed.
        unsafe {
            self.device.raw.destroy_pipeline_layout(self.layout, None);
            for &(_, set) in &self.sets {
                self.device.raw.destroy_descriptor_set_layout(set, None);
            }
            self.device.raw.destroy_shader_module(self.shader, None);
        }
    }
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for while its pipelines are borrowed.
        unsafe { self.module.device.raw.destroy_pipeline(self.raw, None) };
    }
}

impl Drop for BindingSet {
    fn drop(&mut self) {
        // SAFETY: as for pipelines; the pool takes its set with it.
        unsafe { self.module.device.raw.destroy_descriptor_pool(self.pool, None) };
    }
}
