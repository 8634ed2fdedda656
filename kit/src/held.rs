//! What is alive on the GPU.

use bevy::render::{RenderApp, renderer::RenderInstance};

use crate::headless::Headless;

/// Handles that are alive, Bevy's and this crate's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Held {
    pub textures: usize,
    pub texture_views: usize,
    pub buffers: usize,
    pub bind_groups: usize,
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
        Self {
            textures: hub.textures.num_kept_from_user,
            texture_views: hub.texture_views.num_kept_from_user,
            buffers: hub.buffers.num_kept_from_user,
            bind_groups: hub.bind_groups.num_kept_from_user,
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
