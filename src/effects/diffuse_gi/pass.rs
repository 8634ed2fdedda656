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
    active::ActiveGi,
    pipelines::{GiPipelines, PASSES},
    prepare::GiBindings,
    textures::ViewGi,
};
use crate::{
    effects::history_validity::FrameNumber,
    gpu::timed::{TimesEachDispatch, timed_dispatches},
    view::{ActiveLeanView, LightingIo},
};

const LABEL: &str = "lean_deferred/effects/diffuse_gi";

/// Computes indirect diffuse light for the lighting pass.
pub(super) fn find_diffuse_light(
    view: ViewQuery<(&ActiveGi, &ActiveLeanView, &ViewGi, &GiBindings)>,
    cache: Res<PipelineCache>,
    pipelines: Option<Res<GiPipelines>>,
    number: Res<FrameNumber>,
    one_by_one: Option<Res<TimesEachDispatch>>,
    mut ctx: RenderContext,
) {
    let (active, lean, gi, bindings) = view.into_inner();
    let Some(pipelines) = pipelines else {
        return;
    };
    if !lean.io.contains(LightingIo::INDIRECT_DIFFUSE) {
        return;
    }
    let (groups, workgroups) = (bindings.current_groups(), gi.workgroups());
    let offsets = slice::from_ref(&gi.offset);
    let dispatches: [_; PASSES.len()] = pipelines.dispatches(&cache, active.key, |pass| {
        (groups[pass].get(), offsets, workgroups[pass])
    });
    if timed_dispatches(&mut ctx, LABEL, one_by_one.as_deref(), &dispatches).is_some() {
        gi.frames.hold(&number);
    }
}
