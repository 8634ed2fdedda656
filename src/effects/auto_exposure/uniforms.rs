//! Uniforms of a view, and the state that the shaders keep.

use bevy::{prelude::*, render::render_resource::ShaderType};

use super::{
    key::tile_height,
    settings::{LeanAutoExposure, MeteringPattern},
};

/// Points of a compensation curve that are used.
const CURVE_POINTS: usize = 16;
/// Upper bound of the target and of speeds. Above it, differences and products could be NaN.
const LARGEST: f32 = 65504.0;
/// The largest exposure and compensation, in stops.
const LARGEST_STOPS: f32 = 64.0;

/// Uniform of the passes: settings and viewport.
#[derive(ShaderType, Reflect, Clone, Copy, Debug, Default)]
#[reflect(no_auto_register)]
pub struct ExposureUniform {
    viewport_origin: UVec2,
    viewport_size: UVec2,
    seconds: f32,
    log_target: f32,
    compensation: f32,
    min_exposure: f32,
    max_exposure: f32,
    speed_brighten: f32,
    speed_darken: f32,
    transition: f32,
    trim_low: f32,
    trim_high: f32,
    spot_radius: f32,
    instant: u32,
    cuts: u32,
    curve_points: u32,
    tile_height: u32,
    curve: [Vec4; CURVE_POINTS],
}

impl ExposureUniform {
    /// Derives the uniform from `settings` and the viewport, `seconds` after the last frame. `cuts` counts camera cuts.
    pub fn new(
        settings: &LeanAutoExposure,
        viewport_origin: UVec2,
        viewport_size: UVec2,
        seconds: f32,
        cuts: u32,
    ) -> Self {
        let default = LeanAutoExposure::default();
        let stops = |value, default| number(value, default).clamp(-LARGEST_STOPS, LARGEST_STOPS);
        let positive = |value, default| number(value, default).clamp(0.0, LARGEST);
        let share = |value| number(value, 0.0).clamp(0.0, 1.0);

        let mut curve = [Vec4::ZERO; CURVE_POINTS];
        for (slot, point) in curve.iter_mut().zip(&settings.compensation_curve) {
            *slot = Vec4::new(stops(point.x, 0.0), stops(point.y, 0.0), 0.0, 0.0);
        }
        let max_exposure = stops(*settings.range.end(), *default.range.end());
        Self {
            viewport_origin,
            viewport_size,
            seconds: positive(seconds, 0.0),
            log_target: positive(settings.target, default.target).max(1e-6).log2(),
            compensation: stops(settings.compensation, default.compensation),
            min_exposure: stops(*settings.range.start(), *default.range.start()).min(max_exposure),
            max_exposure,
            speed_brighten: positive(settings.speed_brighten, default.speed_brighten),
            speed_darken: positive(settings.speed_darken, default.speed_darken),
            transition: positive(settings.advanced.transition, default.advanced.transition),
            trim_low: settings.trim.map_or(0.0, |trim| share(trim.low)),
            trim_high: settings.trim.map_or(0.0, |trim| share(trim.high)),
            spot_radius: match settings.pattern {
                MeteringPattern::Spot { radius } => positive(radius, 0.0),
                _ => 0.0,
            },
            instant: settings.advanced.instant.into(),
            cuts,
            curve_points: settings.compensation_curve.len().min(CURVE_POINTS) as u32,
            tile_height: tile_height(viewport_size),
            curve,
        }
    }
}

/// `value`, or `default` for NaN.
fn number(value: f32, default: f32) -> f32 {
    if value.is_nan() { default } else { value }
}

/// GPU state of a camera, kept across frames and read back.
#[derive(ShaderType, Reflect, Clone, Copy, Debug, Default)]
#[reflect(no_auto_register)]
pub struct ExposureState {
    /// Metered luminance, before exposure.
    pub luminance: f32,
    /// In stops.
    pub exposure: f32,
    /// In stops.
    pub target_exposure: f32,
    /// Camera cuts seen, plus one; 0 before the first frame. The highest bit is set while no frame since has shown light.
    pub cuts_seen: u32,
}
