//! The two dispatches.

use bevy::{
    prelude::*,
    render::{
        diagnostic::RecordDiagnostics,
        render_resource::{BindGroup, ComputePassDescriptor, ComputePipeline, PipelineCache},
        renderer::{RenderContext, ViewQuery},
        view::{ViewTarget, ViewUniformOffset},
    },
};

use super::{bindings::ExposureBindings, pipelines::ViewExposurePipelines, uniforms::ViewExposure};

/// Between anti-aliasing and post-processing: measures the picture, and adapts the view's exposure.
pub(super) fn auto_exposure(
    view: ViewQuery<(
        &ViewExposure,
        &ViewExposurePipelines,
        &ExposureBindings,
        &ViewTarget,
        &ViewUniformOffset,
    )>,
    pipeline_cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (view, pipelines, bindings, target, view_offset) = view.into_inner();
    let picture = Some(target.main_texture_view().id());
    let (Some(meter), Some(adapt), Some(meter_group), Some(adapt_group)) = (
        pipeline_cache.get_compute_pipeline(pipelines.meter),
        pipeline_cache.get_compute_pipeline(pipelines.adapt),
        bindings
            .meter
            .iter()
            .find(|(id, _)| *id == picture)
            .and_then(|(_, group)| group.get()),
        bindings.adapt.get(),
    ) else {
        return;
    };
    dispatch(
        &mut ctx,
        "lean_deferred/exposure/meter",
        (meter, meter_group),
        &[view.offset],
        view.workgroups,
    );
    dispatch(
        &mut ctx,
        "lean_deferred/exposure/adapt",
        (adapt, adapt_group),
        &[view.offset, view_offset.offset],
        UVec2::ONE,
    );
}

fn dispatch(
    ctx: &mut RenderContext,
    name: &'static str,
    (pipeline, group): (&ComputePipeline, &BindGroup),
    offsets: &[u32],
    workgroups: UVec2,
) {
    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let span = diagnostics.time_span(ctx.command_encoder(), name);
    let mut pass = ctx
        .command_encoder()
        .begin_compute_pass(&ComputePassDescriptor {
            label: Some(name),
            timestamp_writes: None,
        });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, group, offsets);
    pass.dispatch_workgroups(workgroups.x, workgroups.y, 1);
    drop(pass);
    span.end(ctx.command_encoder());
}
