//! Pictures of `--headless`, and the differences between lean and forward.

use bevy::prelude::*;
use bevy_lean_deferred::LeanDebugView;

use crate::{
    cameras::{Shown, Side},
    grid,
    rows::ROWS,
};
use kit::{
    example::{run, text_panel::TextPanel},
    headless::{Headless, Picture},
    metrics::{Difference, difference},
};

/// Writes a PNG. If it has lean beside forward, prints their differences, in total and for each row.
pub fn write_pictures(mut headless: Headless, path: &str, frames: usize) -> AppExit {
    if let Err(exit) = run::make_ready(&mut headless) {
        return exit;
    }
    headless.frames(frames);
    let picture = headless.capture();
    if let Err(error) = picture.try_save(path) {
        eprintln!("error: cannot write {path}: {error}");
        return AppExit::error();
    }
    println!("{path}: {}×{}", picture.size.x, picture.size.y);
    if compares(headless.world()) {
        compare(&mut headless, &picture);
    }
    AppExit::Success
}

/// True if both halves of the picture should look the same.
fn compares(world: &mut World) -> bool {
    let mut unlike = world.query_filtered::<(), Or<(With<LeanDebugView>, With<TextPanel>)>>();
    *world.resource::<Shown>() == Shown::Both && unlike.iter(world).next().is_none()
}

fn compare(headless: &mut Headless, picture: &Picture) {
    let size = UVec2::new(picture.size.x / 2, picture.size.y);
    let half = |x: u32| {
        picture.crop(URect::from_corners(
            UVec2::new(x, 0),
            UVec2::new(x, 0) + size,
        ))
    };
    let [lean, forward] = [0, picture.size.x - size.x].map(half);
    let print = |name: &str, difference: Difference| println!("{name:12} {difference}");
    print("all", difference(&forward, &lean));
    let bands = bands(headless);
    for (row, [top, bottom]) in ROWS.iter().zip(bands) {
        let top = (top.max(0.0) as u32).min(size.y);
        let bottom = (bottom.max(0.0) as u32).clamp(top, size.y);
        let band = URect::new(0, top, size.x, bottom);
        let [forward, lean] = [&forward, &lean].map(|half| half.crop(band));
        if !lean.rgba.is_empty() {
            print(row.name, difference(&forward, &lean));
        }
    }
}

/// Top and bottom of each row in the picture.
fn bands(headless: &mut Headless) -> Vec<[f32; 2]> {
    let world = headless.world();
    let mut cameras = world.query::<(&Side, &Camera, &GlobalTransform)>();
    let Some((_, camera, place)) = cameras.iter(world).find(|(side, ..)| **side == Side::Left)
    else {
        return Vec::new();
    };
    let height = |y: f32| {
        let place = camera.world_to_viewport(place, Vec3::Y * y);
        place.map_or(0.0, |place| place.y)
    };
    (0..ROWS.len())
        .map(|row| {
            let y = grid::row_height(row);
            [height(y + 0.5), height(y - 0.5)]
        })
        .collect()
}
