//! The bind groups, made anew only when what they bind changed.

use bevy::{
    prelude::*,
    render::{
        render_resource::{BindGroup, IntoBinding},
        renderer::RenderDevice,
        view::ViewDepthTexture,
    },
};

use super::{
    ActiveOcclusion, OcclusionTexture, activity::GatherPipeline, pipelines::OcclusionPipelines,
    uniforms::OcclusionUniforms,
};
use crate::{gbuffer::GBufferTextures, gpu::bind_group_cache::CachedBindGroup};

/// On a view with ambient occlusion: the bind groups of its passes.
#[derive(Component, Default)]
pub struct OcclusionBindings {
    pub(super) gather: CachedBindGroup,
    pub(super) merge: CachedBindGroup,
}

impl OcclusionBindings {
    /// Those that stay from frame to frame as long as nothing changes.
    pub fn lasting_bind_groups(&self) -> impl Iterator<Item = &BindGroup> {
        [&self.gather, &self.merge]
            .into_iter()
            .filter_map(CachedBindGroup::get)
    }
}

/// Makes the bind groups of all active views.
pub(super) fn prepare_occlusion_bind_groups(
    mut commands: Commands,
    device: Res<RenderDevice>,
    pipelines: Option<Res<OcclusionPipelines>>,
    uniforms: Res<OcclusionUniforms>,
    mut views: Query<(
        Entity,
        &ActiveOcclusion,
        Option<&OcclusionTexture>,
        &ViewDepthTexture,
        Option<&GBufferTextures>,
        Option<&mut OcclusionBindings>,
    )>,
) {
    let (Some(pipelines), Some(uniforms)) = (pipelines, uniforms.0.binding()) else {
        return;
    };
    for (entity, active, texture, depth, gbuffer, bindings) in &mut views {
        let mut new = None;
        let bindings = match bindings {
            Some(bindings) => bindings.into_inner(),
            None => new.insert(OcclusionBindings::default()),
        };
        let (Some(texture), Some(gather)) = (texture, active.gather) else {
            bindings.gather.clear();
            bindings.merge.clear();
            continue;
        };
        let occlusion = || texture.0.default_view.into_binding();

        let computes = matches!(gather, GatherPipeline::Compute(_));
        if let Some(layout) = pipelines.gather_layout(active.key, computes) {
            bindings.gather.update(&device, layout, |entries| {
                entries.push(0, uniforms.clone())?;
                entries.push(1, depth.view().into_binding())?;
                entries.push(2, pipelines.nearest_sampler.into_binding())?;
                if active.key.reads_normals() {
                    entries.push(3, gbuffer?.normal.default_view.into_binding())?;
                }
                if computes {
                    entries.push(4, occlusion())?;
                }
                Some(())
            });
        }
        if active.merge.is_some() {
            bindings
                .merge
                .update(&device, &pipelines.merge_layout, |entries| {
                    entries.push(0, uniforms.clone())?;
                    entries.push(1, depth.view().into_binding())?;
                    entries.push(2, pipelines.nearest_sampler.into_binding())?;
                    entries.push(3, occlusion())
                });
        } else {
            bindings.merge.clear();
        }
        if let Some(new) = new {
            commands.entity(entity).insert(new);
        }
    }
}
