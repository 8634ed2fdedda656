//! Cameras with effects in apps that add and remove TAA, split screens, shift worlds, or change nothing.

use bevy::{anti_alias::taa::TemporalAntiAliasing, prelude::*, render::RenderApp};
use bevy_lean_deferred::{
    prelude::*,
    view::{DiffuseLight, OutOfMemory},
};
use kit::{
    analytic_light::{Errors, Seen, look, look_at_once, see, surface},
    analytic_mirrors::metal,
    headless::Headless,
    lean::{build, change_cameras, show},
    own_process::in_own_process,
};

use super::{
    scenes::{SIZE, SMALL, courtyard, gi, move_cameras, reflections, with_motion},
    views::two_views,
};

type Change = fn(&mut EntityWorldMut);

/// A material of which half is diffuse.
fn floor_material() -> StandardMaterial {
    StandardMaterial {
        metallic: 0.5,
        ..metal(0.3)
    }
}

fn off(a: &Seen, b: &Seen) -> Errors {
    let texels = |seen: &Seen| seen.light.texels.clone().into_iter().flatten();
    Errors::of(texels(a).zip(texels(b)).map(|(a, b)| a - b))
}

/// With TAA, which averages frames, sample patterns rotate. Its removal leaves `TemporalJitter` on the camera, and patterns stop.
#[test]
fn patterns_rest_when_taa_goes() {
    in_own_process(|| {
        let effects: [(&str, Change); 2] = [
            ("diffuse GI and reflections", |camera| {
                camera.insert((gi(), reflections()));
            }),
            ("occlusion", |camera| {
                camera.insert(LeanScreenSpaceAmbientOcclusion {
                    radius: 2.0,
                    ..default()
                });
            }),
        ];
        let mut headless = Headless::new(SMALL);
        for (name, insert) in effects {
            show(&mut headless, |s| {
                courtyard(s, floor_material(), surface(0.5, 0.3), 0.4, ());
            });
            change_cameras(&mut headless, |camera| {
                camera.insert(TemporalAntiAliasing::default());
                insert(camera);
            });
            let first = see(&mut headless, 16);
            let turning = off(&first, &look_at_once(&mut headless));
            change_cameras(&mut headless, |camera| {
                camera.remove::<TemporalAntiAliasing>();
            });
            let mut last = see(&mut headless, 32);
            let mut most = 0.0_f32;
            for _ in 0..4 {
                let next = look_at_once(&mut headless);
                most = most.max(off(&last, &next).rmse);
                last = next;
            }
            println!(
                "{name}: with TAA frames are {:.5} apart, then {most:.6}",
                turning.rmse
            );
            assert!(turning.rmse > 1e-3 && most < 1e-5, "{name}");
        }
    });
}

/// The diffuse light of a camera has the size of its viewport, wherever on the target that is.
#[test]
fn diffuse_light_is_as_large_as_the_viewport() {
    in_own_process(|| {
        let mut headless = build(SIZE, |s| {
            two_views(s);
        });
        headless.settle();
        let world = headless.app.sub_app_mut(RenderApp).world_mut();
        let mut textures = world.query::<&DiffuseLight>();
        let sizes = textures
            .iter(world)
            .map(|light| light.texture.texture.size());
        let sizes: Vec<UVec2> = sizes
            .map(|size| UVec2::new(size.width, size.height))
            .collect();
        assert_eq!(sizes, [SIZE / UVec2::new(2, 1); 2]);
    });
}

/// Textures are created in error scopes, which catch that they do not fit: a frame without changes has none.
#[test]
fn frames_at_rest_have_no_error_scopes() {
    in_own_process(|| {
        let effects: [(&str, Change); 2] = [
            ("occlusion and reflections", |camera| {
                camera.insert((LeanScreenSpaceAmbientOcclusion::default(), reflections()));
            }),
            ("diffuse GI", |camera| {
                camera.insert(gi());
            }),
        ];
        for (name, insert) in effects {
            let mut headless = build(SMALL, |s| {
                courtyard(s, floor_material(), surface(0.5, 0.3), 0.4, ());
            });
            change_cameras(&mut headless, insert);
            headless.settle();
            let attempts = |headless: &Headless| {
                let world = headless.app.sub_app(RenderApp).world();
                world.resource::<OutOfMemory>().attempts()
            };
            let before = attempts(&headless);
            headless.frames(10);
            let more = attempts(&headless) - before;
            println!("{name}: {before} error scopes, then {more} in ten frames");
            assert!(before > 0 && more == 0, "{name}");
        }
    });
}

/// Shift of worlds in apps with a floating origin.
const SHIFT: Vec3 = Vec3::new(2048.0, 0.0, -2048.0);

#[test]
fn a_shifted_world_is_no_other_one() {
    in_own_process(|| check_shifted_world(false));
}

#[test]
#[ignore = "nightly: the same with motion vectors"]
fn a_shifted_world_with_motion_vectors_is_no_other_one() {
    in_own_process(|| check_shifted_world(true));
}

/// A world shifted with its cameras looks unchanged: the history is shifted with it.
fn check_shifted_world(motion: bool) {
    let mut headless = build(SMALL, |s| {
        let effects = (gi(), reflections());
        let camera = courtyard(s, floor_material(), surface(0.5, 0.3), 0.4, effects);
        with_motion(motion, &mut s.world().entity_mut(camera));
    });
    see(&mut headless, 24);
    let before = look(&mut headless);
    for (number, shift) in [SHIFT, -SHIFT, SHIFT].into_iter().enumerate() {
        shift_world(&mut headless, shift);
        let frames = [(); 3].map(|()| off(&before, &look_at_once(&mut headless)).psnr());
        println!("motion vectors {motion}: {frames:.1?} dB after a shift by {shift}");
        // The motion target comes with the first mesh that moves: forward draws all of them in that frame.
        let bound = if motion && number == 0 { 35.0 } else { 48.0 };
        assert!(frames.into_iter().all(|psnr| psnr > bound));
        see(&mut headless, 8);
    }
}

fn shift_world(headless: &mut Headless, shift: Vec3) {
    let world = headless.world();
    let mut roots = world.query_filtered::<&mut Transform, Without<ChildOf>>();
    for mut root in roots.iter_mut(world) {
        root.translation += shift;
    }
}

/// A camera that jumps as far on its own shows its new surroundings.
#[test]
fn a_camera_that_jumps_alone_is_no_shift_of_the_world() {
    in_own_process(|| {
        let mut headless = build(SMALL, |s| {
            let effects = (gi(), reflections());
            // Without a sky, whose light would take the place of that of the last frame.
            courtyard(s, floor_material(), surface(0.5, 0.3), 0.0, effects);
            // The same courtyard where the camera jumps to.
            let meshes = s
                .world()
                .query_filtered::<(&Mesh3d, &MeshMaterial3d<StandardMaterial>, &Transform), ()>()
                .iter(s.world())
                .map(|(mesh, material, transform)| {
                    let there = transform.with_translation(transform.translation + SHIFT);
                    (mesh.clone(), material.clone(), there)
                })
                .collect::<Vec<_>>();
            s.world().spawn_batch(meshes);
        });
        see(&mut headless, 24);
        let here = look(&mut headless);
        move_cameras(&mut headless, SHIFT);
        let first = off(&here, &look_at_once(&mut headless));
        let there = see(&mut headless, 24);
        let settled = off(&here, &there);
        println!(
            "after the jump {:.1} dB, then {:.1} dB",
            first.psnr(),
            settled.psnr()
        );
        // The first frame has no light of the last one, which showed another place.
        assert!(first.psnr() < 40.0 && settled.psnr() > 48.0);
    });
}
