//! The two dispatches. Their GPU times are those of the spans `lean_deferred/exposure/meter` and `…/adapt`, where the device
//! can tell times within a pass, and together of `lean_deferred/exposure`.

use bevy::{
    prelude::*,
    render::{
        diagnostic::RecordDiagnostics,
        render_resource::{ComputePassDescriptor, PipelineCache},
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

    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let span = diagnostics.time_span(ctx.command_encoder(), "lean_deferred/exposure");
    // One pass for both: each pass more would cost as much as a dispatch.
    let mut pass = ctx
        .command_encoder()
        .begin_compute_pass(&ComputePassDescriptor {
            label: Some("lean_deferred/exposure"),
            timestamp_writes: None,
        });
    let mut dispatch = |name: &'static str, pipeline, group, offsets: &[u32], groups: UVec2| {
        let span = diagnostics.pass_span(&mut pass, name);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, offsets);
        pass.dispatch_workgroups(groups.x, groups.y, 1);
        span.end(&mut pass);
    };
    dispatch("meter", meter, meter_group, &[view.offset], view.workgroups);
    dispatch(
        "adapt",
        adapt,
        adapt_group,
        &[view.offset, view_offset.offset],
        UVec2::ONE,
    );
    drop(pass);
    span.end(ctx.command_encoder());
}
