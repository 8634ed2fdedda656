//! The passes. If lighting applies occlusion, the gather runs after the G-buffer; otherwise gather and merge run after all opaque
//! meshes.

use core::slice;

use bevy::{
    prelude::*,
    render::{
        render_resource::{
            LoadOp, Operations, PipelineCache, RenderPassColorAttachment, RenderPassDescriptor,
            StoreOp,
        },
        renderer::{RenderContext, ViewQuery},
        view::ViewTarget,
    },
};

use super::{
    active::ActiveOcclusion,
    pipelines::GatherPipeline,
    prepare::{OcclusionBindings, OcclusionTexture, ViewOcclusion},
    uniforms::workgroups,
};
use crate::gpu::timed::{Dispatch, timed, timed_dispatch};

const GATHER: &str = "lean_deferred/effects/ambient_occlusion/gather";
const MERGE: &str = "lean_deferred/effects/ambient_occlusion/merge";

pub(super) type OcclusionViewQuery = (
    &'static ActiveOcclusion,
    &'static OcclusionTexture,
    &'static ViewOcclusion,
    &'static OcclusionBindings,
    &'static ViewTarget,
);

/// Runs between G-buffer and lighting.
pub(super) fn occlusion_for_lighting(
    view: ViewQuery<OcclusionViewQuery>,
    pipeline_cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (active, texture, view, bindings, _) = view.into_inner();
    if active.merge.is_none() {
        gather(active, texture, view, bindings, &pipeline_cache, &mut ctx);
    }
}

/// Runs after the opaque meshes.
pub(super) fn occlusion_after_opaque(
    view: ViewQuery<OcclusionViewQuery>,
    pipeline_cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (active, texture, view, bindings, target) = view.into_inner();
    if active.merge.is_some()
        && gather(active, texture, view, bindings, &pipeline_cache, &mut ctx).is_some()
    {
        merge(active, view, bindings, target, &pipeline_cache, &mut ctx);
    }
}

/// `None` while the pipeline is compiling or the bind group is missing.
fn gather(
    active: &ActiveOcclusion,
    texture: &OcclusionTexture,
    view: &ViewOcclusion,
    bindings: &OcclusionBindings,
    pipeline_cache: &PipelineCache,
    ctx: &mut RenderContext,
) -> Option<()> {
    let group = bindings.gather.get()?;
    match active.gather? {
        GatherPipeline::Compute(pipeline) => {
            let pipeline = pipeline_cache.get_compute_pipeline(pipeline)?;
            let dispatch = Dispatch {
                label: GATHER,
                pipeline,
                group,
                offsets: slice::from_ref(&view.offset),
                workgroups: workgroups(view.uniform.texture_size),
            };
            timed_dispatch(ctx, &dispatch);
        }
        GatherPipeline::Raster(pipeline) => {
            let pipeline = pipeline_cache.get_render_pipeline(pipeline)?;
            timed(ctx, GATHER, &mut |ctx| {
                let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
                    label: Some(GATHER),
                    color_attachments: &[Some(RenderPassColorAttachment {
                        view: &texture.0.default_view,
                        depth_slice: None,
                        resolve_target: None,
                        ops: Operations {
                            load: LoadOp::Clear(wgpu::Color::TRANSPARENT),
                            store: StoreOp::Store,
                        },
                    })],
                    ..default()
                });
                pass.set_render_pipeline(pipeline);
                pass.set_bind_group(0, group, &[view.offset]);
                pass.draw(0..3, 0..1);
            });
        }
    }
    Some(())
}

fn merge(
    active: &ActiveOcclusion,
    view: &ViewOcclusion,
    bindings: &OcclusionBindings,
    target: &ViewTarget,
    pipeline_cache: &PipelineCache,
    ctx: &mut RenderContext,
) -> Option<()> {
    let pipeline = pipeline_cache.get_render_pipeline(active.merge?.1)?;
    let group = bindings.merge.get()?;
    timed(ctx, MERGE, &mut |ctx| {
        let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some(MERGE),
            color_attachments: &[Some(target.get_color_attachment())],
            ..default()
        });
        pass.set_camera_viewport(&view.viewport);
        pass.set_render_pipeline(pipeline);
        pass.set_bind_group(0, group, &[view.offset]);
        pass.draw(0..3, 0..1);
    });
    Some(())
}
