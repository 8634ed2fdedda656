//! Specializes the pipelines that draw meshes into the G-buffer.

use alloc::sync::Arc;

use bevy::{
    material::{MaterialProperties, key::ErasedMaterialPipelineKey},
    mesh::MeshVertexBufferLayoutRef,
    pbr::{PrepassPipeline, PrepassPipelineSpecializer},
    prelude::*,
    render::render_resource::{
        RenderPipelineDescriptor, SpecializedMeshPipeline, SpecializedMeshPipelineError,
    },
};

use super::{
    bevy::texture_defs::material_texture_defs, binding_numbers::pack::VISIBILITY_MASK_GROUP,
    masked::DrawnPart, placement::MeshOutput, registration::VertexStage,
    visibility_masks::visibility_mask_layout,
};
use crate::view::GBufferTargets;

/// Bevy's deferred prepass pipeline with other fragment shader and targets. Vertex shader, bind groups, culling and
/// depth stay Bevy's, so that positions match its other passes bit for bit.
pub(super) struct GBufferPipelineSpecializer {
    pub(super) pipeline: Arc<PrepassPipeline>,
    pub(super) properties: Arc<MaterialProperties>,
    pub(super) fragment_shader: Handle<Shader>,
    /// Replaces the material's vertex stage. Not part of the key: the material's type determines it.
    pub(super) vertex: Option<Arc<VertexStage<Handle<Shader>>>>,
}

/// The key of [`GBufferPipelineSpecializer`]: the material's key, the shader (pipelines of different material types
/// share one cache), the targets, and the part that is drawn.
pub(super) type GBufferPipelineKey = (
    ErasedMaterialPipelineKey,
    AssetId<Shader>,
    MeshOutput,
    DrawnPart,
);

impl SpecializedMeshPipeline for GBufferPipelineSpecializer {
    type Key = GBufferPipelineKey;

    fn specialize(
        &self,
        (key, _, output, part): Self::Key,
        layout: &MeshVertexBufferLayoutRef,
    ) -> Result<RenderPipelineDescriptor, SpecializedMeshPipelineError> {
        let prepass = PrepassPipelineSpecializer {
            pipeline: PrepassPipeline::clone(&self.pipeline),
            properties: self.properties.clone(),
        };
        let mut descriptor = prepass.specialize(key, layout)?;
        descriptor.label = Some("lean_deferred/gbuffer".into());
        if let Some(vertex) = &self.vertex {
            descriptor.vertex.shader = vertex.shader.clone();
            descriptor.vertex.entry_point = None;
            let more = layout.0.get_layout(&vertex.attributes)?.attributes;
            if let Some(buffer) = descriptor.vertex.buffers.first_mut() {
                buffer.attributes.extend(more);
            }
        }
        if output.targets.contains(GBufferTargets::VISIBILITY_MASK) {
            descriptor.layout[VISIBILITY_MASK_GROUP] = visibility_mask_layout();
        }
        if let Some(fragment) = &mut descriptor.fragment {
            fragment.shader = self.fragment_shader.clone();
            fragment.entry_point = None;
            fragment.targets = output
                .pass
                .color_targets(output.has_valid_mask, output.targets);
            if output.has_valid_mask {
                fragment.shader_defs.push("GBUFFER_VALID_MASK".into());
            }
            let defs = output.targets.iter();
            let defs = defs.map(|target| target.shader_def().into());
            fragment.shader_defs.extend(defs);
            if output.targets.contains(GBufferTargets::SPECIALIZATION) {
                fragment.shader_defs.extend(material_texture_defs());
            }
        }
        part.change(&mut descriptor);
        Ok(descriptor)
    }
}
