//! Existence of a view's motion target, and its debug view.

use bevy::{
    anti_alias::taa::TemporalAntiAliasing,
    core_pipeline::{
        prepass::{DepthPrepass, MotionVectorPrepass},
        tonemapping::Tonemapping,
    },
    prelude::*,
    render::{
        RenderApp,
        camera::{MipBias, TemporalJitter},
    },
};
use bevy_lean_deferred::{
    gbuffer::{GBufferTargets, GBufferTextures},
    prelude::*,
    view::ActiveLeanView,
};
use kit::{
    headless::Headless,
    lean::{build, change_cameras, set_lean},
    log_watch,
    own_process::in_own_process,
};

use super::{SIZE, SMALL, active_view, move_all, shift_movers, still_and_moving, taa, turn_camera};

type Taa = (
    TemporalAntiAliasing,
    TemporalJitter,
    MipBias,
    DepthPrepass,
    MotionVectorPrepass,
);

/// Renders frames in which everything moves. Returns the view, and true if it has a motion texture.
fn run(headless: &mut Headless, frames: usize) -> (Option<ActiveLeanView>, bool) {
    for frame in 0..frames {
        move_all(headless.world(), frame);
        headless.frames(1);
    }
    let view = active_view(headless);
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut textures = world.query::<&GBufferTextures>();
    let has_texture =
        (textures.iter(world)).any(|textures| textures.optional(GBufferTargets::MOTION).is_some());
    (view, has_texture)
}

#[test]
fn targets_come_and_go() {
    in_own_process(|| {
        let mut headless = build(SMALL, |s| still_and_moving(s, ()));
        set_lean(&mut headless, true);
        headless.settle();
        let world = headless.world();
        let mut cameras = world.query_filtered::<Entity, With<Camera3d>>();
        let camera = cameras.single(world).expect("one camera");
        for _ in 0..2 {
            let (view, has_texture) = run(&mut headless, 6);
            let view = view.expect("lean");
            assert!(!view.resolves_motion && !has_texture, "{view:?}");
            assert!(view.targets == GBufferTargets::EMISSIVE, "{view:?}");

            headless.world().entity_mut(camera).insert(taa());
            let (view, has_texture) = run(&mut headless, 6);
            assert!(view.expect("lean").resolves_motion && has_texture);

            headless.world().entity_mut(camera).remove::<Taa>();
        }

        // A view keeps its target for a while after motion stops, not for ever.
        headless.world().entity_mut(camera).insert(taa());
        assert!(run(&mut headless, 6).1);
        headless.frames(20);
        assert!(run(&mut headless, 0).1);
        headless.frames(180);
        let (view, has_texture) = run(&mut headless, 0);
        assert!(view.expect("lean").resolves_motion && !has_texture);

        set_lean(&mut headless, false);
        assert!(run(&mut headless, 3).0.is_none());
        log_watch::assert_validation_layer_silent();
    });
}

/// Without this crate, Bevy 0.19 ends the app.
#[test]
fn motion_vectors_may_go_while_depth_stays() {
    in_own_process(|| {
        let mut headless = build(SMALL, |s| {
            still_and_moving(s, (DepthPrepass, MotionVectorPrepass));
        });
        set_lean(&mut headless, true);
        headless.settle();
        change_cameras(&mut headless, |camera| {
            camera.remove::<MotionVectorPrepass>();
        });
        headless.settle();
        let before = headless.capture();
        turn_camera(headless.world(), 1.0);
        assert!(headless.capture() != before, "no frame is drawn");
        log_watch::assert_validation_layer_silent();
    });
}

/// In the debug view, moving meshes are coloured and resting ones black.
#[test]
fn the_motion_target_can_be_shown() {
    in_own_process(|| {
        let mut headless = build(SIZE, |s| {
            still_and_moving(s, MotionVectorPrepass);
        });
        change_cameras(&mut headless, |camera| {
            camera.insert((
                LeanDeferred::default(),
                LeanDebugView::from(DebugView::Motion),
                Tonemapping::None,
            ));
        });
        headless.settle();
        let film = headless.film(6, |world, _| {
            shift_movers(world, Vec3::new(0.06, 0.03, 0.0));
        });
        if let Some(folder) = std::env::var_os("PARITY_PICTURES") {
            film[5].save(std::path::Path::new(&folder).join("motion_channel.png"));
        }
        // Motion to the right and up: red above the middle, green below it, blue at it.
        let is_mover = |p: &[u8]| p[0] > 190 && p[1] < 185 && p[2].abs_diff(188) < 3;
        let is_still = |p: &[u8]| p[..3] == [0; 3];
        let count = |is: &dyn Fn(&[u8]) -> bool| film[5].rgba.chunks(4).filter(|p| is(p)).count();
        assert!(count(&is_mover) > 200, "{}", count(&is_mover));
        assert!(count(&is_still) > 10_000, "{}", count(&is_still));
    });
}
