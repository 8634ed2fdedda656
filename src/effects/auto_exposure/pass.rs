//! The two dispatches, in one compute pass. The span `lean_deferred/effects/auto_exposure` times both: timestamps between them
//! would cost as much as the dispatches.

use bevy::{
    prelude::*,
    render::{
        render_resource::{ComputePassDescriptor, PipelineCache},
        renderer::{RenderContext, ViewQuery},
        view::{ViewTarget, ViewUniformOffset},
    },
};

use super::{
    active::ViewExposurePipelines,
    prepare::{ExposureBindings, ViewExposure},
    readback::ExposureReadback,
    state::ExposureHistory,
};
use crate::gpu::timed::timed;

/// Meters the image and adapts the view's exposure, between anti-aliasing and post-processing.
pub(super) fn auto_exposure(
    view: ViewQuery<(
        &ViewExposure,
        &ViewExposurePipelines,
        &ExposureBindings,
        &ExposureHistory,
        Option<&ExposureReadback>,
        &ViewTarget,
        &ViewUniformOffset,
    )>,
    pipeline_cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (view, pipelines, bindings, history, readback, target, view_offset) = view.into_inner();
    let picture = Some(target.main_texture_view().id());
    let (Some(meter), Some(adapt), Some(meter_group), Some(adapt_group)) = (
        pipeline_cache.get_compute_pipeline(pipelines.passes.meter),
        pipeline_cache.get_compute_pipeline(pipelines.passes.adapt),
        bindings
            .meter
            .iter()
            .find(|(id, _)| *id == picture)
            .and_then(|(_, group)| group.get()),
        bindings.adapt.get(),
    ) else {
        return;
    };

    timed(
        &mut ctx,
        "lean_deferred/effects/auto_exposure",
        &mut |ctx| {
            let mut pass = ctx
                .command_encoder()
                .begin_compute_pass(&ComputePassDescriptor {
                    label: Some("lean_deferred/effects/auto_exposure"),
                    timestamp_writes: None,
                });
            pass.set_pipeline(meter);
            pass.set_bind_group(0, meter_group, &[view.offset]);
            pass.dispatch_workgroups(view.workgroups.x, view.workgroups.y, 1);
            pass.set_pipeline(adapt);
            pass.set_bind_group(0, adapt_group, &[view.offset, view_offset.offset]);
            pass.dispatch_workgroups(1, 1, 1);
        },
    );
    if let Some(readback) = readback {
        readback.copy(&history.state, ctx.command_encoder());
    }
}
