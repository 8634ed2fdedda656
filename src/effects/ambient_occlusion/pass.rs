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
    lattice,
    pipelines::GatherPipeline,
    prepare::{OcclusionBindings, OcclusionTextures, ViewOcclusion},
    uniforms::workgroups,
};
use crate::gpu::timed::{Dispatch, TimesEachDispatch, timed, timed_dispatches};

const GATHER: &str = "lean_deferred/effects/ambient_occlusion/gather";
const SPARSE_DEPTH: &str = "lean_deferred/effects/ambient_occlusion/sparse_depth";
const MERGE: &str = "lean_deferred/effects/ambient_occlusion/merge";

type OcclusionView<'a> = (
    &'a ActiveOcclusion,
    &'a OcclusionTextures,
    &'a ViewOcclusion,
    &'a OcclusionBindings,
    &'a ViewTarget,
);

pub(super) type OcclusionViewQuery = OcclusionView<'static>;

/// Runs between G-buffer and lighting.
pub(super) fn occlusion_for_lighting(
    view: ViewQuery<OcclusionViewQuery>,
    pipeline_cache: Res<PipelineCache>,
    one_by_one: Option<Res<TimesEachDispatch>>,
    mut ctx: RenderContext,
) {
    let view @ (active, ..) = view.into_inner();
    if active.merge.is_none() {
        gather(view, &pipeline_cache, one_by_one.as_deref(), &mut ctx);
    }
}

/// Runs after the opaque meshes.
pub(super) fn occlusion_after_opaque(
    view: ViewQuery<OcclusionViewQuery>,
    pipeline_cache: Res<PipelineCache>,
    one_by_one: Option<Res<TimesEachDispatch>>,
    mut ctx: RenderContext,
) {
    let view @ (active, ..) = view.into_inner();
    if active.merge.is_some()
        && gather(view, &pipeline_cache, one_by_one.as_deref(), &mut ctx).is_some()
    {
        merge(view, &pipeline_cache, &mut ctx);
    }
}

/// `None` while the pipeline is compiling or the bind group is missing.
fn gather(
    (active, textures, view, bindings, _): OcclusionView,
    pipeline_cache: &PipelineCache,
    one_by_one: Option<&TimesEachDispatch>,
    ctx: &mut RenderContext,
) -> Option<()> {
    let group = bindings.gather.get()?;
    match active.gather? {
        GatherPipeline::Compute {
            gather,
            sparse_depth,
        } => {
            let dispatch = |label, pipeline, group, workgroups| {
                Some(Dispatch {
                    label,
                    pipeline: pipeline_cache.get_compute_pipeline(pipeline)?,
                    group,
                    offsets: slice::from_ref(&view.offset),
                    workgroups,
                })
            };
            let gather = dispatch(GATHER, gather, group, workgroups(view.uniform.texture_size));
            if let Some(pipeline) = sparse_depth {
                let group = bindings.sparse_depth.get()?;
                let workgroups = lattice::workgroups(view.viewport.physical_size);
                let sparse_depth = dispatch(SPARSE_DEPTH, pipeline, group, workgroups);
                timed_dispatches(ctx, GATHER, one_by_one, &[sparse_depth, gather])?;
            } else {
                timed_dispatches(ctx, GATHER, one_by_one, &[gather])?;
            }
        }
        GatherPipeline::Raster(pipeline) => {
            let pipeline = pipeline_cache.get_render_pipeline(pipeline)?;
            timed(ctx, GATHER, &mut |ctx| {
                let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
                    label: Some(GATHER),
                    color_attachments: &[Some(RenderPassColorAttachment {
                        view: &textures.occlusion.default_view,
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
    (active, _, view, bindings, target): OcclusionView,
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
