//! The passes, between G-buffer and lighting.

use core::slice;

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
    gpu::timed::{Dispatch, TimesEachDispatch, timed_dispatches},
    view::{ActiveLeanView, LightingIo},
};

const LABEL: &str = "lean_deferred/effects/reflections";
/// Labels of the dispatches, in order.
pub(super) const PASSES: [&str; 4] = [
    "lean_deferred/effects/reflections/hi_z",
    "lean_deferred/effects/reflections/trace",
    "lean_deferred/effects/reflections/spatial_filter",
    "lean_deferred/effects/reflections/resolve",
];

/// Computes reflections for the lighting pass.
pub(super) fn find_reflections(
    view: ViewQuery<(
        &ActiveReflections,
        &ActiveLeanView,
        &ViewReflections,
        &ReflectionBindings,
    )>,
    cache: Res<PipelineCache>,
    one_by_one: Option<Res<TimesEachDispatch>>,
    mut ctx: RenderContext,
) {
    let (active, lean, held, bindings) = view.into_inner();
    if !lean.io.contains(LightingIo::INDIRECT_SPECULAR) {
        return;
    }
    let dispatches = dispatches(active, held, bindings, &cache);
    timed_dispatches(&mut ctx, LABEL, one_by_one.as_deref(), &dispatches);
}

/// `None` for passes whose pipeline or bind group is missing.
fn dispatches<'a>(
    active: &ActiveReflections,
    held: &'a ViewReflections,
    bindings: &'a ReflectionBindings,
    cache: &'a PipelineCache,
) -> [Option<Dispatch<'a>>; PASSES.len()] {
    let (groups, workgroups) = (bindings.groups(), held.workgroups());
    let pass = |i: usize| {
        Some(Dispatch {
            label: PASSES[i],
            pipeline: cache.get_compute_pipeline(active.passes.0[i])?,
            group: groups[i]?,
            offsets: slice::from_ref(&held.offset),
            workgroups: workgroups[i],
        })
    };
    core::array::from_fn(pass)
}
