//! The figures of films, on films that are known.

use bevy::prelude::*;
use kit::motion::{
    film::{Shot, Shown, flicker, lag, rmse, trail},
    paths::Path,
};

const FRAMES: usize = 12;

/// A gray picture with the value of each column, 16 rows high.
fn columns(value: impl Fn(u32) -> f32) -> Shown {
    let size = UVec2::new(64, 16);
    let texels = (0..size.element_product()).map(|i| [value(i % size.x); 3]);
    Shown {
        size,
        texels: texels.collect(),
    }
}

/// A white block, 16 columns wide, that moves by two columns a frame.
fn block(frame: usize, column: u32) -> f32 {
    let first = 2 * frame as u32;
    if (first..first + 16).contains(&column) {
        1.0
    } else {
        0.0
    }
}

fn shots<'a>(pictures: &'a [Shown], truths: &'a [Shown]) -> Vec<Shot<'a>> {
    let pairs = pictures.iter().zip(truths);
    let shot = |(picture, truth)| Shot {
        picture,
        rest: truth,
        truth,
    };
    pairs.map(shot).collect()
}

#[test]
fn trails_and_flicker_of_a_moving_block() {
    let truths: Vec<Shown> = (0..FRAMES)
        .map(|frame| columns(|column| block(frame, column)))
        .collect();
    let true_shots = shots(&truths, &truths);
    assert_eq!((trail(&true_shots), flicker(&true_shots)), (0, 0.0));
    // Half of the block's light stays for three frames.
    let trails: Vec<Shown> = (0..FRAMES)
        .map(|frame| {
            columns(|column| {
                let before = (1..=3).map(|age| 0.5 * block(frame.saturating_sub(age), column));
                before.fold(block(frame, column), f32::max)
            })
        })
        .collect();
    let trailing = shots(&trails, &truths);
    assert_eq!(trail(&trailing), 3);
    assert!(flicker(&trailing) > 0.05);
    // An error that does not change is no flicker.
    let dim: Vec<Shown> = (0..FRAMES)
        .map(|frame| columns(|column| 0.25 + block(frame, column)))
        .collect();
    assert!(flicker(&shots(&dim, &truths)) < 1e-6);
    assert!((rmse(&dim[0], &truths[0]) - 0.25).abs() < 1e-6);
}

#[test]
fn lag_of_a_switched_lamp() {
    let [off, on] = [0.0, 1.0].map(|light| columns(|_| light));
    // The lamp itself, in the first column, is on at once.
    let source: Vec<bool> = (0..off.texels.len())
        .map(|i| i.is_multiple_of(64))
        .collect();
    let slow = [0.0, 0.5, 0.8, 0.95, 1.0];
    let slow = slow.map(|light| columns(|column| if column == 0 { 1.0 } else { light }));
    assert_eq!(lag(&slow, &off, &on, &source), 3);
    assert_eq!(lag(&slow[..2], &off, &on, &source), 2);
}

#[test]
fn paths_move_without_jumps() {
    for path in Path::ALL {
        for frame in 1..=48 {
            let [before, now] = [frame - 1, frame].map(|frame| path.pose(frame, 48));
            let moved = before.camera.translation.distance(now.camera.translation);
            let turned = before.camera.rotation.angle_between(now.camera.rotation);
            assert!(moved < 0.1 && turned < 0.1, "{path:?}, frame {frame}");
            let is_lamp_alone = before.camera == now.camera && before.door == now.door;
            assert!(before.lamp == now.lamp || is_lamp_alone, "{path:?}");
        }
    }
}
