//! Times of each renderer, and the numbers of lights.

use core::fmt::Write;

use bevy::{diagnostic::DiagnosticsStore, prelude::*};
use bevy_lean_deferred::LeanStatus;

use kit::{example::gpu_times, renderer::Renderer};

/// Frames after a change whose GPU times do not count: they are of frames before it, or of frames in which shaders
/// still compile and lists of lights still grow.
const LATE_FRAMES: usize = 8;

/// Frames until there is a time.
pub const FRAMES: usize = LATE_FRAMES + 4;

/// GPU times in milliseconds, means of the frames since the last change.
#[derive(Clone, Copy)]
struct Measured {
    lights: u32,
    all: f64,
    lighting: Option<f64>,
}

/// The latest times of each renderer.
#[derive(Resource, Default)]
pub struct GpuTimes {
    measured: [Option<Measured>; Renderer::ALL.len()],
    frames_since_change: usize,
    /// Lights of the frame before.
    lights: u32,
}

pub fn measure(
    renderer: Res<Renderer>,
    lights: Query<(), With<PointLight>>,
    status: Query<&LeanStatus>,
    mut diagnostics: ResMut<DiagnosticsStore>,
    mut times: ResMut<GpuTimes>,
) {
    let is_waiting =
        *renderer == Renderer::Lean && status.iter().any(|status| !status.deferred.is_on());
    let lights = lights.iter().len() as u32;
    let has_other_lights = core::mem::replace(&mut times.lights, lights) != lights;
    if renderer.is_changed() || has_other_lights || is_waiting {
        times.frames_since_change = 0;
    }
    times.frames_since_change += 1;
    if times.frames_since_change <= LATE_FRAMES {
        gpu_times::forget(&mut diagnostics);
        return;
    }
    let (geometry, lighting) = renderer.spans();
    let Some(geometry) = gpu_times::mean(&diagnostics, geometry) else {
        return;
    };
    // Bevy's forward pass has no lighting stage of its own.
    let lighting = lighting.and_then(|span| gpu_times::mean(&diagnostics, span));
    times.measured[*renderer as usize] = Some(Measured {
        lights,
        all: geometry + lighting.unwrap_or(0.0),
        lighting,
    });
}

impl GpuTimes {
    /// A line for each renderer, with a mark at the active one.
    pub fn table(&self, on: Renderer) -> String {
        let mut table = String::new();
        for (key, renderer) in (1..).zip(Renderer::ALL) {
            let mark = if renderer == on { '>' } else { ' ' };
            let _ = write!(table, "{mark} {key} {:<13}  ", renderer.name());
            let _ = match self.measured[renderer as usize] {
                None => writeln!(table, "    -"),
                Some(Measured {
                    lights,
                    all,
                    lighting,
                }) => {
                    let lighting = lighting.map_or(String::new(), |time| {
                        format!(", lighting alone {time:.3} ms")
                    });
                    writeln!(table, "{lights:>5} lights: {all:8.3} ms{lighting}")
                }
            };
        }
        table
    }
}
