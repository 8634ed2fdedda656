//! Uniforms of a view.

use bevy::{prelude::*, render::render_resource::ShaderType};

use super::settings::{LARGEST_RADIUS, LeanSubsurfaceScattering};
use crate::{
    effects::{history_validity::LastFrame, reprojection::up_to},
    shader_library::reconstruction::position::pixels_per_metre,
};

/// Uniform of the passes, one per view and pass.
#[derive(ShaderType, Reflect, Clone, Copy, Debug, Default)]
#[reflect(no_auto_register)]
pub struct SubsurfaceUniform {
    view_from_world: Mat4,
    center: Vec2,
    pixels_per_metre: Vec2,
    viewport_origin: UVec2,
    viewport_size: UVec2,
    blocks: UVec2,
    level: u32,
    largest_radius: f32,
    is_orthographic: u32,
}

impl SubsurfaceUniform {
    /// Derives the uniform from `settings` for a pass that writes `level`, in a view with `blocks` blocks of tiles.
    pub fn new(
        settings: &LeanSubsurfaceScattering,
        now: &LastFrame,
        blocks: UVec2,
        level: u32,
    ) -> Self {
        let size = now.viewport.size();
        let ahead = now.clip_from_view * Vec4::new(0.0, 0.0, -1.0, 1.0);
        let ndc = Vec2::new(ahead.x, ahead.y) / ahead.w;
        Self {
            view_from_world: now.world_from_view.inverse(),
            center: (0.5 + ndc * Vec2::new(0.5, -0.5)) * size.as_vec2(),
            pixels_per_metre: pixels_per_metre(now.clip_from_view, size) * Vec2::new(1.0, -1.0),
            viewport_origin: now.viewport.min,
            viewport_size: size,
            blocks,
            level,
            largest_radius: up_to(LARGEST_RADIUS, settings.advanced.largest_radius),
            is_orthographic: now.is_orthographic().into(),
        }
    }
}
