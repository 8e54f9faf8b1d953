use std::ffi::CString;
use std::sync::Arc;

use ash::vk;

use crate::buffer::Buffer;
use crate::device::Device;
use crate::error::{During, VulkanError};

/// A SPIR-V module with the layout that its entry points share: descriptor sets of storage buffers, one push block.
pub struct Module {
    pub(crate) layout: vk::PipelineLayout,
    pub(crate) push_bytes: u32,
    sets: Vec<vk::DescriptorSetLayout>,
    shader: vk::ShaderModule,
    device: Arc<Device>,
}

/// One entry point, ready to run.
pub struct Pipeline {
    pub(crate) raw: vk::Pipeline,
    pub(crate) module: Arc<Module>,
}

/// The buffers of one descriptor set.
pub struct BindingSet {
    pub(crate) raw: vk::DescriptorSet,
    pub(crate) index: u32,
    pool: vk::DescriptorPool,
    pub(crate) module: Arc<Module>,
    // Kept alive for as long as the set refers to them.
    _buffers: Vec<Arc<Buffer>>,
}

impl Module {
    /// `bindings[set]` lists the storage buffers of each descriptor set by binding number; `push_bytes` is the size of
    /// the push block.
    pub fn new(
        device: &Arc<Device>,
        spirv: &[u8],
        bindings: &[Vec<u32>],
        push_bytes: u32,
    ) -> Result<Arc<Self>, VulkanError> {
        let mut module = Self {
            layout: vk::PipelineLayout::null(),
            push_bytes,
            sets: Vec::new(),
            shader: vk::ShaderModule::null(),
            device: device.clone(),
        };
        // Copied for its alignment: SPIR-V is made of 32-bit words.
        let code: Vec<u32> = bytemuck::allocation::pod_collect_to_vec(spirv);
        // SAFETY: the structures live until the calls return. The SPIR-V is ours and was validated in tests. `module`
        // destroys what was made when a later call fails.
        unsafe {
            let info = vk::ShaderModuleCreateInfo::default().code(&code);
            module.shader = device.raw.create_shader_module(&info, None).during("vkCreateShaderModule")?;
            for set in bindings {
                let slots: Vec<_> = set
                    .iter()
                    .map(|&binding| {
                        vk::DescriptorSetLayoutBinding::default()
                            .binding(binding)
                            .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                            .descriptor_count(1)
                            .stage_flags(vk::ShaderStageFlags::COMPUTE)
                    })
                    .collect();
                let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&slots);
                let layout =
                    device.raw.create_descriptor_set_layout(&info, None).during("vkCreateDescriptorSetLayout")?;
                module.sets.push(layout);
            }
            let push = [vk::PushConstantRange::default().stage_flags(vk::ShaderStageFlags::COMPUTE).size(push_bytes)];
            let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&module.sets).push_constant_ranges(&push);
            module.layout = device.raw.create_pipeline_layout(&info, None).during("vkCreatePipelineLayout")?;
        }
        Ok(Arc::new(module))
    }

    /// The pipeline of the entry point `name`.
    pub fn pipeline(self: &Arc<Self>, name: &str) -> Result<Pipeline, VulkanError> {
        self.pipeline_of(self.shader, name)
    }

    /// The pipeline of the entry point `name` of another module that has the same layout.
    pub fn variant(self: &Arc<Self>, spirv: &[u8], name: &str) -> Result<Pipeline, VulkanError> {
        let code: Vec<u32> = bytemuck::allocation::pod_collect_to_vec(spirv);
        let info = vk::ShaderModuleCreateInfo::default().code(&code);
        // SAFETY: as in `new`; pipelines do without the module they were made from.
        unsafe {
            let shader = self.device.raw.create_shader_module(&info, None).during("vkCreateShaderModule")?;
            let pipeline = self.pipeline_of(shader, name);
            self.device.raw.destroy_shader_module(shader, None);
            pipeline
        }
    }

    fn pipeline_of(self: &Arc<Self>, shader: vk::ShaderModule, name: &str) -> Result<Pipeline, VulkanError> {
        let entry = CString::new(name).unwrap_or_default();
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(shader)
            .name(&entry);
        let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(self.layout)];
        // SAFETY: module and layout belong to this device and outlive the pipeline.
        let created = unsafe { self.device.raw.create_compute_pipelines(vk::PipelineCache::null(), &info, None) };
        let raw = created.map_err(|(_, result)| result).during("vkCreateComputePipelines")?[0];
        Ok(Pipeline { raw, module: self.clone() })
    }

    /// A set for descriptor set `index` that refers to `buffers`, by binding number.
    pub fn bind(self: &Arc<Self>, index: u32, buffers: &[(u32, Arc<Buffer>)]) -> Result<BindingSet, VulkanError> {
        let device = &self.device.raw;
        let layouts = [self.sets[index as usize]];
        let sizes = [vk::DescriptorPoolSize::default()
            .ty(vk::DescriptorType::STORAGE_BUFFER)
            .descriptor_count(buffers.len().max(1) as u32)];
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        // SAFETY: the structures live until the calls return; the pool is destroyed by the set, which is made before
        // anything can fail again.
        let mut set = unsafe {
            let pool = device.create_descriptor_pool(&info, None).during("vkCreateDescriptorPool")?;
            let kept = buffers.iter().map(|(_, buffer)| buffer.clone()).collect();
            BindingSet { raw: vk::DescriptorSet::null(), index, pool, module: self.clone(), _buffers: kept }
        };
        let allocate = vk::DescriptorSetAllocateInfo::default().descriptor_pool(set.pool).set_layouts(&layouts);
        let infos: Vec<_> = buffers
            .iter()
            .map(|(_, buffer)| [vk::DescriptorBufferInfo::default().buffer(buffer.raw).range(vk::WHOLE_SIZE)])
            .collect();
        // SAFETY: the pool has room for this one set; the buffers live as long as the set does.
        unsafe {
            set.raw = device.allocate_descriptor_sets(&allocate).during("vkAllocateDescriptorSets")?[0];
            let writes: Vec<_> = buffers
                .iter()
                .zip(&infos)
                .map(|((binding, _), info)| {
                    vk::WriteDescriptorSet::default()
                        .dst_set(set.raw)
                        .dst_binding(*binding)
                        .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                        .buffer_info(info)
                })
                .collect();
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
            for &set in &self.sets {
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
