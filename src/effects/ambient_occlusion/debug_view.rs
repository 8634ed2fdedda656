//! Shows occlusion in place of the picture, after the history is kept, which must not contain it.

use bevy::{
    asset::load_embedded_asset,
    core_pipeline::FullscreenShader,
    prelude::*,
    render::{
        render_resource::{BindGroupLayoutDescriptor, IntoBinding, PipelineCache},
        renderer::RenderDevice,
        view::{ExtractedView, ViewDepthTexture},
    },
    shader::ShaderDefVal,
};

use super::{
    active::ActiveOcclusion,
    binding_numbers::{DEPTH_TEXTURE, NEAREST_SAMPLER, OCCLUSION_TEXTURE, VIEW},
    pipelines::{OcclusionPipelines, filter_layout},
    prepare::{OcclusionTextures, OcclusionUniforms, ViewOcclusion},
};
use crate::view::{
    DebugView, LeanDebugView, LightingIo,
    debug_draw::{DebugDraw, DebugDrawn, DebugPipelines},
};

/// Filtered occlusion, by the bits that the filter is compiled by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct ShownOcclusion(LightingIo);

impl DebugDraw for ShownOcclusion {
    const LABEL: &'static str = "lean_deferred/effects/ambient_occlusion/debug_view";

    fn layout(self) -> BindGroupLayoutDescriptor {
        filter_layout(Self::LABEL)
    }

    fn shader_defs(self) -> Vec<ShaderDefVal> {
        self.0.occlusion_defs().map(ShaderDefVal::from).collect()
    }
}

pub(super) fn init_debug_pipelines(
    mut commands: Commands,
    asset_server: Res<AssetServer>,
    fullscreen: Res<FullscreenShader>,
) {
    let shader = load_embedded_asset!(asset_server.as_ref(), "debug_view.wgsl");
    commands.insert_resource(DebugPipelines::<ShownOcclusion>::new(shader, &fullscreen));
}

pub(super) fn prepare_debug_views(
    mut commands: Commands,
    (device, cache): (Res<RenderDevice>, Res<PipelineCache>),
    pipelines: Option<ResMut<DebugPipelines<ShownOcclusion>>>,
    (occlusion_pipelines, uniforms): (Option<Res<OcclusionPipelines>>, Res<OcclusionUniforms>),
    mut views: Query<(
        Entity,
        (&ExtractedView, &LeanDebugView),
        (&ActiveOcclusion, &ViewOcclusion),
        (Option<&OcclusionTextures>, &ViewDepthTexture),
        Option<&mut DebugDrawn<ShownOcclusion>>,
    )>,
) {
    let (Some(mut pipelines), Some(occlusion_pipelines), Some(uniforms)) =
        (pipelines, occlusion_pipelines, uniforms.0.binding())
    else {
        return;
    };
    for (entity, (view, debug_view), (active, occlusion), (texture, depth), drawn) in &mut views {
        let texture = texture.filter(|_| debug_view.shows == DebugView::AmbientOcclusion);
        let Some(texture) = texture else {
            if drawn.is_some() {
                commands
                    .entity(entity)
                    .remove::<DebugDrawn<ShownOcclusion>>();
            }
            continue;
        };
        let filter = active.settings.lighting_io() & LightingIo::OCCLUSION_FILTER;
        pipelines.set(
            &mut commands,
            &device,
            &cache,
            (entity, view),
            drawn,
            (ShownOcclusion(filter), Some(occlusion.offset)),
            |entries| {
                let sampler = &occlusion_pipelines.nearest_sampler;
                entries.push(VIEW, uniforms.clone())?;
                entries.push(DEPTH_TEXTURE, depth.view().into_binding())?;
                entries.push(NEAREST_SAMPLER, sampler.into_binding())?;
                entries.push(
                    OCCLUSION_TEXTURE,
                    texture.occlusion.default_view.into_binding(),
                )
            },
        );
    }
}
