//! Optional G-buffer targets: their existence, that every mesh is drawn with them, and hard cases.

mod existence;
mod hard_cases;
mod overlaps;
mod writes;

use bevy::{
    core_pipeline::core_3d::{AlphaMask3d, Opaque3d},
    prelude::*,
    render::{RenderApp, render_phase::ViewBinnedRenderPhases},
};
use bevy_lean_deferred::gbuffer::GBufferUsage;
use kit::headless::Headless;

const SIZE: UVec2 = UVec2::new(320, 240);
/// For tests that compare no picture.
const SMALL: UVec2 = UVec2::new(64, 48);

/// Usage of the only lean camera.
fn usage(headless: &mut Headless) -> GBufferUsage {
    let world = headless.world();
    *world
        .query::<&GBufferUsage>()
        .single(world)
        .expect("there is one lean camera")
}

/// True if forward draws an opaque mesh for any camera.
fn forward_draws(headless: &Headless) -> bool {
    let world = headless.app.sub_app(RenderApp).world();
    let opaque = world.resource::<ViewBinnedRenderPhases<Opaque3d>>();
    let alpha_mask = world.resource::<ViewBinnedRenderPhases<AlphaMask3d>>();
    opaque.values().any(|phase| !phase.is_empty())
        || alpha_mask.values().any(|phase| !phase.is_empty())
}
