//! Motion vectors with two-phase occlusion culling, and with prepasses that the G-buffer cannot replace.

use bevy::{
    core_pipeline::prepass::{MotionVectorPrepass, NormalPrepass},
    material::OpaqueRendererMethod,
    prelude::*,
    render::{occlusion_culling::OcclusionCulling, render_resource::TextureUsages},
};
use kit::{
    lean::build, own_process::in_own_process, scenes::SceneBuilder, skipped::culls_what_is_hidden,
};

use super::{Mover, SIZE, case::Case, move_all, still_and_moving, taa, turn_camera};

/// A wall that hides the scene except the movers' path disappears and returns, and the camera cuts to behind it.
fn uncover(world: &mut World, frame: usize) {
    move_all(world, frame);
    let hides = matches!(frame, 0..3 | 5..8 | 11..14);
    let mut walls = world.query_filtered::<&mut Transform, With<Wall>>();
    walls.single_mut(world).expect("one wall").translation.y = if hides { 0.0 } else { -30.0 };
    if frame == 9 {
        turn_camera(world, 2.5);
    }
}

#[derive(Component)]
struct Wall;

fn hidden_scene(s: &mut SceneBuilder, camera: impl Bundle) {
    still_and_moving(s, camera);
    for i in 0..12 {
        let ball = s.mesh(
            Sphere::new(0.25),
            StandardMaterial {
                opaque_render_method: if i % 3 == 0 {
                    OpaqueRendererMethod::Forward
                } else {
                    OpaqueRendererMethod::Auto
                },
                ..Color::srgb(0.5, 0.6, 0.2).into()
            },
            Transform::from_xyz(i as f32 * 0.4 - 2.2, 0.6, 1.4 + (i % 4) as f32 * 0.2),
        );
        if i % 2 == 0 {
            s.world().entity_mut(ball).insert(Mover);
        }
    }
    let wall = s.mesh(
        Cuboid::new(7.0, 3.0, 0.1),
        Color::srgb(0.6, 0.6, 0.6),
        Transform::from_xyz(0.0, 0.0, 2.8),
    );
    s.world().entity_mut(wall).insert(Wall);
}

/// The hidden scene with culling. Forward is filmed first and culls only if `culls_forward`; otherwise it is the reference.
fn culled<C: Bundle>(camera: impl Fn() -> C, culls_forward: bool) -> impl FnMut(&mut SceneBuilder) {
    let mut is_lean = false;
    move |s| {
        hidden_scene(s, camera());
        if is_lean || culls_forward {
            let mut cameras = s.world().query_filtered::<Entity, With<Camera3d>>();
            let camera = cameras.single(s.world()).expect("one camera");
            s.world().entity_mut(camera).insert(OcclusionCulling);
        }
        is_lean = true;
    }
}

#[test]
fn occlusion_culling() {
    in_own_process(|| {
        if !culls_what_is_hidden(&build(SIZE, |_| {})) {
            return;
        }
        let case = Case::new("occlusion_culling", culled(taa, false), uncover);
        let (errors, _) = Case { frames: 16, ..case }.measure();
        assert!(errors.largest_share <= 1.0, "{errors:?}");
    });
}

/// With prepasses that only Bevy can render, its prepass draws all meshes.
#[test]
fn what_only_the_prepass_can_do_is_left_to_it() {
    in_own_process(|| {
        let case = Case::new(
            "normal_prepass",
            |s| still_and_moving(s, (MotionVectorPrepass, NormalPrepass)),
            move_all,
        );
        let (errors, _) = Case {
            resolves: false,
            ..case
        }
        .measure();
        assert_eq!(errors.unequal, 0, "{errors:?}");
    });
}

#[test]
#[ignore = "nightly: combines a prepass that is kept and occlusion culling"]
fn culling_by_the_prepass_is_left_to_it() {
    in_own_process(|| {
        if !culls_what_is_hidden(&build(SIZE, |_| {})) {
            return;
        }
        // Without a depth copy the second phase of culling cannot be told from the first. Bevy reads a depth of unknown age, so its own
        // culling may be a frame late, depending on driver and timing.
        let unequal = [false, true].map(|culls_forward| {
            let mut make = culled(|| MotionVectorPrepass, culls_forward);
            let case = Case::new(
                "culling_without_depth",
                |s| {
                    make(s);
                    // Bevy's culling reads it, but requests that only with a `DepthPrepass`.
                    let mut cameras = s.world().query::<&mut Camera3d>();
                    let mut camera = cameras.single_mut(s.world()).expect("one camera");
                    camera.depth_texture_usages =
                        (TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING).into();
                },
                uncover,
            );
            let (errors, _) = Case {
                resolves: false,
                ..case
            }
            .measure();
            errors.unequal
        });
        assert!(
            unequal.contains(&0),
            "neither what is to be seen nor what Bevy's culling shows: {unequal:?} pixels"
        );
    });
}
