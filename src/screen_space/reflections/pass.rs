//! The passes, between G-buffer and lighting.

use bevy::{
    prelude::*,
    render::{
        render_resource::PipelineCache,
        renderer::{RenderContext, ViewQuery},
    },
};

use super::{
    active::ActiveReflections,
    prepare::{ReflectionBindings, ViewReflections},
};
use crate::{
    gpu::timed::timed_dispatch,
    view::{ActiveLeanView, LightExchange},
};

/// Labels of the passes, in order.
pub(super) const PASSES: [&str; 4] = [
    "lean_deferred/screen_space/reflections/cells",
    "lean_deferred/screen_space/reflections/trace",
    "lean_deferred/screen_space/reflections/lobes",
    "lean_deferred/screen_space/reflections/resolve",
];

/// Finds what surfaces mirror, for the lighting pass.
pub(super) fn find_reflections(
    view: ViewQuery<(
        &ActiveReflections,
        &ActiveLeanView,
        &ViewReflections,
        &ReflectionBindings,
    )>,
    cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (active, lean, held, bindings) = view.into_inner();
    if !lean.exchange.contains(LightExchange::INDIRECT_SPECULAR) {
        return;
    }
    let steps = PASSES.into_iter().zip(active.passes.0);
    let workgroups = held.workgroups();
    for (((label, pipeline), group), count) in steps.zip(bindings.groups()).zip(workgroups) {
        let (Some(pipeline), Some(group)) = (cache.get_compute_pipeline(pipeline), group) else {
            return;
        };
        timed_dispatch(&mut ctx, label, pipeline, (group, held.offset), count);
    }
}
