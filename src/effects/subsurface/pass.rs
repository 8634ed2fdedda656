//! Runs the passes, after lighting: they downsample the light to ever coarser levels, and scatter it from the coarsest back to the
//! image. The finest levels are processed only in the blocks that lighting has listed.

use core::slice;

use bevy::{
    prelude::*,
    render::{
        render_resource::PipelineCache,
        renderer::{RenderContext, ViewQuery},
        view::ViewTarget,
    },
};

use super::{
    active::ActiveScattering,
    pipelines::{PASSES, SubsurfacePipelines},
    prepare::ViewSubsurface,
};
use crate::{gpu::timed::timed_dispatches, lighting::SUBSURFACE_BLOCK_LOG};

const LABEL: &str = "lean_deferred/effects/subsurface";
/// Workgroups that share the listed blocks, however many there are: enough for any GPU. An indirect dispatch would need an extra
/// dispatch before it, to validate its size.
const WORKGROUPS: u32 = 4096;

/// Workgroups of the passes.
fn workgroups(size: UVec2) -> [UVec2; PASSES.len()] {
    let blocks = (size >> SUBSURFACE_BLOCK_LOG).element_product();
    // The most workgroups that a list may need, at `each` per block.
    let listed = |each: u32| UVec2::new((each * blocks).min(WORKGROUPS), 1);
    // Workgroups that each write `made` × `made` texels of a level.
    let whole = |level: u32, made: u32| (size >> level).map(|side| side.div_ceil(made));
    [
        listed(1),
        whole(3, 8),
        whole(5, 8),
        whole(3, 16),
        listed(1),
        listed(4),
    ]
}

/// Scatters the light that lighting has written separately, and adds the change to the image.
pub(super) fn scatter_light(
    view: ViewQuery<(&ActiveScattering, &ViewSubsurface, &ViewTarget)>,
    cache: Res<PipelineCache>,
    pipelines: Option<Res<SubsurfacePipelines>>,
    mut ctx: RenderContext,
) {
    let (active, view, target) = view.into_inner();
    let Some(pipelines) = pipelines else {
        return;
    };
    let (picture, workgroups) = (target.main_texture(), workgroups(view.size));
    let dispatches: [_; PASSES.len()] = pipelines.dispatches(&cache, active.key, |pass| {
        let offsets = slice::from_ref(&view.offsets[pass]);
        (view.group(pass, picture), offsets, workgroups[pass])
    });
    timed_dispatches(&mut ctx, LABEL, None, &dispatches);
}
