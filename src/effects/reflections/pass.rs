//! Runs the passes, between G-buffer and lighting.

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
    pipelines::{PASSES, ReflectionPipelines},
    prepare::{ReflectionBindings, ViewReflections},
};
use crate::{
    gpu::timed::{TimesEachDispatch, timed_dispatches},
    view::{ActiveLeanView, LightingIo},
};

const LABEL: &str = "lean_deferred/effects/reflections";

/// Computes reflections for the lighting pass.
pub(super) fn find_reflections(
    view: ViewQuery<(
        &ActiveReflections,
        &ActiveLeanView,
        &ViewReflections,
        &ReflectionBindings,
    )>,
    cache: Res<PipelineCache>,
    pipelines: Option<Res<ReflectionPipelines>>,
    one_by_one: Option<Res<TimesEachDispatch>>,
    mut ctx: RenderContext,
) {
    let (active, lean, held, bindings) = view.into_inner();
    let Some(pipelines) = pipelines else {
        return;
    };
    if !lean.io.contains(LightingIo::INDIRECT_SPECULAR) {
        return;
    }
    let (groups, workgroups) = (bindings.groups(held.written()), held.workgroups());
    let offsets = slice::from_ref(&held.offset);
    let dispatches: [_; PASSES.len()] = pipelines.dispatches(&cache, active.key, |pass| {
        (groups[pass], offsets, workgroups[pass])
    });
    timed_dispatches(&mut ctx, LABEL, one_by_one.as_deref(), &dispatches);
}
