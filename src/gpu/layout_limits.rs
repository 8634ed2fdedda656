//! Counts the bindings of a pipeline against the limits of the device.

use bevy::render::render_resource::{
    BindGroupLayoutEntry, BindingType, BufferBindingType, WgpuLimits,
};

/// Number of bindings by which a pipeline of one stage with these `entries` exceeds `limits`; 0 if it can be created.
/// Elements of arrays count apart, as in wgpu.
pub(crate) fn excess<'a>(
    entries: impl IntoIterator<Item = &'a BindGroupLayoutEntry>,
    limits: &WgpuLimits,
) -> u32 {
    let [mut textures, mut samplers, mut storage_textures] = [0u32; 3];
    let [
        mut uniforms,
        mut dynamic_uniforms,
        mut storage,
        mut elements,
    ] = [0u32; 4];
    for entry in entries {
        if let Some(count) = entry.count {
            elements += count.get();
            continue;
        }
        match entry.ty {
            BindingType::Buffer {
                ty: BufferBindingType::Uniform,
                has_dynamic_offset,
                ..
            } => {
                uniforms += 1;
                dynamic_uniforms += u32::from(has_dynamic_offset);
            }
            BindingType::Buffer { .. } => storage += 1,
            BindingType::Sampler(_) => samplers += 1,
            BindingType::Texture { .. } => textures += 1,
            BindingType::StorageTexture { .. } => storage_textures += 1,
            _ => {}
        }
    }
    [
        (textures, limits.max_sampled_textures_per_shader_stage),
        (samplers, limits.max_samplers_per_shader_stage),
        (
            storage_textures,
            limits.max_storage_textures_per_shader_stage,
        ),
        (uniforms, limits.max_uniform_buffers_per_shader_stage),
        (
            dynamic_uniforms,
            limits.max_dynamic_uniform_buffers_per_pipeline_layout,
        ),
        (storage, limits.max_storage_buffers_per_shader_stage),
        (elements, limits.max_binding_array_elements_per_shader_stage),
    ]
    .into_iter()
    .map(|(used, limit)| used.saturating_sub(limit))
    .sum()
}

#[cfg(test)]
mod tests {
    use core::num::NonZero;

    use bevy::render::render_resource::{
        BindGroupLayoutEntryBuilder, ShaderStages, TextureSampleType,
        binding_types::{storage_buffer_sized, texture_2d, uniform_buffer_sized},
    };

    use super::*;

    fn excess_of(entries: Vec<BindGroupLayoutEntryBuilder>, limits: &WgpuLimits) -> u32 {
        let entries: Vec<_> = (entries.into_iter().zip(0..))
            .map(|(entry, binding)| entry.build(binding, ShaderStages::COMPUTE))
            .collect();
        excess(&entries, limits)
    }

    #[test]
    fn each_kind_has_its_own_limit() {
        let limits = WgpuLimits {
            max_sampled_textures_per_shader_stage: 2,
            max_storage_buffers_per_shader_stage: 1,
            max_uniform_buffers_per_shader_stage: 2,
            max_dynamic_uniform_buffers_per_pipeline_layout: 1,
            max_binding_array_elements_per_shader_stage: 8,
            ..WgpuLimits::default()
        };
        let texture = || texture_2d(TextureSampleType::Uint);
        let textures = |count| texture().count(NonZero::new(count).unwrap());
        let storage = || storage_buffer_sized(false, None);
        let uniform = |is_dynamic| uniform_buffer_sized(is_dynamic, None);
        assert_eq!(excess_of(vec![], &limits), 0);
        let all = [
            texture(),
            texture(),
            storage(),
            uniform(true),
            uniform(false),
        ];
        assert_eq!(excess_of(all.to_vec(), &limits), 0);
        assert_eq!(excess_of(vec![texture(); 5], &limits), 3);
        assert_eq!(excess_of(vec![storage(), storage()], &limits), 1);
        // One of any uniforms, and one of those with dynamic offsets.
        let uniforms = vec![uniform(true), uniform(true), uniform(false)];
        assert_eq!(excess_of(uniforms, &limits), 2);
        assert_eq!(excess_of(vec![textures(8)], &limits), 0);
        assert_eq!(excess_of(vec![textures(8), textures(2)], &limits), 2);
    }
}
