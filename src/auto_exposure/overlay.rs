//! Debug overlay of the metering, drawn over the tonemapped image of cameras that ask for it.

use bevy::{
    asset::load_embedded_asset,
    core_pipeline::FullscreenShader,
    platform::collections::HashMap,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{
            BindGroupLayoutDescriptor, BlendState, CachedRenderPipelineId, ColorTargetState,
            ColorWrites, FragmentState, PipelineCache, RenderPassDescriptor,
            RenderPipelineDescriptor, ShaderStages, ShaderType, TextureFormat,
            binding_types::{storage_buffer_read_only_sized, uniform_buffer},
        },
        renderer::{RenderContext, RenderDevice, ViewQuery},
        view::{ExtractedView, ViewTarget},
    },
};

use super::{
    active::ViewExposurePipelines,
    binding_numbers::{STATE, VIEW},
    key::ExposureKey,
    pipelines::mask_entries,
    prepare::{ExposureUniforms, Masks, ViewExposure},
    settings::LeanAutoExposure,
    state::ExposureHistory,
    uniforms::{ExposureState, ExposureUniform},
};
use crate::gpu::{
    bind_group_cache::{CachedBindGroup, ResolvedLayout},
    bindings::layout,
    timed::timed,
};

/// On a view with the overlay of auto exposure: its pipeline, which may still be compiling, and its bind group.
#[derive(Component)]
pub struct ExposureOverlay {
    format: TextureFormat,
    key: ExposureKey,
    pipeline: CachedRenderPipelineId,
    layout: ResolvedLayout,
    group: CachedBindGroup,
}

/// Pipelines by target and key. Created by `init_overlay_pipelines`.
#[derive(Resource)]
pub(super) struct OverlayPipelines {
    shader: Handle<Shader>,
    fullscreen: FullscreenShader,
    by_key: HashMap<(TextureFormat, ExposureKey), (CachedRenderPipelineId, ResolvedLayout)>,
}

pub(super) fn init_overlay_pipelines(
    mut commands: Commands,
    asset_server: Res<AssetServer>,
    fullscreen: Res<FullscreenShader>,
) {
    commands.insert_resource(OverlayPipelines {
        shader: load_embedded_asset!(asset_server.as_ref(), "overlay.wgsl"),
        fullscreen: fullscreen.clone(),
        by_key: HashMap::default(),
    });
}

/// Settings and state; with a mask also the mask and its sampler.
fn overlay_layout(key: ExposureKey) -> BindGroupLayoutDescriptor {
    let state = storage_buffer_read_only_sized(false, Some(ExposureState::min_size()));
    layout(
        "lean_deferred/auto_exposure/overlay",
        ShaderStages::FRAGMENT,
        [
            (VIEW, uniform_buffer::<ExposureUniform>(true)),
            (STATE, state),
        ]
        .into_iter()
        .chain(mask_entries(key)),
    )
}

impl OverlayPipelines {
    fn get(
        &mut self,
        format: TextureFormat,
        key: ExposureKey,
        pipeline_cache: &PipelineCache,
    ) -> (CachedRenderPipelineId, &ResolvedLayout) {
        let (pipeline, layout) = self.by_key.entry((format, key)).or_insert_with(|| {
            let layout = ResolvedLayout::new(pipeline_cache, overlay_layout(key));
            let pipeline = pipeline_cache.queue_render_pipeline(RenderPipelineDescriptor {
                label: Some("lean_deferred/auto_exposure/overlay".into()),
                layout: vec![layout.descriptor().clone()],
                vertex: self.fullscreen.to_vertex_state(),
                fragment: Some(FragmentState {
                    shader: self.shader.clone(),
                    shader_defs: key
                        .shader_defs()
                        .into_iter()
                        .chain(["OVERLAY".into()])
                        .collect(),
                    entry_point: Some("fragment".into()),
                    targets: vec![Some(ColorTargetState {
                        format,
                        blend: Some(BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                        write_mask: ColorWrites::COLOR,
                    })],
                }),
                ..default()
            });
            (pipeline, layout)
        });
        (*pipeline, layout)
    }
}

/// Inserts or removes [`ExposureOverlay`].
pub(super) fn queue_overlay_pipelines(
    mut commands: Commands,
    pipelines: Option<ResMut<OverlayPipelines>>,
    pipeline_cache: Res<PipelineCache>,
    views: Query<(
        Entity,
        &ExtractedView,
        &LeanAutoExposure,
        Option<&ViewExposurePipelines>,
        Option<&ExposureOverlay>,
    )>,
) {
    let Some(mut pipelines) = pipelines else {
        return;
    };
    for (entity, view, settings, metering, overlay) in &views {
        let Some(metering) = metering.filter(|_| settings.overlay) else {
            if overlay.is_some() {
                commands.entity(entity).remove::<ExposureOverlay>();
            }
            continue;
        };
        let key = metering.key.of_overlay();
        if overlay
            .as_ref()
            .is_some_and(|overlay| (overlay.format, overlay.key) == (view.target_format, key))
        {
            continue;
        }
        let (pipeline, layout) = pipelines.get(view.target_format, key, &pipeline_cache);
        commands.entity(entity).insert(ExposureOverlay {
            format: view.target_format,
            key,
            pipeline,
            layout: layout.clone(),
            group: CachedBindGroup::default(),
        });
    }
}

pub(super) fn prepare_overlay_bind_groups(
    device: Res<RenderDevice>,
    uniforms: Res<ExposureUniforms>,
    masks: Masks,
    mut views: Query<(
        &ViewExposurePipelines,
        &ExposureHistory,
        &mut ExposureOverlay,
    )>,
) {
    let Some(uniforms) = uniforms.0.binding() else {
        return;
    };
    for (pipelines, history, mut overlay) in &mut views {
        let ExposureOverlay { layout, group, .. } = &mut *overlay;
        group.update(&device, layout, |entries| {
            entries.push(VIEW, uniforms.clone())?;
            entries.push(STATE, history.state.as_entire_binding())?;
            masks.push(pipelines, entries)
        });
    }
}

/// Runs after tonemapping.
pub(super) fn exposure_overlay(
    view: ViewQuery<(
        &ExposureOverlay,
        &ViewExposure,
        &ViewTarget,
        &ExtractedCamera,
    )>,
    pipeline_cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (overlay, view, target, camera) = view.into_inner();
    let (Some(pipeline), Some(group)) = (
        pipeline_cache.get_render_pipeline(overlay.pipeline),
        overlay.group.get(),
    ) else {
        return;
    };
    timed(
        &mut ctx,
        "lean_deferred/auto_exposure/overlay",
        &mut |ctx| {
            let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
                label: Some("lean_deferred/auto_exposure/overlay"),
                // Tonemapping has already resolved MSAA.
                color_attachments: &[Some(target.get_unsampled_color_attachment())],
                ..default()
            });
            if let Some(viewport) = &camera.viewport {
                pass.set_camera_viewport(viewport);
            }
            pass.set_render_pipeline(pipeline);
            pass.set_bind_group(0, group, &[view.offset]);
            pass.draw(0..3, 0..1);
        },
    );
}
