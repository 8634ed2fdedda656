//! What the shaders know of a view.

use bevy::{prelude::*, render::render_resource::ShaderType};

use super::settings::LeanSubsurfaceScattering;
use crate::{
    screen_space::reprojection::up_to,
    shader_library::reconstruction::position::{pixels_per_metre, view_from_pixel},
};

/// More pixels than any screen has.
const LARGEST_PIXELS: f32 = 65536.0;

/// What the passes know of a view.
#[derive(ShaderType, Reflect, Clone, Copy, Debug, Default)]
#[reflect(no_auto_register)]
pub struct SubsurfaceView {
    pub view_from_pixel: Mat4,
    pub center: Vec2,
    pub pixels_per_metre: Vec2,
    pub viewport_origin: UVec2,
    pub viewport_size: UVec2,
    pub largest_radius: f32,
    pub turn: f32,
}

impl SubsurfaceView {
    /// What `settings` make of a view.
    pub fn new(settings: &LeanSubsurfaceScattering, clip_from_view: Mat4, viewport: URect) -> Self {
        let size = viewport.size();
        let ahead = clip_from_view * Vec4::new(0.0, 0.0, -1.0, 1.0);
        let ndc = ahead.truncate().truncate() / ahead.w;
        Self {
            view_from_pixel: view_from_pixel(clip_from_view, size),
            center: (0.5 + ndc * Vec2::new(0.5, -0.5)) * size.as_vec2(),
            pixels_per_metre: pixels_per_metre(clip_from_view, size) * Vec2::new(1.0, -1.0),
            viewport_origin: viewport.min,
            viewport_size: size,
            largest_radius: up_to(LARGEST_PIXELS, settings.largest_radius),
            turn: 0.0,
        }
    }
}
