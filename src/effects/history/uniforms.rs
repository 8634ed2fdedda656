//! Uniforms of a view.

use bevy::{prelude::*, render::render_resource::ShaderType};

use super::distance::units_per_metre;
use crate::{
    effects::history_validity::LastFrame, shader_library::reconstruction::position::view_from_pixel,
};

/// Uniform of the passes, one per view.
#[derive(ShaderType, Reflect, Clone, Copy, Debug, Default)]
#[reflect(no_auto_register)]
pub struct HistoryUniform {
    view_from_pixel: Mat4,
    viewport_origin: UVec2,
    viewport_size: UVec2,
    units_per_metre: f32,
}

impl HistoryUniform {
    /// Derives the uniform of the frame `now`.
    pub(super) fn new(now: &LastFrame) -> Self {
        let size = now.viewport.size();
        Self {
            view_from_pixel: view_from_pixel(now.clip_from_view, size),
            viewport_origin: now.viewport.min,
            viewport_size: size,
            units_per_metre: units_per_metre(now.clip_from_view),
        }
    }
}
