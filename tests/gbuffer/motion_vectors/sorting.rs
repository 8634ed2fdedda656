//! Re-sorting of moving meshes.

use bevy::{
    prelude::*,
    render::{RenderApp, camera::DirtySpecializations},
};
use bevy_lean_deferred::gbuffer::SortedMeshes;
use kit::{
    headless::Headless,
    lean::{build, set_lean},
    own_process::in_own_process,
};

use super::{SMALL, shift_movers, still_and_moving, taa};

/// Number of times a mesh was sorted again in `frames` frames; the movers move in frames for which `moves` is true. Bevy must not queue any
/// again.
fn resorts(headless: &mut Headless, frames: usize, moves: impl Fn(usize) -> bool) -> usize {
    let mut count = 0;
    for frame in 0..frames {
        if moves(frame) {
            // Back and forth, within sight.
            let side = if frame % 2 == 0 { 0.1 } else { -0.1 };
            shift_movers(headless.world(), Vec3::X * side);
        }
        headless.frames(1);
        let world = headless.app.sub_app(RenderApp).world();
        let asked_of_bevy = &world.resource::<DirtySpecializations>().changed_renderables;
        assert!(asked_of_bevy.is_empty(), "{asked_of_bevy:?}");
        count += world.resource::<SortedMeshes>().0;
    }
    count
}

/// A mesh is sorted again when it starts to move and after it has stopped, not while it moves or pauses; and the first time once more when
/// the view has the target.
#[test]
#[ignore = "nightly: hundreds of frames for what `sorting` shows in forty"]
fn moving_meshes_are_sorted_once() {
    in_own_process(|| {
        let mut headless = build(SMALL, |s| still_and_moving(s, taa()));
        set_lean(&mut headless, true);
        headless.settle();
        assert_eq!(resorts(&mut headless, 4, |_| false), 0);
        let first = resorts(&mut headless, 50, |_| true);
        assert!(
            (4..=12).contains(&first),
            "two movers, sorted {first} times"
        );
        assert_eq!(resorts(&mut headless, 60, |frame| frame % 8 == 7), 0);
        assert_eq!(resorts(&mut headless, 50, |_| false), 2);
        assert_eq!(resorts(&mut headless, 50, |_| true), 2);
        assert_eq!(resorts(&mut headless, 50, |_| false), 2);
        assert_eq!(resorts(&mut headless, 50, |_| false), 0);
    });
}
