//! A lean camera in a level in which features come and go one at a time. The bench `stutter` measures the same walk.
//!
//! In processes of their own: many frames, and compilation is delayed in all of the process. Software drivers keep gigabytes for the
//! pipelines of the whole walk, so that the daily test walks past a few of its features.

use bevy::{core_pipeline::prepass::MotionVectorPrepass, prelude::*};
use kit::{
    headless::Picture,
    log_watch,
    metrics::pixel_difference,
    own_process::in_own_process,
    renderer::Renderer,
    skipped::skips_without_binding_arrays,
    stalled_pipelines::StalledPipelines,
    walk::{Event, FEATURES, Walk},
};

const SIZE: UVec2 = UVec2::new(96, 64);

/// Features that do not change the picture of a lean camera by themselves: there is no shadow to filter, Bevy draws no sprite on cameras
/// for meshes, and the camera has no effects.
const UNSEEN: [&str; 4] = [
    "shadow filter",
    "sprite",
    "quality of effects",
    "resolution of effects",
];

/// Features that Bevy draws with binding arrays only.
const IN_BINDING_ARRAYS: [&str; 2] = ["decal", "reflection probe"];

fn settled(walk: &mut Walk) -> Picture {
    walk.headless.settle();
    walk.headless.capture()
}

/// The walk shows what it claims to, and its end is its beginning.
#[test]
#[ignore = "nightly: all features"]
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
            let may_be_unseen = UNSEEN.contains(&name)
                || IN_BINDING_ARRAYS.contains(&name)
                    && skips_without_binding_arrays(walk.headless.device(), name);
            assert!(is_seen || may_be_unseen, "{name} is not seen");
            walk.apply(Event::Goes(index));
            let after = settled(&mut walk);
            let psnr = pixel_difference(&before, &after).psnr;
            println!("{name}: {psnr:.1} dB from the picture before it");
            assert!(psnr > 60.0, "{name} leaves {psnr:.1} dB");
        }
        log_watch::assert_validation_layer_silent();
    });
}

/// Features of the daily test, each of which asks more of history. `no_stutter.rs` has lights and materials.
const DAILY: [&str; 3] = ["fog", "TAA", "resize"];

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

/// Delays compilation after each of the events, and calls `look` with the number of each frame from it on.
fn hold_back(walk: &mut Walk, events: Vec<Event>, mut look: impl FnMut(&mut Walk, Event, usize)) {
    for event in events {
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

fn check_lean(walk: &mut Walk, event: Event, frame: usize) {
    assert!(walk.is_lean(), "{}, frame {frame}", event.name());
}

/// A mesh that comes may wait for its own pipeline; it makes no other mesh wait.
fn check_waiting(walk: &mut Walk, event: Event, frame: usize) {
    // With motion vectors, the ball may wait for its target when it rolls on: it rests while the app settles.
    let camera = walk.camera;
    let may_wait = matches!(event, Event::Comes(_))
        || (walk.headless.world().get::<MotionVectorPrepass>(camera)).is_some();
    let most = usize::from(may_wait);
    let waiting = walk.waiting_meshes();
    let name = event.name();
    assert!(waiting <= most, "{name}, frame {frame}: {waiting} meshes");
}

/// GI and reflections lose their history in the frame of a resize or cut, and in no other.
#[derive(Default)]
struct History {
    lost: usize,
}

impl History {
    fn check(&mut self, walk: &mut Walk, event: Event, frame: usize) {
        if frame == 0 {
            self.lost = 0;
        }
        self.lost += usize::from(!walk.follows_last_frame());
        let most = usize::from(matches!(event.feature(), "resize" | "cut"));
        let (name, lost) = (event.name(), self.lost);
        assert!(lost <= most, "{name}, frame {frame}: {lost} frames lost");
    }
}

/// A lean camera with effects stays lean and keeps its history while pipelines compile for features that come or go.
#[test]
fn a_few_features_come_and_go() {
    in_own_process(|| {
        let events = Event::of(&DAILY);
        let mut walk = begin(true);
        assert!(walk.follows_last_frame(), "the bare level");
        let mut history = History::default();
        hold_back(&mut walk, events, |walk, event, frame| {
            check_lean(walk, event, frame);
            check_waiting(walk, event, frame);
            history.check(walk, event, frame);
        });
        log_watch::assert_validation_layer_silent();
    });
}

#[test]
#[ignore = "nightly: all features"]
fn features_come_and_go_without_a_forward_frame() {
    in_own_process(|| {
        let mut walk = begin(false);
        hold_back(&mut walk, Event::all(), |walk, event, frame| {
            check_lean(walk, event, frame);
            check_waiting(walk, event, frame);
        });
        log_watch::assert_validation_layer_silent();
    });
}

#[test]
#[ignore = "nightly: all features"]
fn history_outlives_all_features() {
    in_own_process(|| {
        let mut walk = begin(true);
        let mut history = History::default();
        hold_back(&mut walk, Event::all(), |walk, event, frame| {
            history.check(walk, event, frame);
        });
        log_watch::assert_validation_layer_silent();
    });
}
