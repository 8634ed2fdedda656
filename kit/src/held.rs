//! What is alive on the GPU.

use bevy::render::{
    RenderApp,
    renderer::{RenderDevice, RenderInstance},
};

use crate::headless::Headless;

/// Handles that are alive, Bevy's and this crate's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Held {
    pub textures: usize,
    pub texture_views: usize,
    pub buffers: usize,
    pub bind_groups: usize,
    /// For rendering and for computing.
    pub pipelines: usize,
    /// Of memory, as wgpu's allocator counts them; 0 where a backend has no such allocator.
    pub bytes: usize,
}

impl Held {
    /// After the last frame.
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

    /// What there is more of than there was.
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

    /// Once nothing changes any more.
    pub fn once_settled(headless: &mut Headless) -> Self {
        headless.settle();
        // Bevy keeps textures that nobody asks for three frames longer.
        headless.frames(5);
        Self::now(headless)
    }
}
