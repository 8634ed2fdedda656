//! The passes, between G-buffer and lighting.

use bevy::{
    prelude::*,
    render::{
        render_resource::PipelineCache,
        renderer::{RenderContext, ViewQuery},
    },
};

use super::{
    active::ActiveGi,
    prepare::{GiBindings, ViewGi},
};
use crate::{
    gpu::timed::timed_dispatch,
    screen_space::succession::FrameNumber,
    view::{ActiveLeanView, LightExchange},
};

/// Labels of the passes, in order.
const PASSES: [&str; 3] = [
    "lean_deferred/screen_space/diffuse_gi/levels",
    "lean_deferred/screen_space/diffuse_gi/gather",
    "lean_deferred/screen_space/diffuse_gi/filter",
];

/// Finds what surfaces send to one another, for the lighting pass.
pub(super) fn find_diffuse_light(
    view: ViewQuery<(&ActiveGi, &ActiveLeanView, &ViewGi, &GiBindings)>,
    cache: Res<PipelineCache>,
    number: Res<FrameNumber>,
    mut ctx: RenderContext,
) {
    let (active, lean, gi, bindings) = view.into_inner();
    if !lean.exchange.contains(LightExchange::INDIRECT_DIFFUSE) {
        return;
    }
    let groups = &bindings.groups[bindings.current];
    let (Some(levels), Some(gather), Some(filter)) = (
        groups.levels.get(),
        groups.gather.get(),
        groups.filter.get(),
    ) else {
        return;
    };
    let passes = active.passes;
    let steps = [
        (passes.levels, levels),
        (passes.gather, gather),
        (passes.filter, filter),
    ];
    for ((label, (pipeline, group)), count) in PASSES.into_iter().zip(steps).zip(gi.workgroups()) {
        let Some(pipeline) = cache.get_compute_pipeline(pipeline) else {
            return;
        };
        timed_dispatch(&mut ctx, label, pipeline, (group, gi.offset), count);
    }
    gi.frames.hold(&number);
}
