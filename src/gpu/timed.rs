//! Runs passes with GPU times for Bevy's `RenderDiagnosticsPlugin`.

use core::iter;

use bevy::{
    ecs::resource::Resource,
    math::UVec2,
    render::{
        diagnostic::RecordDiagnostics,
        render_resource::{BindGroup, ComputePassDescriptor, ComputePipeline},
        renderer::RenderContext,
    },
};

/// Runs `passes`, recorded together under `label`.
pub(crate) fn timed(
    ctx: &mut RenderContext,
    label: &'static str,
    // Not generic: with bounds, the compiler takes seconds to prove that the recorder is `Send`.
    passes: &mut dyn FnMut(&mut RenderContext),
) {
    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let span = diagnostics.time_span(ctx.command_encoder(), label);
    passes(ctx);
    span.end(ctx.command_encoder());
}

/// In the render world: gives each dispatch of an effect a pass of its own and records its time separately, for
/// profiling. An effect takes longer then: some 7 µs per dispatch after the first, on a desktop GPU.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct TimesEachDispatch;

/// A dispatch of workgroups.
pub(crate) struct Dispatch<'a> {
    /// Label of its time if that is recorded separately.
    pub(crate) label: &'static str,
    pub(crate) pipeline: &'a ComputePipeline,
    pub(crate) group: &'a BindGroup,
    /// Dynamic offsets of the bind group.
    pub(crate) offsets: &'a [u32],
    pub(crate) workgroups: UVec2,
}

/// Runs `dispatch` in a pass of its own.
fn timed_dispatch(ctx: &mut RenderContext, dispatch: &Dispatch) {
    let label = dispatch.label;
    timed(ctx, label, &mut |ctx| {
        run(ctx, label, &mut iter::once(dispatch));
    });
}

/// Runs `dispatches` in one pass, recorded under `label`: each pass is a separate command buffer, which costs time.
/// With `one_by_one`, each runs in its own pass. If one of them is missing, none runs, and the result is `None`.
pub(crate) fn timed_dispatches(
    ctx: &mut RenderContext,
    label: &'static str,
    one_by_one: Option<&TimesEachDispatch>,
    dispatches: &[Option<Dispatch>],
) -> Option<()> {
    if dispatches.iter().any(Option::is_none) {
        return None;
    }
    if one_by_one.is_some() {
        for dispatch in dispatches.iter().flatten() {
            timed_dispatch(ctx, dispatch);
        }
    } else {
        timed(ctx, label, &mut |ctx| {
            run(ctx, label, &mut dispatches.iter().flatten());
        });
    }
    Some(())
}

fn run<'a>(
    ctx: &mut RenderContext,
    label: &'static str,
    dispatches: &mut dyn Iterator<Item = &'a Dispatch<'a>>,
) {
    let encoder = ctx.command_encoder();
    let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
        label: Some(label),
        timestamp_writes: None,
    });
    for dispatch in dispatches {
        let UVec2 { x, y } = dispatch.workgroups;
        pass.set_pipeline(dispatch.pipeline);
        pass.set_bind_group(0, dispatch.group, dispatch.offsets);
        pass.dispatch_workgroups(x, y, 1);
    }
}
