//! With two-phase occlusion culling, a lean camera shows meshes in the very frame in which they become visible.

use bevy::{
    core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass},
    prelude::*,
    render::occlusion_culling::OcclusionCulling,
};
use kit::{
    headless::{Headless, Picture},
    lean::{active_lean_views, build, judge_film, report, set_lean},
    metrics::pixel_difference,
    own_process::in_own_process,
    scenes::LEAST_PSNR,
    skipped::culls_what_is_hidden,
};

const SIZE: UVec2 = UVec2::new(320, 240);
const FRAMES: usize = 24;

#[derive(Component)]
struct Wall;

/// A room with a wall that hides its back, where there are G-buffer meshes and a forward one.
fn room(camera: impl Bundle) -> Headless {
    build(SIZE, |s| {
        s.floor();
        s.sun(true);
        let wall = s.mesh(
            Cuboid::new(8.0, 4.0, 0.2),
            Color::srgb(0.6, 0.55, 0.5),
            Transform::from_translation(WALL),
        );
        s.world().entity_mut(wall).insert(Wall);
        for i in 0..12 {
            let (column, row) = ((i % 4) as f32, (i / 4) as f32);
            let cube = Cuboid::from_length(0.5);
            let ball = Sphere::new(0.3).mesh().uv(24, 16);
            let mesh: Mesh = if i % 2 == 0 { cube.into() } else { ball };
            s.mesh(
                mesh,
                StandardMaterial {
                    base_color: Color::hsl(i as f32 * 30.0, 0.8, 0.5),
                    emissive: if i == 5 {
                        LinearRgba::rgb(0.0, 0.4, 0.4)
                    } else {
                        LinearRgba::BLACK
                    },
                    alpha_mode: if i % 3 == 0 {
                        AlphaMode::Mask(0.5)
                    } else {
                        AlphaMode::Opaque
                    },
                    ..default()
                },
                Transform::from_xyz(column * 1.1 - 1.6, 0.3 + row * 0.7, -1.5 - row * 0.6),
            );
        }
        s.camera(camera_at(0.0), camera);
    })
}

const WALL: Vec3 = Vec3::new(0.0, 2.0, 0.0);

fn camera_at(x: f32) -> Transform {
    Transform::from_xyz(x, 1.6, 5.0).looking_at(Vec3::new(0.0, 1.0, -1.0), Vec3::Y)
}

/// Sets the wall and the camera of each frame.
fn set_in_motion(world: &mut World, frame: usize) {
    let wall = match frame {
        // Removed at once, back at once, then sliding aside.
        4..8 => Vec3::new(30.0, 2.0, 0.0),
        10..15 => WALL + Vec3::X * (frame - 9) as f32 * 1.2,
        _ => WALL,
    };
    let camera = match frame {
        // Around the edge of the wall, then a cut to behind it.
        15..20 => camera_at((frame - 14) as f32 * 1.5),
        20..22 => {
            Transform::from_xyz(1.0, 2.5, -6.0).looking_at(Vec3::new(0.0, 0.5, -1.0), Vec3::Y)
        }
        _ => camera_at(0.0),
    };
    let mut walls = world.query_filtered::<&mut Transform, With<Wall>>();
    walls.single_mut(world).expect("one wall").translation = wall;
    let mut cameras = world.query_filtered::<&mut Transform, With<Camera3d>>();
    *cameras.single_mut(world).expect("one camera") = camera;
}

/// The pictures of the whole motion.
fn film(headless: &mut Headless) -> Vec<Picture> {
    set_in_motion(headless.world(), 0);
    headless.settle();
    headless.film(FRAMES, set_in_motion)
}

/// Films forward without culling, then lean with it.
fn compare(name: &str, prepasses: impl Bundle) {
    let mut headless = room(prepasses);
    if !culls_what_is_hidden(&headless) {
        return;
    }
    let forward = film(&mut headless);

    let world = headless.world();
    let mut cameras = world.query_filtered::<Entity, With<Camera3d>>();
    let camera = cameras.single(world).expect("one camera");
    world.entity_mut(camera).insert(OcclusionCulling);
    set_lean(&mut headless, true);
    let lean = film(&mut headless);
    assert_eq!(active_lean_views(&mut headless), 1);
    let hidden = pixel_difference(&forward[3], &forward[4]).psnr;
    assert!(hidden < 30.0, "the wall hides nothing");

    report(judge_film(name, &forward, &lean, LEAST_PSNR));
}

#[test]
fn what_comes_into_sight_is_shown() {
    in_own_process(|| {
        compare("uncovered", DepthPrepass);
    });
}

/// With motion vectors Bevy's prepass draws the meshes too, also in two phases.
#[test]
#[ignore = "nightly: combines culling and motion vectors"]
fn what_comes_into_sight_is_shown_with_motion_vectors() {
    in_own_process(|| {
        compare("uncovered_motion", (DepthPrepass, MotionVectorPrepass));
    });
}
