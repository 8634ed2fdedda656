//! What the shaders know of a view, and the state that they keep.

use bevy::{
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{
            Buffer, BufferDescriptor, BufferUsages, DynamicUniformBuffer, ShaderType,
        },
        renderer::{RenderDevice, RenderQueue},
        view::ViewTarget,
    },
};

use super::{
    ExposureKey, LeanAutoExposure, MeteringPattern,
    pipelines::ViewExposurePipelines,
    state::{ExposureCuts, ExposureHistory},
};

/// Points of a compensation curve that count.
const CURVE_POINTS: usize = 16;
/// The largest target and speed: with any more, differences and products might not be numbers.
const LARGEST: f32 = 65504.0;
/// The largest exposure and compensation, in stops.
const LARGEST_STOPS: f32 = 64.0;

/// Twin of the struct of the same name in `view.wgsl`.
#[derive(ShaderType, Clone, Copy, Debug, Default)]
pub struct ExposureView {
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
    curve: [Vec4; CURVE_POINTS],
}

impl ExposureView {
    /// What `settings` make of a viewport in a frame that follows the last one after `seconds`.
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
        let max_exposure = stops(settings.max_exposure, default.max_exposure);
        Self {
            viewport_origin,
            viewport_size,
            seconds: positive(seconds, 0.0),
            log_target: positive(settings.target, default.target).max(1e-6).log2(),
            compensation: stops(settings.compensation, default.compensation),
            min_exposure: stops(settings.min_exposure, default.min_exposure).min(max_exposure),
            max_exposure,
            speed_brighten: positive(settings.speed_brighten, default.speed_brighten),
            speed_darken: positive(settings.speed_darken, default.speed_darken),
            transition: positive(settings.transition, default.transition),
            trim_low: settings.trim.map_or(0.0, |trim| share(trim.low)),
            trim_high: settings.trim.map_or(0.0, |trim| share(trim.high)),
            spot_radius: match settings.pattern {
                MeteringPattern::Spot { radius } => positive(radius, 0.0),
                _ => 0.0,
            },
            instant: settings.instant.into(),
            cuts,
            curve_points: settings.compensation_curve.len().min(CURVE_POINTS) as u32,
            curve,
        }
    }
}

/// `value`, or `default` if it is not a number.
fn number(value: f32, default: f32) -> f32 {
    if value.is_nan() { default } else { value }
}

/// Kept from frame to frame, and read back. Twin of the struct of the same name in `view.wgsl`.
#[derive(ShaderType, Clone, Copy, Debug, Default)]
pub struct ExposureState {
    /// As metered, before the exposure.
    pub luminance: f32,
    /// In stops.
    pub exposure: f32,
    /// In stops.
    pub target_exposure: f32,
    /// Camera cuts seen, plus one; 0 before the first frame.
    pub cuts_seen: u32,
}

/// The uniforms of all views.
#[derive(Resource, Default)]
pub(super) struct ExposureUniforms(pub(super) DynamicUniformBuffer<ExposureView>);

/// On a view with auto exposure: where its uniform is, and its buffers between the passes.
#[derive(Component)]
pub struct ViewExposure {
    pub(super) offset: u32,
    pub(super) workgroups: UVec2,
    /// What the first pass leaves for the second: partial sums, or the histogram.
    pub(super) sums: Buffer,
    is_histogram: bool,
}

impl ViewExposure {
    fn new(device: &RenderDevice, key: ExposureKey, viewport_size: UVec2) -> Self {
        Self {
            offset: 0,
            workgroups: UVec2::ZERO,
            sums: device.create_buffer(&BufferDescriptor {
                label: Some("lean_deferred/exposure/sums"),
                size: key.sums_size(viewport_size),
                usage: BufferUsages::STORAGE,
                mapped_at_creation: false,
            }),
            is_histogram: key.has_histogram(),
        }
    }

    /// Whether the buffer is what the shaders of `key` expect.
    fn fits(&self, key: ExposureKey, viewport_size: UVec2) -> bool {
        self.sums.size() == key.sums_size(viewport_size) && self.is_histogram == key.has_histogram()
    }
}

/// Fills [`ExposureUniforms`], and makes the buffers where there are none that fit.
pub(super) fn write_exposure_uniforms(
    mut commands: Commands,
    mut uniforms: ResMut<ExposureUniforms>,
    (device, queue, time): (Res<RenderDevice>, Res<RenderQueue>, Res<Time>),
    mut views: Query<(
        Entity,
        &LeanAutoExposure,
        &ExtractedCamera,
        &ExposureCuts,
        &ViewExposurePipelines,
        &ViewTarget,
        &mut ExposureHistory,
        Option<&mut ViewExposure>,
    )>,
) {
    let Some(mut writer) = uniforms.0.get_writer(views.iter().len(), &device, &queue) else {
        return;
    };
    for (entity, settings, camera, cuts, pipelines, target, mut history, view) in &mut views {
        let key = pipelines.key;
        let (origin, size) = match &camera.viewport {
            Some(viewport) => (viewport.physical_position, viewport.physical_size),
            None => {
                // Not as the camera has it, which may lag behind a target that is resized or replaced.
                let picture = target.main_texture();
                (UVec2::ZERO, UVec2::new(picture.width(), picture.height()))
            }
        };
        let mut new = None;
        let view = match view {
            Some(view) => view.into_inner(),
            None => new.insert(ViewExposure::new(&device, key, size)),
        };
        if !view.fits(key, size) {
            *view = ViewExposure::new(&device, key, size);
        }
        let now = time.elapsed_secs_f64();
        let seconds = (now - history.rendered) as f32;
        history.rendered = now;
        view.offset = writer.write(&ExposureView::new(settings, origin, size, seconds, cuts.0));
        view.workgroups = key.workgroups(size);
        if let Some(new) = new {
            commands.entity(entity).insert(new);
        }
    }
}
