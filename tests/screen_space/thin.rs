//! Diffuse GI of things about a pixel wide, at half resolution.

use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;
use kit::{
    analytic_light::{camera, look_at_once, see, surface},
    headless::Headless,
    lean::show,
    own_process::in_own_process,
};

use super::scenes::{SMALL, gi, move_cameras, with_motion};

/// Distance of the bars in metres.
const DISTANCE: f32 = 2.0;
const FRAMES: usize = 10;
/// Rows of the bars.
const ROWS: core::ops::Range<u32> = 56..72;

/// Metres per pixel at the bars.
fn pixel() -> f32 {
    2.0 * DISTANCE * (core::f32::consts::FRAC_PI_8).tan() / SMALL.y as f32
}

/// White bars, 1.2 pixels wide, above a glowing floor in front of them; behind them is nothing, or a dim slope that faces up.
fn bars(headless: &mut Headless, resolution: LeanResolution, before_slope: bool, motion: bool) {
    show(headless, |s| {
        if before_slope {
            let place =
                Transform::from_xyz(0.0, 0.0, -8.0).with_rotation(Quat::from_rotation_x(-1.1));
            s.mesh(Rectangle::new(30.0, 30.0), surface(0.9, 0.0), place);
        }
        let floor = Plane3d::default().mesh().size(4.0, 1.5);
        let place = Transform::from_xyz(0.0, -0.25, -DISTANCE + 0.75);
        s.mesh(floor, surface(0.0, 1.0), place);
        for i in -8..=8 {
            let bar = Cuboid::new(1.2 * pixel(), 0.4, 0.01);
            // All parts of a texel.
            let place = Transform::from_xyz(0.131 * i as f32, 0.0, -DISTANCE);
            s.mesh(bar, surface(0.9, 0.0), place);
        }
        let gi = LeanScreenSpaceGi { resolution, ..gi() };
        let camera = camera(s, Transform::default(), 0.0, gi);
        let mut of_camera = s.world().entity_mut(camera);
        let mut camera = of_camera.get_mut::<Camera>().expect("it is one");
        camera.clear_color = ClearColorConfig::Custom(Color::BLACK);
        with_motion(motion, &mut of_camera);
    });
}

/// Light of each column of the bars, in each frame of a walk to the side.
fn walk(headless: &mut Headless) -> Vec<Vec<f32>> {
    see(headless, 8);
    let frames = (0..FRAMES).map(|_| {
        move_cameras(headless, 0.3 * pixel() * Vec3::X);
        let seen = look_at_once(headless);
        let light = |x, y| seen.at(UVec2::new(x, y));
        let columns = (0..SMALL.x).map(|x| ROWS.map(|y| light(x, y)).sum::<f32>());
        columns.collect()
    });
    frames.collect()
}

#[test]
fn thin_things_keep_their_light_at_half_resolution() {
    in_own_process(|| check(false));
}

#[test]
#[ignore = "nightly: the same with motion vectors"]
fn thin_things_keep_their_light_with_motion_vectors() {
    in_own_process(|| check(true));
}

fn check(motion: bool) {
    let mut headless = Headless::new(SMALL);
    for before_slope in [false, true] {
        let [half, full] = [LeanResolution::Half, LeanResolution::Full].map(|resolution| {
            bars(&mut headless, resolution, before_slope, motion);
            walk(&mut headless)
        });
        let brightest = full.iter().flatten().copied().fold(0.0, f32::max);
        let (mut dark, mut lit, mut bright) = (0, 0, 0);
        for (half, full) in half.iter().flatten().zip(full.iter().flatten()) {
            let is_bar = *full > 0.1 * brightest;
            lit += u32::from(is_bar);
            dark += u32::from(is_bar && *half < 0.25 * full);
            // The slope beside a bar has none of the bar's light.
            bright += u32::from(*full < 0.03 * brightest && *half > 0.1 * brightest);
        }
        println!(
            "before a slope {before_slope}: {dark} of {lit} columns are dark, {bright} others are bright"
        );
        assert!(lit > 200 && dark == 0 && bright == 0);
    }
}
