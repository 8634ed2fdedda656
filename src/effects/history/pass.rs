//! Writes the output of the main passes to the history.

use bevy::{
    prelude::*,
    render::{
        render_resource::{ComputePassDescriptor, PipelineCache},
        renderer::{RenderContext, ViewQuery},
        view::ViewTarget,
    },
};

use super::{pipelines::HistoryPipelines, prepare::ViewHistory};
use crate::{effects::history_validity::FrameNumber, gpu::timed::timed};

const LABEL: &str = "lean_deferred/effects/history";

pub(super) fn keep_frame(
    view: ViewQuery<(&ViewHistory, &ViewTarget)>,
    cache: Res<PipelineCache>,
    pipelines: Option<Res<HistoryPipelines>>,
    number: Res<FrameNumber>,
    mut ctx: RenderContext,
) {
    let (history, target) = view.into_inner();
    let Some(queued) = pipelines.and_then(|pipelines| pipelines.queued) else {
        return;
    };
    let [Some(of_picture), Some(of_level)] =
        queued.map(|pipeline| cache.get_compute_pipeline(pipeline))
    else {
        return;
    };
    let (Some(picture), Some(means)) = (
        history.bind_group_of(target.main_texture()),
        history.bind_group_of_means(),
    ) else {
        return;
    };
    let [first, second] = history.workgroups();
    timed(&mut ctx, LABEL, &mut |ctx| {
        let mut pass = ctx
            .command_encoder()
            .begin_compute_pass(&ComputePassDescriptor {
                label: Some(LABEL),
                timestamp_writes: None,
            });
        pass.set_pipeline(of_picture);
        pass.set_bind_group(0, picture, &[history.offset()]);
        pass.dispatch_workgroups(first.x, first.y, 1);
        pass.set_pipeline(of_level);
        pass.set_bind_group(0, means, &[]);
        pass.dispatch_workgroups(second.x, second.y, 1);
    });
    history.hold(&number);
}
