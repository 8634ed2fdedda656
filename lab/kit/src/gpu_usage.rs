//! Live GPU resources, and their memory.

use bevy::render::{
    RenderApp,
    renderer::{RenderDevice, RenderInstance},
};

use crate::headless::Headless;

/// Number and bytes of wgpu's allocations for textures and buffers whose labels begin with `prefix`. `None` on backends without such an
/// allocator.
pub fn allocated(headless: &Headless, prefix: &str) -> Option<(u64, u64)> {
    let device = headless.device().wgpu_device();
    let report = device.generate_allocator_report()?;
    let found = (report.allocations.iter())
        .filter(|allocation| allocation.name.starts_with(prefix))
        .map(|allocation| (1, allocation.size));
    Some(found.fold((0, 0), |all, one| (all.0 + one.0, all.1 + one.1)))
}

/// Live handles of Bevy and this crate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GpuUsage {
    pub textures: usize,
    pub texture_views: usize,
    pub buffers: usize,
    pub bind_groups: usize,
    /// Render and compute pipelines.
    pub pipelines: usize,
    /// Memory as wgpu's allocator counts it; 0 on backends without such an allocator.
    pub bytes: usize,
}

impl GpuUsage {
    /// Counts after the last frame.
    pub fn now(headless: &Headless) -> Self {
        let render_world = headless.app.sub_app(RenderApp).world();
        let report = render_world
            .resource::<RenderInstance>()
            .generate_report()
            .expect("wgpu itself runs here, not a browser's WebGPU");
        let hub = report.hub_report();
        let device = render_world.resource::<RenderDevice>().wgpu_device();
        let memory = device.generate_allocator_report();
        Self {
            textures: hub.textures.num_kept_from_user,
            texture_views: hub.texture_views.num_kept_from_user,
            buffers: hub.buffers.num_kept_from_user,
            bind_groups: hub.bind_groups.num_kept_from_user,
            pipelines: hub.render_pipelines.num_kept_from_user
                + hub.compute_pipelines.num_kept_from_user,
            bytes: memory.map_or(0, |memory| memory.total_allocated_bytes as usize),
        }
    }

    /// Growth of each count since `before`.
    pub fn more_than(&self, before: &Self) -> Self {
        let more = |count: fn(&Self) -> usize| count(self).saturating_sub(count(before));
        Self {
            textures: more(|held| held.textures),
            texture_views: more(|held| held.texture_views),
            buffers: more(|held| held.buffers),
            bind_groups: more(|held| held.bind_groups),
            pipelines: more(|held| held.pipelines),
            bytes: more(|held| held.bytes),
        }
    }

    /// Counts once nothing changes any more.
    pub fn once_settled(headless: &mut Headless) -> Self {
        headless.settle();
        // Bevy keeps unused textures for three more frames.
        headless.frames(5);
        Self::now(headless)
    }
}
