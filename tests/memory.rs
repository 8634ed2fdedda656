//! What a lean camera holds on the GPU it gives back when the component is removed, or the camera is switched off.

mod common;

use bevy::{
    prelude::*,
    render::{RenderApp, renderer::RenderInstance},
};
use common::{
    headless::Headless,
    lean::{active_lean_views, build, set_lean},
};

/// Handles that are alive, Bevy's and this crate's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Held {
    textures: usize,
    texture_views: usize,
    bind_groups: usize,
}

/// Once nothing changes any more.
fn held(headless: &mut Headless) -> Held {
    headless.settle();
    // Bevy keeps textures that nobody asks for three frames longer.
    headless.frames(8);
    let render_world = headless.app.sub_app(RenderApp).world();
    let report = render_world
        .resource::<RenderInstance>()
        .generate_report()
        .expect("wgpu itself runs here, not a browser's WebGPU");
    let hub = report.hub_report();
    Held {
        textures: hub.textures.num_kept_from_user,
        texture_views: hub.texture_views.num_kept_from_user,
        bind_groups: hub.bind_groups.num_kept_from_user,
    }
}

#[test]
fn what_is_held_is_given_back() {
    let mut camera = Entity::PLACEHOLDER;
    let mut headless = build(UVec2::new(160, 120), |s| {
        s.solids();
        s.sun(true);
        camera = s.default_camera(());
    });
    let mut held_by = |lean, is_active| {
        set_lean(&mut headless, lean);
        let mut camera = headless.world().entity_mut(camera);
        camera.get_mut::<Camera>().expect("it is one").is_active = is_active;
        let held = held(&mut headless);
        println!("lean: {lean}, active: {is_active}, {held:?}");
        held
    };

    let forward = held_by(false, true);
    let forward_off = held_by(false, false);
    let lean = held_by(true, true);
    let forward_again = held_by(false, true);
    let lean_again = held_by(true, true);
    let lean_off = held_by(true, false);
    held_by(true, true);
    assert_eq!(active_lean_views(&mut headless), 1, "it is off for ever");

    let textures = |held: Held| [held.textures, held.texture_views];
    assert_eq!(
        textures(lean),
        textures(forward).map(|count| count + 2),
        "the G-buffer has two"
    );
    assert_eq!(textures(forward_again), textures(forward));
    assert_eq!(textures(lean_off), textures(forward_off));
    // Bevy keeps a few bind groups for each kind of render phase that was ever used. They do not become more.
    assert_eq!(lean_again, lean);
}
