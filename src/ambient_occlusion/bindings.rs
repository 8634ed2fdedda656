//! The bind groups, made anew only when what they bind changed.

use bevy::{
    prelude::*,
    render::{
        render_resource::{BindGroupEntry, IntoBinding, PipelineCache},
        renderer::RenderDevice,
        view::ViewDepthTexture,
    },
};

use super::{
    ActiveOcclusion, OcclusionTexture, activity::GatherPipeline, pipelines::OcclusionPipelines,
    uniforms::OcclusionUniforms,
};
use crate::{bind_group_cache::CachedBindGroup, gbuffer::GBufferTextures};

/// On a view with ambient occlusion: the bind groups of its passes.
#[derive(Component, Default)]
pub(super) struct OcclusionBindings {
    pub(super) gather: CachedBindGroup,
    pub(super) merge: CachedBindGroup,
}

/// Makes the bind groups of all active views.
pub(super) fn prepare_occlusion_bind_groups(
    mut commands: Commands,
    (device, pipeline_cache): (Res<RenderDevice>, Res<PipelineCache>),
    pipelines: Option<Res<OcclusionPipelines>>,
    uniforms: Res<OcclusionUniforms>,
    mut views: Query<(
        Entity,
        &ActiveOcclusion,
        &OcclusionTexture,
        &ViewDepthTexture,
        Option<&GBufferTextures>,
        Option<&mut OcclusionBindings>,
    )>,
) {
    let (Some(pipelines), Some(uniforms)) = (pipelines, uniforms.0.binding()) else {
        return;
    };
    for (entity, active, texture, depth, gbuffer, bindings) in &mut views {
        let Some(mut bindings) = bindings else {
            commands.entity(entity).insert(OcclusionBindings::default());
            continue;
        };
        let common = [
            (0, uniforms.clone()),
            (1, depth.view().into_binding()),
            (2, pipelines.nearest_sampler.into_binding()),
        ];
        let occlusion = || texture.0.default_view.into_binding();
        let entries = |own: Vec<(u32, _)>| -> Vec<BindGroupEntry> {
            common
                .iter()
                .cloned()
                .chain(own)
                .map(|(binding, resource)| BindGroupEntry { binding, resource })
                .collect()
        };

        let compute = matches!(active.gather, GatherPipeline::Compute(_));
        let mut own = Vec::new();
        if active.key.reads_normals() {
            let Some(gbuffer) = gbuffer else {
                bindings.gather.clear();
                continue;
            };
            own.push((3, gbuffer.normal.default_view.into_binding()));
        }
        if compute {
            own.push((4, occlusion()));
        }
        let layout = pipelines.gather_layout(active.key, compute);
        bindings
            .gather
            .update(&device, &pipeline_cache, &layout, &entries(own));

        if active.merge.is_some() {
            let own = vec![(3, occlusion())];
            let layout = &pipelines.merge_layout;
            bindings
                .merge
                .update(&device, &pipeline_cache, layout, &entries(own));
        } else {
            bindings.merge.clear();
        }
    }
}
