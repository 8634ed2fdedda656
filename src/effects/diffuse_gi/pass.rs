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
    effects::history_validity::FrameNumber,
    gpu::{
        bind_group_cache::CachedBindGroup,
        timed::{Dispatch, TimesEachDispatch, timed_dispatches},
    },
    view::{ActiveLeanView, LightingIo},
};

const LABEL: &str = "lean_deferred/effects/diffuse_gi";
/// Labels of the dispatches, in order.
const PASSES: [&str; 3] = [
    "lean_deferred/effects/diffuse_gi/levels",
    "lean_deferred/effects/diffuse_gi/gather",
    "lean_deferred/effects/diffuse_gi/filter",
];

/// Computes indirect diffuse light for the lighting pass.
pub(super) fn find_diffuse_light(
    view: ViewQuery<(&ActiveGi, &ActiveLeanView, &ViewGi, &GiBindings)>,
    cache: Res<PipelineCache>,
    number: Res<FrameNumber>,
    one_by_one: Option<Res<TimesEachDispatch>>,
    mut ctx: RenderContext,
) {
    let (active, lean, gi, bindings) = view.into_inner();
    if !lean.io.contains(LightingIo::INDIRECT_DIFFUSE) {
        return;
    }
    if let Some(dispatches) = dispatches(active, gi, bindings, &cache) {
        timed_dispatches(&mut ctx, LABEL, one_by_one.as_deref(), &dispatches);
        gi.frames.hold(&number);
    }
}

/// `None` if a pipeline or bind group is missing.
fn dispatches<'a>(
    active: &ActiveGi,
    gi: &ViewGi,
    bindings: &'a GiBindings,
    cache: &'a PipelineCache,
) -> Option<[Dispatch<'a>; PASSES.len()]> {
    let (passes, groups) = (active.passes, &bindings.groups[bindings.current]);
    let workgroups = gi.workgroups();
    let pass = |i: usize, pipeline, group: &'a CachedBindGroup| {
        Some(Dispatch {
            label: PASSES[i],
            pipeline: cache.get_compute_pipeline(pipeline)?,
            group: group.get()?,
            offset: gi.offset,
            workgroups: workgroups[i],
        })
    };
    Some([
        pass(0, passes.levels, &groups.levels)?,
        pass(1, passes.gather, &groups.gather)?,
        pass(2, passes.filter, &groups.filter)?,
    ])
}
