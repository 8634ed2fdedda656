//! The passes, between G-buffer and lighting.

use bevy::{
    prelude::*,
    render::{
        render_resource::{ComputePassDescriptor, PipelineCache},
        renderer::{RenderContext, ViewQuery},
    },
};

use super::{
    active::ActiveGi,
    prepare::{GiBindings, ViewGi},
};
use crate::{
    gpu::timed::timed,
    screen_space::succession::FrameNumber,
    view::{ActiveLeanView, LightExchange},
};

/// Labels of the passes, in order.
const PASSES: [&str; 3] = [
    "lean_deferred/diffuse_gi/levels",
    "lean_deferred/diffuse_gi/gather",
    "lean_deferred/diffuse_gi/filter",
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
        timed(&mut ctx, label, |ctx| {
            let mut pass = ctx
                .command_encoder()
                .begin_compute_pass(&ComputePassDescriptor {
                    label: Some(label),
                    timestamp_writes: None,
                });
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, group, &[gi.offset]);
            pass.dispatch_workgroups(count.x, count.y, 1);
        });
    }
    gi.frames.hold(&number);
}
