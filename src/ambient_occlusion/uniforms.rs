//! What the shaders know of a view.

use core::f32::consts::{FRAC_PI_2, PI};

use bevy::{
    pbr::{DistanceFog, FogFalloff},
    prelude::*,
    render::render_resource::ShaderType,
};

use super::settings::LeanAmbientOcclusion;
use crate::shader_library::{
    reconstruction::position::{
        ProjectionKind, pixels_per_metre, pixels_per_ray, projection_of, view_from_pixel,
    },
    tiles,
};

/// The largest radius on screen, as a share of the viewport's height: what lies further apart is too few samples for a
/// smooth picture, and too far apart in memory for a fast one.
const LARGEST_RADIUS: f32 = 0.25;
/// Larger than any screen.
const LARGEST_METRES: f32 = 1e9;
/// Steps in depth of this share of the radius separate surfaces.
const EDGE: f32 = 0.1;

/// What the passes know of a view.
#[derive(ShaderType, Reflect, Clone, Copy, Debug, Default)]
#[reflect(no_auto_register)]
pub struct OcclusionView {
    view_from_pixel: Mat4,
    pub(super) view_from_world: Mat4,
    edge: Vec4,
    pub(super) fog: Vec4,
    rotations: [Vec4; 4],
    slice_rotation: Vec2,
    pixels_per_ray: Vec2,
    radius_in_pixels: Vec2,
    /// Pixels.
    pub viewport_origin: UVec2,
    viewport_size: UVec2,
    /// Texels of the occlusion texture.
    pub texture_size: UVec2,
    radius: f32,
    largest_nearness: f32,
    intensity: f32,
    sin_bias: f32,
    inverse_falloff: f32,
    decline: f32,
    thickness: f32,
    direct_light_affect: f32,
    turn: f32,
    pub(super) row_stride: u32,
    slices: u32,
    steps: u32,
}

impl OcclusionView {
    /// What `settings` make of a view with the matrix `clip_from_view`, `viewport_size` pixels large. The rest stays 0.
    pub fn new(
        settings: &LeanAmbientOcclusion,
        clip_from_view: Mat4,
        viewport_size: UVec2,
    ) -> Self {
        let view_from_pixel = view_from_pixel(clip_from_view, viewport_size);
        // So that its size in pixels is finite.
        let radius = up_to(LARGEST_METRES, settings.radius);

        // In perspective depth / distance² is constant: a step of metres is one of 1/distance there.
        let m = &view_from_pixel;
        let step = EDGE * radius;
        let (slices, steps) = settings.quality.samples();
        let edge = if projection_of(clip_from_view) == ProjectionKind::Orthographic {
            Vec4::new(0.0, 1.0, step / m.z_axis.z.abs(), 0.0)
        } else {
            Vec4::new(m.z_axis.w, m.w_axis.w, step / m.z_axis.w.abs(), 0.0)
        };
        let radius_in_pixels = radius * pixels_per_metre(clip_from_view, viewport_size);
        let largest_radius = (LARGEST_RADIUS * viewport_size.y as f32).max(1.0);
        // So that 0 is a hard edge, but no division by it.
        let inverse_falloff = 1.0 / settings.falloff.clamp(1e-4, 1.0);
        let mut view = Self {
            view_from_pixel,
            edge,
            slice_rotation: Vec2::from_angle(PI / slices as f32),
            pixels_per_ray: pixels_per_ray(view_from_pixel),
            radius_in_pixels,
            viewport_size,
            texture_size: texture_size(settings, viewport_size),
            radius,
            largest_nearness: up_to(
                f32::MAX,
                largest_radius / radius_in_pixels.abs().max_element(),
            ),
            intensity: up_to(f32::MAX, settings.intensity),
            sin_bias: settings.bias.clamp(0.0, FRAC_PI_2).sin(),
            inverse_falloff,
            // Divided by; a pixel whose radius is 0 is not looked at.
            decline: (inverse_falloff.sqrt() / radius).clamp(1e-15, 1e15),
            thickness: settings.thickness.clamp(0.0, 1.0),
            direct_light_affect: settings.direct_light_affect.clamp(0.0, 1.0),
            row_stride: 1,
            slices,
            steps,
            ..default()
        };
        view.set_turn(0.0);
        view
    }

    /// The part of the pattern that changes from frame to frame, 0 to 1.
    pub(super) fn set_turn(&mut self, turn: f32) {
        self.turn = turn;
        for (i, rotation) in self.rotations.iter_mut().enumerate() {
            let quarter = 0.25 * PI / self.slices as f32;
            let phase = Vec2::from_angle(quarter * (i as f32 + turn));
            let block = Vec2::from_angle(quarter * 0.25 * i as f32);
            *rotation = phase.extend(block.x).extend(block.y);
        }
    }
}

/// `x` within 0 and `largest`; 0 for what is not a number.
fn up_to(largest: f32, x: f32) -> f32 {
    if x > 0.0 { x.min(largest) } else { 0.0 }
}

/// Texels of the occlusion texture.
fn texture_size(settings: &LeanAmbientOcclusion, viewport_size: UVec2) -> UVec2 {
    let divisor = settings.resolution.divisor();
    // Viewports may be empty.
    viewport_size.map(|side| side.div_ceil(divisor).max(1))
}

/// Of the gather: each finds four tiles of `texture_size` texels.
pub(super) fn workgroups(texture_size: UVec2) -> UVec2 {
    tiles::count(texture_size.map(|side| side.div_ceil(2)))
}

/// As `OcclusionView::fog`. What attenuates channels differently counts with their mean.
pub(super) fn fog_parameters(fog: Option<&DistanceFog>) -> Vec4 {
    let Some(fog) = fog else {
        return Vec4::ZERO;
    };
    let alpha = fog.color.alpha();
    match &fog.falloff {
        FogFalloff::Linear { start, end } => Vec4::new(*start, *end, alpha, 1.0),
        FogFalloff::Exponential { density } => Vec4::new(*density, 0.0, alpha, 2.0),
        FogFalloff::ExponentialSquared { density } => Vec4::new(*density, 0.0, alpha, 3.0),
        FogFalloff::Atmospheric { extinction, .. } => {
            Vec4::new(extinction.element_sum() / 3.0, 0.0, alpha, 2.0)
        }
    }
}
