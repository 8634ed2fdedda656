//! State that the page shows and tests wait for: frames, their time, pipelines that still compile, the renderer.

use core::sync::atomic::{AtomicU32, Ordering};
use std::sync::Mutex;

use bevy::{
    prelude::*,
    render::{Render, RenderApp, RenderSystems, render_resource::PipelineCache},
};
use bevy_lean_deferred::prelude::*;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::camera::View;

static FRAMES: AtomicU32 = AtomicU32::new(0);
static COMPILING: AtomicU32 = AtomicU32::new(0);
/// Bits of a float.
static MILLISECONDS: AtomicU32 = AtomicU32::new(0);
static RENDERER: Mutex<String> = Mutex::new(String::new());

/// Weight of the newest frame in [`frame_milliseconds`], as a divisor.
const SMOOTHING: f32 = 16.0;

/// Frames since the start.
#[wasm_bindgen]
pub fn frames() -> u32 {
    FRAMES.load(Ordering::Relaxed)
}

/// Time from one frame to the next in milliseconds, smoothed.
#[wasm_bindgen]
pub fn frame_milliseconds() -> f32 {
    f32::from_bits(MILLISECONDS.load(Ordering::Relaxed))
}

/// Number of pipelines that still compile.
#[wasm_bindgen]
pub fn compiling() -> u32 {
    COMPILING.load(Ordering::Relaxed)
}

/// The active renderer: "Bevy forward", or the state of lean rendering.
#[wasm_bindgen]
pub fn renderer() -> String {
    RENDERER.lock().map(|name| name.clone()).unwrap_or_default()
}

pub fn plugin(app: &mut App) {
    app.add_systems(Last, (count_frames, name_renderer));
    if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
        render_app.add_systems(Render, count_pipelines.in_set(RenderSystems::Cleanup));
    }
}

fn count_frames(time: Res<Time<Real>>) {
    let last = frame_milliseconds();
    let this = time.delta_secs() * 1000.0;
    // No smoothing over the first frames, which load everything.
    let mean = if FRAMES.fetch_add(1, Ordering::Relaxed) < 3 {
        this
    } else {
        last + (this - last) / SMOOTHING
    };
    MILLISECONDS.store(mean.to_bits(), Ordering::Relaxed);
}

fn name_renderer(camera: Single<Option<Ref<LeanStatus>>, With<View>>) {
    let deferred = match &*camera {
        Some(status) if status.is_changed() => status.deferred.clone(),
        Some(_) => return,
        None => EffectStatus::Absent,
    };
    let name = match deferred {
        EffectStatus::Absent => "Bevy forward".to_string(),
        EffectStatus::On => "lean".to_string(),
        status => status.to_string(),
    };
    if let Ok(mut renderer) = RENDERER.lock()
        && *renderer != name
    {
        *renderer = name;
    }
}

fn count_pipelines(cache: Res<PipelineCache>) {
    let waiting = cache.waiting_pipelines().count();
    COMPILING.store(waiting as u32, Ordering::Relaxed);
}
