//! The passes, after lighting: they downsample the light to ever coarser levels, and scatter it from the coarsest back to the image.
//! The finest levels are processed only in the blocks that lighting has listed.

use bevy::{
    prelude::*,
    render::{
        render_resource::{
            BindGroup, CachedComputePipelineId, ComputePass, ComputePassDescriptor, PipelineCache,
        },
        renderer::{RenderContext, ViewQuery},
        view::ViewTarget,
    },
};

use super::{active::ActiveScattering, prepare::ViewSubsurface};
use crate::{gpu::timed::timed, lighting::SUBSURFACE_BLOCK_LOG};

const LABEL: &str = "lean_deferred/effects/subsurface";
/// Workgroups that share the listed blocks, however many there are: enough for any GPU. An indirect dispatch would need an extra
/// dispatch before it, to validate its size.
const WORKGROUPS: u32 = 4096;

/// The pass being recorded.
struct Recording<'a, 'p> {
    pass: ComputePass<'p>,
    cache: &'a PipelineCache,
    view: &'a ViewSubsurface,
}

impl Recording<'_, '_> {
    /// Records the pass with this number. `None` if a resource is missing; the remaining passes are then skipped.
    fn dispatch(
        &mut self,
        number: usize,
        pipeline: CachedComputePipelineId,
        group: Option<&BindGroup>,
        workgroups: UVec2,
    ) -> Option<()> {
        let pipeline = self.cache.get_compute_pipeline(pipeline)?;
        self.pass.set_pipeline(pipeline);
        self.pass
            .set_bind_group(0, group?, &[self.view.offsets[number]]);
        self.pass.dispatch_workgroups(workgroups.x, workgroups.y, 1);
        Some(())
    }

    fn all(&mut self, active: &ActiveScattering, picture: Option<&BindGroup>) -> Option<()> {
        let (passes, view) = (active.passes, self.view);
        let blocks = (view.size >> SUBSURFACE_BLOCK_LOG).element_product();
        // The most workgroups that a list may need, at `each` per block.
        let listed = |each: u32| UVec2::new((each * blocks).min(WORKGROUPS), 1);
        // Workgroups that each write `made` × `made` texels of a level.
        let whole = |level: u32, made: u32| (view.size >> level).map(|side| side.div_ceil(made));
        self.dispatch(0, passes.first, view.first.get(), listed(1))?;
        self.dispatch(1, passes.down, view.down.get(), whole(3, 8))?;
        self.dispatch(2, passes.turn, view.turn.get(), whole(5, 8))?;
        self.dispatch(3, passes.up, view.up.get(), whole(3, 16))?;
        self.dispatch(4, passes.last, view.last.get(), listed(1))?;
        self.dispatch(5, passes.picture, picture, listed(4))
    }
}

/// Scatters the light that lighting has written separately, and adds the change to the image.
pub(super) fn scatter_light(
    view: ViewQuery<(&ActiveScattering, &ViewSubsurface, &ViewTarget)>,
    cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (active, view, target) = view.into_inner();
    if !active.passes.are_compiled(&cache) {
        return;
    }
    timed(&mut ctx, LABEL, &mut |ctx| {
        let encoder = ctx.command_encoder();
        let pass = encoder.begin_compute_pass(&ComputePassDescriptor {
            label: Some(LABEL),
            timestamp_writes: None,
        });
        let mut recording = Recording {
            pass,
            cache: &cache,
            view,
        };
        recording.all(active, view.picture.of(target.main_texture()));
    });
}
