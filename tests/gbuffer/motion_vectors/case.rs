//! Films of motion vectors, forward against lean.

use bevy::prelude::*;
use bevy_lean_deferred::{gbuffer::GBufferTargets, view::ActiveLeanView};
use kit::{
    headless::{Headless, small_shadow_maps},
    lean::set_lean,
    log_watch,
    scenes::SceneBuilder,
};

use super::{SIZE, active_view, align, probe};

/// Changes the world before each frame.
pub type Script = fn(&mut World, usize);

/// Motion vectors and view of a frame.
pub struct Frame {
    pub motions: Vec<Vec2>,
    pub view: Option<ActiveLeanView>,
}

impl Frame {
    pub fn has_motion_target(&self) -> bool {
        (self.view).is_some_and(|view| view.targets.contains(GBufferTargets::MOTION))
    }
}

pub fn film(headless: &mut Headless, frames: usize, script: Script) -> Vec<Frame> {
    (0..frames)
        .map(|frame| {
            script(headless.world(), frame);
            headless.frames(1);
            Frame {
                motions: probe::read(headless),
                view: active_view(headless),
            }
        })
        .collect()
}

/// Differences of motion vectors, in pixels.
#[derive(Default, Debug)]
pub struct Errors {
    pub largest: f32,
    pub rms: f64,
    /// Largest difference relative to [`inexactness`].
    pub largest_share: f32,
    /// Longest motion.
    pub longest: f32,
    /// Pixels that are not bitwise equal.
    pub unequal: usize,
}

pub fn errors(forward: &[Frame], lean: &[Frame]) -> Errors {
    let mut errors = Errors::default();
    let mut sum = 0.0;
    let mut count = 0;
    for (forward, lean) in forward.iter().zip(lean) {
        for (a, b) in forward.motions.iter().zip(&lean.motions) {
            let length = (*a * SIZE.as_vec2()).length();
            let error = ((*a - *b) * SIZE.as_vec2()).length();
            assert!(!error.is_nan(), "a motion is not a number: {a}, {b}");
            errors.largest = errors.largest.max(error);
            errors.largest_share = errors.largest_share.max(error / inexactness(length));
            errors.longest = errors.longest.max(length);
            errors.unequal += usize::from(a != b);
            sum += f64::from(error).powi(2);
            count += 1;
        }
    }
    errors.rms = (sum / f64::from(count)).sqrt();
    errors
}

/// A scene in motion, to be filmed forward and lean.
pub struct Case<F> {
    pub name: &'static str,
    pub make: F,
    pub script: Script,
    /// Configures the apps.
    pub configure: fn(&mut App),
    pub frames: usize,
    /// True if the G-buffer provides the motion, not Bevy's prepass.
    pub resolves: bool,
}

/// In pixels of 320 × 240. Half floats have steps of 0.0024 pixels between motions of 2.5 and 5 pixels: the renderers mostly differ by one
/// such step, where a motion lies between two of them.
pub const LARGEST: f32 = 0.005;
pub const RMS: f64 = 0.0005;

/// Tolerated difference in pixels after the camera has jumped: a step of half floats; the rounding of positions that GPUs interpolate, as
/// in Bevy, which cancels only between nearby cameras; and, for surfaces beside the former camera, that rounding divided by a w near 0, so
/// that longer motion is less exact.
fn inexactness(motion: f32) -> f32 {
    LARGEST.max(0.001 * motion) + 1e-6 * motion * motion
}

impl<F: FnMut(&mut SceneBuilder)> Case<F> {
    pub fn new(name: &'static str, make: F, script: Script) -> Self {
        Self {
            name,
            make,
            script,
            configure: small_shadow_maps,
            frames: 8,
            resolves: true,
        }
    }

    /// Films forward, then lean with the same script. Returns their differences and the lean frames.
    pub fn measure(mut self) -> (Errors, Vec<Frame>) {
        let [forward, lean] = [false, true].map(|lean| {
            let mut headless = Headless::with(SIZE, self.configure);
            (self.make)(&mut SceneBuilder {
                headless: &mut headless,
            });
            probe::install(&mut headless);
            set_lean(&mut headless, lean);
            align(&mut headless, 4);
            film(&mut headless, self.frames, self.script)
        });
        assert!(forward.iter().all(|frame| frame.view.is_none()));
        for frame in &lean {
            let view = frame.view.expect("lean in each frame");
            assert_eq!(view.resolves_motion, self.resolves, "{view:?}");
            assert_eq!(view.keeps_prepass, !self.resolves, "{view:?}");
        }
        let errors = errors(&forward, &lean);
        println!("{:24} {errors:?}", self.name);
        assert!(errors.longest > 1.0, "{}: nothing moves", self.name);
        log_watch::assert_validation_layer_silent();
        (errors, lean)
    }

    /// As [`measure`](Self::measure), and asserts that the two agree. Returns the frames in which the lean view had a motion target.
    pub fn compare(self) -> Vec<usize> {
        let name = self.name;
        let (errors, lean) = self.measure();
        assert!(
            errors.largest <= LARGEST && errors.rms <= RMS,
            "{name}: {errors:?}"
        );
        (0..lean.len())
            .filter(|&frame| lean[frame].has_motion_target())
            .collect()
    }
}
