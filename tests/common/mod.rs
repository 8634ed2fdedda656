//! What tests and benches share: rendering without a window, comparing pictures, scenes built in code, ground truth for
//! ambient occlusion.
#![allow(dead_code, reason = "each binary uses a part")]

pub mod compute;
pub mod headless;
pub mod metrics;
pub mod occlusion;
pub mod occlusion_gpu;
pub mod random;
pub mod scenes;

use bevy::{prelude::*, render::RenderApp};
use bevy_lean_deferred::camera::ActiveLeanView;

/// How many views were rendered lean in the last frame.
pub fn active_lean_views(headless: &mut headless::Headless) -> usize {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    world
        .query_filtered::<(), With<ActiveLeanView>>()
        .iter(world)
        .count()
}
