//! What is alive on the GPU when nothing is shown any more.

use bevy::render::{RenderApp, renderer::RenderInstance};
use kit::headless::Headless;

/// Handles that are alive, Bevy's and this crate's.
#[derive(Clone, Copy, Debug)]
pub struct Held {
    textures: usize,
    texture_views: usize,
    buffers: usize,
    bind_groups: usize,
}

impl Held {
    /// Bevy keeps textures that nobody asks for three frames longer.
    pub fn of(headless: &mut Headless) -> Self {
        headless.settle();
        headless.frames(5);
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
}

/// Of epochs after the first two: Bevy keeps some of what was ever used.
pub fn assert_it_does_not_climb(held: &[Held]) {
    let [_, second, .., last] = held else {
        return;
    };
    println!("{second:?}, at last {last:?}");
}
