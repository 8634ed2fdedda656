//! Writes the output of the main passes to the history.

use bevy::{
    prelude::*,
    render::{
        render_resource::PipelineCache,
        renderer::{RenderContext, ViewQuery},
        view::ViewTarget,
    },
};

use super::{
    pipelines::{HistoryKey, HistoryPipelines, PASSES},
    prepare::ViewHistory,
};
use crate::{effects::history_validity::FrameNumber, gpu::timed::timed_dispatches};

const LABEL: &str = "lean_deferred/effects/history";

pub(super) fn keep_frame(
    view: ViewQuery<(&ViewHistory, &ViewTarget)>,
    cache: Res<PipelineCache>,
    pipelines: Option<Res<HistoryPipelines>>,
    number: Res<FrameNumber>,
    mut ctx: RenderContext,
) {
    let (history, target) = view.into_inner();
    let Some(pipelines) = pipelines else {
        return;
    };
    let groups = history.bind_groups(target.main_texture());
    let offset = [history.offset()];
    // The second dispatch reads no uniform.
    let offsets: [&[u32]; PASSES.len()] = [&offset, &[]];
    let workgroups = history.workgroups();
    let dispatches: [_; PASSES.len()] = pipelines.dispatches(&cache, HistoryKey, |pass| {
        (groups[pass], offsets[pass], workgroups[pass])
    });
    if timed_dispatches(&mut ctx, LABEL, None, &dispatches).is_some() {
        history.hold(&number);
    }
}
