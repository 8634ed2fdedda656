//! Debug view of the metering, drawn over the tonemapped image.

use bevy::{
    asset::load_embedded_asset,
    core_pipeline::FullscreenShader,
    prelude::*,
    render::{
        render_resource::{
            BindGroupLayoutDescriptor, BlendState, IntoBinding, PipelineCache, ShaderStages,
            ShaderType, binding_types::storage_buffer_read_only_sized,
        },
        renderer::RenderDevice,
        view::ExtractedView,
    },
    shader::ShaderDefVal,
};

use super::{
    active::ActiveExposure,
    binding_numbers::{MASK, MASK_SAMPLER, STATE, VIEW},
    key::ExposureKey,
    masks::Masks,
    pipelines::binding_kind,
    prepare::{ExposureUniforms, ViewExposure},
    state::ExposureHistory,
    uniforms::ExposureState,
};
use crate::{
    gpu::bindings::layout,
    view::{
        DebugView, LeanDebugView,
        debug_draw::{DebugDraw, DebugDrawn, DebugPipelines},
    },
};

/// Weights of pixels, and the exposure on a scale.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct ShownWeights(ExposureKey);

impl DebugDraw for ShownWeights {
    const LABEL: &'static str = "lean_deferred/effects/auto_exposure/overlay";
    const BLEND: Option<BlendState> = Some(BlendState::PREMULTIPLIED_ALPHA_BLENDING);
    const IS_AFTER_UPSCALING: bool = true;

    fn layout(self) -> BindGroupLayoutDescriptor {
        let state = storage_buffer_read_only_sized(false, Some(ExposureState::min_size()));
        let as_metered = [VIEW, MASK, MASK_SAMPLER].into_iter();
        let as_metered = as_metered.filter_map(|binding| Some((binding, binding_kind(binding)?)));
        let entries = as_metered.chain([(STATE, state)]);
        layout(Self::LABEL, ShaderStages::FRAGMENT, entries)
    }

    fn shader_defs(self) -> Vec<ShaderDefVal> {
        let defs = self.0.shader_defs().into_iter();
        defs.chain(["OVERLAY".into()]).collect()
    }
}

pub(super) fn init_overlay_pipelines(
    mut commands: Commands,
    asset_server: Res<AssetServer>,
    fullscreen: Res<FullscreenShader>,
) {
    let shader = load_embedded_asset!(asset_server.as_ref(), "overlay.wgsl");
    commands.insert_resource(DebugPipelines::<ShownWeights>::new(shader, &fullscreen));
}

pub(super) fn prepare_overlays(
    mut commands: Commands,
    (device, cache): (Res<RenderDevice>, Res<PipelineCache>),
    pipelines: Option<ResMut<DebugPipelines<ShownWeights>>>,
    uniforms: Res<ExposureUniforms>,
    masks: Masks,
    mut views: Query<(
        Entity,
        (&ExtractedView, &LeanDebugView),
        (&ActiveExposure, &ViewExposure, &ExposureHistory),
        Option<&mut DebugDrawn<ShownWeights>>,
    )>,
) {
    let (Some(mut pipelines), Some(uniforms)) = (pipelines, uniforms.0.binding()) else {
        return;
    };
    for (entity, (view, debug_view), (active, exposure, history), drawn) in &mut views {
        if debug_view.shows != DebugView::ExposureWeights {
            if drawn.is_some() {
                commands.entity(entity).remove::<DebugDrawn<ShownWeights>>();
            }
            continue;
        }
        pipelines.set(
            &mut commands,
            &device,
            &cache,
            (entity, view),
            drawn,
            (ShownWeights(active.key.of_overlay()), Some(exposure.offset)),
            |entries| {
                entries.push(VIEW, uniforms.clone())?;
                entries.push(STATE, history.state.as_entire_binding())?;
                let mask = masks.bound(active.mask.as_ref());
                entries.push(MASK, mask.texture_view.into_binding())?;
                entries.push(MASK_SAMPLER, mask.sampler.into_binding())
            },
        );
    }
}
