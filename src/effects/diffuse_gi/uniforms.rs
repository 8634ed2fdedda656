//! Uniforms of a view.

use core::f32::consts::FRAC_PI_2;

use bevy::{prelude::*, render::render_resource::ShaderType};

use super::settings::LeanScreenSpaceGi;
use crate::{
    effects::{
        history_validity::LastFrame,
        reprojection::{exposure_ratio, last_pixel_from_view, may_carry_surfaces, up_to},
        resolution,
    },
    shader_library::{
        distance_fog::FogUniform,
        reconstruction::position::{
            ProjectionKind, edge_of, pixels_per_metre, pixels_per_ray, projection_of,
            view_from_pixel,
        },
    },
};

/// Largest radius on screen, as a share of the viewport's height.
const LARGEST_RADIUS: f32 = 0.5;
/// Share of its distance by which a surface with a motion vector may come nearer, or move away, in a frame on its own: at 60 frames
/// per second, 7.5 m/s at 4 m.
const APPROACH: f32 = 1.0 / 32.0;
/// The same in orthographic views, in metres: 7.5 m/s.
const APPROACH_METRES: f32 = 0.125;
/// Upper bound of the radius, in metres.
const LARGEST_METRES: f32 = 1e9;

/// Uniform of the passes, one per view.
#[derive(ShaderType, Reflect, Clone, Copy, Debug, Default)]
#[reflect(no_auto_register)]
pub struct GiUniform {
    view_from_pixel: Mat4,
    view_from_world: Mat4,
    last_pixel_from_view: Mat4,
    pub(super) fog: FogUniform,
    pixels_per_metre: Vec2,
    pixels_per_ray: Vec2,
    edge: Vec2,
    approach: Vec2,
    viewport_origin: UVec2,
    pub(super) viewport_size: UVec2,
    last_viewport_size: UVec2,
    pub(super) texture_size: UVec2,
    pub(super) last_texture_size: UVec2,
    pub(super) divisor: i32,
    pub(super) last_divisor: i32,
    radius: f32,
    largest_radius_in_pixels: f32,
    inverse_falloff: f32,
    sin_bias: f32,
    intensity: f32,
    exposure_ratio: f32,
    pub(super) turn: f32,
    pub(super) has_motion: u32,
    carries_surfaces: u32,
}

impl GiUniform {
    /// Derives the uniform from `settings`, for the frame `now` after the `last` one.
    pub fn new(settings: &LeanScreenSpaceGi, now: &LastFrame, last: Option<&LastFrame>) -> Self {
        let clip_from_view = now.clip_from_view;
        let size = now.viewport.size();
        let view_from_pixel = view_from_pixel(clip_from_view, size);
        let divisor = settings.resolution.divisor();
        let texture_size = resolution::texels(size, divisor);
        Self {
            view_from_pixel,
            view_from_world: now.world_from_view.inverse(),
            last_pixel_from_view: last
                .map_or(Mat4::IDENTITY, |last| last_pixel_from_view(now, last)),
            fog: FogUniform::default(),
            pixels_per_metre: pixels_per_metre(clip_from_view, size),
            pixels_per_ray: pixels_per_ray(view_from_pixel),
            edge: edge_of(clip_from_view, size),
            approach: approach_of(clip_from_view),
            viewport_origin: now.viewport.min,
            viewport_size: size,
            last_viewport_size: last.map_or(size, |last| last.viewport.size()),
            texture_size,
            last_texture_size: texture_size,
            divisor: divisor as i32,
            last_divisor: divisor as i32,
            radius: up_to(LARGEST_METRES, settings.radius),
            largest_radius_in_pixels: (LARGEST_RADIUS * size.y as f32).max(1.0),
            // At least 1e-4, so that 0 is a hard edge without a division by 0.
            inverse_falloff: 1.0 / settings.advanced.falloff.clamp(1e-4, 1.0),
            sin_bias: settings.advanced.bias.clamp(0.0, FRAC_PI_2).sin(),
            intensity: up_to(1.0, settings.intensity),
            exposure_ratio: exposure_ratio(now, last),
            turn: 0.0,
            has_motion: 0,
            carries_surfaces: last
                .is_some_and(|last| may_carry_surfaces(now, last))
                .into(),
        }
    }
}

/// x and y such that `x * depth + y` is the depth step of a surface that comes nearer by [`APPROACH`].
fn approach_of(clip_from_view: Mat4) -> Vec2 {
    let z = clip_from_view.z_axis.z;
    if projection_of(clip_from_view) == ProjectionKind::Orthographic {
        Vec2::new(0.0, APPROACH_METRES * z.abs())
    } else {
        // Depth plus this is inverse to distance.
        Vec2::new(APPROACH, APPROACH * z)
    }
}
