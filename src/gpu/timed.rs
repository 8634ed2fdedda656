//! Passes whose GPU time Bevy's `RenderDiagnosticsPlugin` records.

use bevy::{
    math::UVec2,
    render::{
        diagnostic::RecordDiagnostics,
        render_resource::{BindGroup, ComputePassDescriptor, ComputePipeline},
        renderer::RenderContext,
    },
};

/// Runs `passes`, recorded together under `label`.
pub(crate) fn timed<'w, 's>(
    ctx: &mut RenderContext<'w, 's>,
    label: &'static str,
    passes: impl FnOnce(&mut RenderContext<'w, 's>),
) {
    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let span = diagnostics.time_span(ctx.command_encoder(), label);
    passes(ctx);
    span.end(ctx.command_encoder());
}

/// One dispatch of so many workgroups, recorded under `label`. Group 0 has one dynamic offset.
pub(crate) fn timed_dispatch(
    ctx: &mut RenderContext,
    label: &'static str,
    pipeline: &ComputePipeline,
    (group, offset): (&BindGroup, u32),
    workgroups: UVec2,
) {
    timed(ctx, label, |ctx| {
        let mut pass = ctx
            .command_encoder()
            .begin_compute_pass(&ComputePassDescriptor {
                label: Some(label),
                timestamp_writes: None,
            });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[offset]);
        pass.dispatch_workgroups(workgroups.x, workgroups.y, 1);
    });
}
