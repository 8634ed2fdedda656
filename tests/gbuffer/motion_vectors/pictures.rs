//! Pictures of effects that fetch pixels along motion vectors.

use bevy::{
    core_pipeline::prepass::{DepthPrepass, NormalPrepass},
    post_process::motion_blur::MotionBlur,
    prelude::*,
};
use kit::{
    headless::Picture,
    lean::{build, judge, report, set_lean},
    own_process::in_own_process,
    scenes::LEAST_PSNR,
};

use super::{SIZE, align, shift_movers, still_and_moving, taa, turn_camera};

/// Films a scene in which camera and meshes move, after `history` frames at rest.
fn pictures_of(camera: impl Bundle, lean: bool, history: u32) -> Vec<Picture> {
    let mut headless = build(SIZE, |s| still_and_moving(s, camera));
    set_lean(&mut headless, lean);
    align(&mut headless, history);
    headless.film(8, |world, frame| {
        turn_camera(world, frame as f32 * 0.03);
        shift_movers(world, Vec3::new(0.1, 0.04, -0.06));
    })
}

/// Compares pictures whose pixels are fetched along motion vectors: lean against lean with Bevy's motion vectors, and against forward.
/// Forward draws the movers in the first frame of their motion: the view gets its motion target one frame later.
fn compare_pictures<B: Bundle>(name: &str, camera: impl Fn() -> B, history: u32) {
    let films = [
        pictures_of(camera(), false, history),
        pictures_of((camera(), NormalPrepass), true, history),
        pictures_of(camera(), true, history),
    ];
    assert!(films[0][6].rgba != films[0][7].rgba, "nothing moves");
    let judge_frame = |frame: usize| {
        let [forward, bevy, lean] = films.each_ref().map(|film| &film[frame]);
        [
            judge(&format!("{name}_{frame}_motion"), bevy, lean, 50.0),
            judge(&format!("{name}_{frame}"), forward, lean, LEAST_PSNR),
        ]
    };
    report((0..8).flat_map(judge_frame));
}

#[test]
#[ignore = "nightly: long films of vectors that are compared themselves"]
fn temporal_anti_aliasing_pictures() {
    in_own_process(|| {
        compare_pictures("taa", taa, 32);
    });
}

#[test]
fn motion_blur_pictures() {
    in_own_process(|| {
        let blur = || {
            (
                MotionBlur {
                    shutter_angle: 2.0,
                    samples: 4,
                },
                DepthPrepass,
            )
        };
        compare_pictures("motion_blur", blur, 4);
    });
}
