//! Runs the passes together. The span `lean_deferred/effects/auto_exposure` times both: timestamps between them would cost as
//! much as the dispatches.

use bevy::{
    prelude::*,
    render::{
        render_resource::PipelineCache,
        renderer::{RenderContext, ViewQuery},
        view::{ViewTarget, ViewUniformOffset},
    },
};

use super::{
    active::ActiveExposure,
    pipelines::{ExposurePipelines, PASSES},
    prepare::{ExposureBindings, ViewExposure},
    readback::ExposureReadback,
    state::ExposureHistory,
};
use crate::gpu::timed::timed_dispatches;

const LABEL: &str = "lean_deferred/effects/auto_exposure";

/// Meters the image and adapts the view's exposure, between anti-aliasing and post-processing.
pub(super) fn auto_exposure(
    view: ViewQuery<(
        &ViewExposure,
        &ActiveExposure,
        &ExposureBindings,
        &ExposureHistory,
        Option<&ExposureReadback>,
        &ViewTarget,
        &ViewUniformOffset,
    )>,
    pipeline_cache: Res<PipelineCache>,
    pipelines: Option<Res<ExposurePipelines>>,
    mut ctx: RenderContext,
) {
    let (view, active, bindings, history, readback, target, view_offset) = view.into_inner();
    let Some(pipelines) = pipelines else {
        return;
    };
    let groups = bindings.groups(target.main_texture());
    // Only the second pass writes Bevy's view.
    let of_both = [view.offset, view_offset.offset];
    let offsets: [&[u32]; PASSES.len()] = [&of_both[..1], &of_both];
    let workgroups = [view.workgroups, UVec2::ONE];
    let dispatches: [_; PASSES.len()] = pipelines.dispatches(&pipeline_cache, active.key, |pass| {
        (groups[pass], offsets[pass], workgroups[pass])
    });
    let ran = timed_dispatches(&mut ctx, LABEL, None, &dispatches).is_some();
    if let Some(readback) = readback.filter(|_| ran) {
        readback.copy(&history.state, ctx.command_encoder());
    }
}
