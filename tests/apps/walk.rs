//! A lean camera in a level in which features come and go one at a time. The bench `stutter` measures the same walk.
//!
//! In processes of their own: many frames, and compilation is delayed in all of the process.

use bevy::{core_pipeline::prepass::MotionVectorPrepass, prelude::*};
use kit::{
    headless::Picture,
    log_watch,
    metrics::pixel_difference,
    own_process::in_own_process,
    renderer::Renderer,
    stalled_pipelines::StalledPipelines,
    walk::{Event, FEATURES, Walk},
};

const SIZE: UVec2 = UVec2::new(96, 64);

/// Features that do not change the picture of a lean camera by themselves: there is no shadow to filter, Bevy draws no decal without binding
/// arrays and no sprite on cameras for meshes, and the camera has no effects.
const UNSEEN: [&str; 5] = [
    "shadow filter",
    "decal",
    "sprite",
    "quality of effects",
    "resolution of effects",
];

fn settled(walk: &mut Walk) -> Picture {
    walk.headless.settle();
    walk.headless.capture()
}

/// The walk shows what it claims to, and its end is its beginning.
#[test]
fn each_feature_is_seen_and_leaves_nothing() {
    in_own_process(|| {
        let mut walk = Walk::new(Renderer::Lean, SIZE, true);
        walk.step();
        let before = settled(&mut walk);
        for (index, feature) in FEATURES.iter().enumerate() {
            let name = feature.name;
            walk.apply(Event::Comes(index));
            let with = settled(&mut walk);
            assert!(walk.is_lean(), "{name}");
            let is_seen = with.size != before.size || pixel_difference(&before, &with).psnr < 55.0;
            assert!(is_seen || UNSEEN.contains(&name), "{name} is not seen");
            walk.apply(Event::Goes(index));
            let after = settled(&mut walk);
            let psnr = pixel_difference(&before, &after).psnr;
            println!("{name}: {psnr:.1} dB from the picture before it");
            assert!(psnr > 60.0, "{name} leaves {psnr:.1} dB");
        }
        log_watch::assert_validation_layer_silent();
    });
}

/// Frames after an event for which compilation is delayed.
const HELD_BACK: usize = 4;

/// Begins a walk of a lean camera whose pipelines compile in the background, and waits until those of the bare level are compiled.
fn begin(has_effects: bool) -> Walk {
    let mut walk = Walk::new(Renderer::Lean, SIZE, false);
    if has_effects {
        walk.add_effects();
    }
    walk.step();
    walk.headless.settle();
    // Bevy waits for the pipeline that brings a camera's picture to its target: that of the HUD has to be there.
    let hud = FEATURES
        .iter()
        .position(|feature| feature.name == "HUD camera");
    let hud = hud.expect("the walk has one");
    for event in [Event::Comes(hud), Event::Goes(hud)] {
        walk.apply(event);
        walk.headless.settle();
    }
    walk.step();
    assert!(walk.is_lean(), "the bare level");
    walk
}

/// Delays compilation after each event of the walk, and calls `look` with the number of each frame from it on.
fn hold_back(walk: &mut Walk, mut look: impl FnMut(&mut Walk, Event, usize)) {
    for event in Event::all() {
        let stalled_pipelines = StalledPipelines::new();
        walk.apply(event);
        for frame in 0..HELD_BACK {
            walk.step();
            look(walk, event, frame);
        }
        drop(stalled_pipelines);
        walk.headless.settle();
        for frame in HELD_BACK..2 * HELD_BACK {
            walk.step();
            look(walk, event, frame);
        }
    }
}

/// A lean camera stays lean while pipelines compile for features that come or go.
#[test]
fn features_come_and_go_without_a_forward_frame() {
    in_own_process(|| {
        let mut walk = begin(false);
        hold_back(&mut walk, |walk, event, frame| {
            assert!(walk.is_lean(), "{}, frame {frame}", event.name());
        });
        log_watch::assert_validation_layer_silent();
    });
}

/// A mesh that comes may wait for its own pipeline; it makes no other mesh wait.
#[test]
fn other_meshes_stay_in_the_gbuffer() {
    in_own_process(|| {
        let mut walk = begin(false);
        hold_back(&mut walk, |walk, event, frame| {
            // With motion vectors, the ball may wait for its target when it rolls on: it rests while the app settles.
            let camera = walk.camera;
            let may_wait = matches!(event, Event::Comes(_))
                || (walk.headless.world().get::<MotionVectorPrepass>(camera)).is_some();
            let most = usize::from(may_wait);
            let waiting = walk.waiting_meshes();
            let name = event.name();
            assert!(waiting <= most, "{name}, frame {frame}: {waiting} meshes");
        });
    });
}

/// GI and reflections lose their history in the frame of a resize or cut, and in no other.
#[test]
fn history_outlives_all_features() {
    in_own_process(|| {
        let mut walk = begin(true);
        assert!(walk.follows_last_frame(), "the bare level");
        let mut lost = 0;
        hold_back(&mut walk, |walk, event, frame| {
            if frame == 0 {
                lost = 0;
            }
            lost += usize::from(!walk.follows_last_frame());
            let most = usize::from(matches!(event.feature(), "resize" | "cut"));
            let name = event.name();
            assert!(lost <= most, "{name}, frame {frame}: {lost} frames lost");
        });
        log_watch::assert_validation_layer_silent();
    });
}
