//! Renders the same scene on a forward and on a lean camera, with a part of it drawn by a crate of others, and compares.
//!
//! `sh lab/compat/run.sh` builds and runs it, and prints a table.

mod crates;

use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;
use kit::{
    headless::{Headless, Picture, small_shadow_maps},
    lean::{active_lean_views, change_cameras, set_lean},
    metrics::{Difference, pixel_difference},
    scenes::SceneBuilder,
};

const SIZE: UVec2 = UVec2::new(480, 270);
/// Frames until particles fly and chunks are meshed.
const WARM_UP: usize = 60;

fn main() {
    let crates = crates::all();
    let Some(name) = std::env::args().nth(1) else {
        crates.iter().for_each(|(name, _)| println!("{name}"));
        return;
    };
    let (_, tried) = crates.iter().find(|(each, _)| *each == name).expect(&name);

    let bare = {
        let mut headless = Headless::new(SIZE);
        spawn_scene(&mut headless);
        picture(&mut headless)
    };
    let mut headless = Headless::with(SIZE, |app| {
        small_shadow_maps(app);
        (tried.plugins)(app);
    });
    spawn_scene(&mut headless);
    (tried.spawn)(&mut SceneBuilder {
        headless: &mut headless,
    });
    headless.frames(WARM_UP);
    // Whatever moves stops, so that pictures can be compared.
    headless.world().resource_mut::<Time<Virtual>>().pause();

    let forward = picture(&mut headless);
    set_lean(&mut headless, true);
    let lean = picture(&mut headless);
    let was_lean = active_lean_views(&mut headless) == 1;
    // All effects, and back.
    change_cameras(&mut headless, |camera| LeanPreset::High.apply_to(camera));
    headless.settle();
    change_cameras(&mut headless, |camera| {
        camera.remove::<(
            LeanScreenSpaceGi,
            LeanScreenSpaceReflections,
            LeanSubsurfaceScattering,
        )>();
    });
    set_lean(&mut headless, false);
    let back = picture(&mut headless);

    if let Some(folder) = std::env::var_os("PARITY_PICTURES") {
        let folder = std::path::Path::new(&folder);
        for (kind, picture) in [("forward", &forward), ("lean", &lean), ("back", &back)] {
            picture.save(folder.join(format!("{name}_{kind}.png")));
        }
    }
    let shown = changed(&bare, &forward);
    let Difference { psnr, largest, .. } = pixel_difference(&forward, &lean);
    let verdict = match (was_lean, shown > 0.0) {
        (false, _) => "not lean",
        (_, false) => "shows nothing",
        _ => "yes",
    };
    let back = match changed(&forward, &back) {
        0.0 => "to the bit".into(),
        share => format!("{:.2}% of pixels differ", 100.0 * share),
    };
    println!(
        "| {verdict} | {:.1}% | {psnr:.1} | {largest} | {back} |",
        100.0 * shown
    );
}

/// A floor, five solids, a lamp and the sun.
fn spawn_scene(headless: &mut Headless) {
    let mut scene = SceneBuilder { headless };
    scene.default_camera(crates::camera());
    scene.solids();
    scene.sun(true);
    scene.spawn((
        PointLight {
            intensity: 200_000.0,
            ..default()
        },
        Transform::from_xyz(-2.0, 2.5, 2.0),
    ));
}

fn picture(headless: &mut Headless) -> Picture {
    headless.settle();
    headless.frames(4);
    headless.capture()
}

/// The share of pixels that differ.
fn changed(a: &Picture, b: &Picture) -> f64 {
    let pairs = a.rgba.chunks(4).zip(b.rgba.chunks(4));
    let differing = pairs.filter(|(a, b)| a != b).count();
    differing as f64 / (a.rgba.len() / 4) as f64
}
