//! The passes, after lighting: the light in ever coarser levels, and from the coarsest one back to the picture. Finer levels
//! only of the tiles that lighting has listed.

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

use super::{
    active::ActiveScattering,
    prepare::{DOWN, UP, ViewSubsurface},
};
use crate::{gpu::timed::timed, shader_library::tiles};

const LABEL: &str = "lean_deferred/screen_space/subsurface";
/// Workgroups that share the listed tiles, however many there are: enough for any GPU. An indirect dispatch would need one
/// of its own before it, in which its size is made sure of.
const WORKGROUPS: u32 = 4096;
/// Texels a side that a workgroup makes on the way back up.
const MADE_UP: u32 = 16;

/// The pass, while it is recorded.
struct Recording<'a, 'p> {
    pass: ComputePass<'p>,
    cache: &'a PipelineCache,
    view: &'a ViewSubsurface,
}

impl Recording<'_, '_> {
    /// `None` if something is missing: then nothing more is to be done.
    fn begin(
        &mut self,
        pipeline: CachedComputePipelineId,
        group: Option<&BindGroup>,
        offsets: &[u32],
    ) -> Option<()> {
        let pipeline = self.cache.get_compute_pipeline(pipeline)?;
        self.pass.set_pipeline(pipeline);
        self.pass.set_bind_group(0, group?, offsets);
        Some(())
    }

    /// Over the texels of a level in the listed tiles.
    fn tiles(
        &mut self,
        level: usize,
        pipeline: CachedComputePipelineId,
        group: Option<&BindGroup>,
    ) -> Option<()> {
        self.begin(pipeline, group, &[self.view.offsets[level]])?;
        let tiles = tiles::count(self.view.size).element_product();
        self.pass.dispatch_workgroups(tiles.min(WORKGROUPS), 1, 1);
        Some(())
    }

    /// Over all texels of a level, by workgroups of [`MADE_UP`] a side that share them.
    fn up(
        &mut self,
        level: usize,
        pipeline: CachedComputePipelineId,
        group: Option<&BindGroup>,
    ) -> Option<()> {
        self.begin(pipeline, group, &[self.view.offsets[level]])?;
        let size = self.view.size >> level as u32;
        let count = size.map(|side| side.div_ceil(MADE_UP)).element_product();
        self.pass.dispatch_workgroups(count.min(WORKGROUPS), 1, 1);
        Some(())
    }

    /// Over all texels of a level.
    fn level(
        &mut self,
        level: usize,
        pipeline: CachedComputePipelineId,
        group: Option<&BindGroup>,
    ) -> Option<()> {
        self.begin(pipeline, group, &[self.view.offsets[level]])?;
        let count = tiles::count(self.view.size >> level as u32);
        self.pass.dispatch_workgroups(count.x, count.y, 1);
        Some(())
    }

    fn all(&mut self, active: &ActiveScattering, picture: Option<&BindGroup>) -> Option<()> {
        let (passes, view) = (active.passes, self.view);
        self.tiles(1, passes.first, view.first.get())?;
        for (level, group) in DOWN.into_iter().zip(&view.down) {
            self.level(level, passes.down, group.get())?;
        }
        for (level, group) in UP.into_iter().zip(&view.up) {
            self.up(level, passes.up, group.get())?;
        }
        self.tiles(0, passes.picture, picture)
    }
}

/// Scatters the light that lighting has written apart, and adds what that changes to the picture.
pub(super) fn scatter_light(
    view: ViewQuery<(&ActiveScattering, &ViewSubsurface, &ViewTarget)>,
    cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (active, view, target) = view.into_inner();
    if !active.passes.are_compiled(&cache) {
        return;
    }
    timed(&mut ctx, LABEL, |ctx| {
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
