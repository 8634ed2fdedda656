//! Passes whose GPU time Bevy's `RenderDiagnosticsPlugin` records.

use bevy::render::{diagnostic::RecordDiagnostics, renderer::RenderContext};

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
