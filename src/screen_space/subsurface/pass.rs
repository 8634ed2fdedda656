//! The passes, after lighting, over the tiles that lighting has listed.

use bevy::{
    prelude::*,
    render::{
        render_resource::{ComputePassDescriptor, PipelineCache},
        renderer::{RenderContext, ViewQuery},
        view::ViewTarget,
    },
};

use super::{active::ActiveScattering, key::Method, prepare::ViewSubsurface};
use crate::{gpu::timed::timed, lighting::ViewLighting};

/// Labels of the passes, by method.
fn labels(method: Method) -> [&'static str; 3] {
    match method {
        Method::Separable => [
            "lean_deferred/subsurface/across",
            "lean_deferred/subsurface/down",
            "lean_deferred/subsurface/clear",
        ],
        Method::Sampled(_) => [
            "lean_deferred/subsurface/levels",
            "lean_deferred/subsurface/scatter",
            "lean_deferred/subsurface/clear",
        ],
    }
}

/// Scatters the light that lighting has written apart, and adds what that changes to the picture.
pub(super) fn scatter_light(
    view: ViewQuery<(
        &ActiveScattering,
        &ViewSubsurface,
        &ViewLighting,
        &ViewTarget,
    )>,
    cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (active, subsurface, lighting, target) = view.into_inner();
    let (Some((dispatch, _)), Some(first), Some(second), Some(clear)) = (
        lighting.special_tiles(),
        subsurface.first.get(),
        subsurface.second.of(target.main_texture()),
        subsurface.clear.get(),
    ) else {
        return;
    };
    let passes = active.passes;
    let steps = [
        (passes.first, first),
        (passes.second, second),
        (passes.clear, clear),
    ];
    for (label, (pipeline, group)) in labels(active.key.method).into_iter().zip(steps) {
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
            pass.set_bind_group(0, group, &[subsurface.offset]);
            pass.dispatch_workgroups_indirect(dispatch, 0);
        });
    }
}
