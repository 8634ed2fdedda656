//! Uniforms of a view.

use bevy::{prelude::*, render::render_resource::ShaderType};

use super::settings::LeanScreenSpaceReflections;
use crate::{
    effects::{
        history::units_per_metre,
        history_validity::LastFrame,
        reprojection::{
            exposure_ratio, last_distance, last_pixel_from_view, may_carry_surfaces, pixels_of,
            up_to,
        },
        resolution,
    },
    shader_library::{
        distance_fog::FogUniform,
        reconstruction::position::{
            ProjectionKind, STEEPEST, edge_of, pixels_per_metre, projection_of, view_from_pixel,
        },
    },
};

/// Upper bound of the thickness, in metres.
const LARGEST_METRES: f32 = 1e6;

/// Uniform of the passes, one per view.
#[derive(ShaderType, Reflect, Clone, Copy, Debug, Default)]
#[reflect(no_auto_register)]
pub struct ReflectionUniform {
    view_from_pixel: Mat4,
    pixel_from_view: Mat4,
    view_from_world: Mat4,
    last_pixel_from_view: Mat4,
    last_distance: Vec4,
    pub(super) fog: FogUniform,
    pixels_per_metre: Vec2,
    edge: Vec2,
    behind: Vec2,
    pub(super) history_size: Vec2,
    last_viewport_size: Vec2,
    viewport_origin: UVec2,
    pub(super) viewport_size: UVec2,
    pub(super) texture_size: UVec2,
    divisor: i32,
    smooth_steps: u32,
    rough_segments: u32,
    shortest_segment: f32,
    growth: f32,
    edge_metres: f32,
    metres_per_unit: f32,
    thickness: f32,
    edge_fade: f32,
    max_roughness: f32,
    intensity: f32,
    exposure_ratio: f32,
    pub(super) turn: f32,
    pub(super) phase: u32,
    pub(super) has_lobes: u32,
    pub(super) has_motion: u32,
    pub(super) has_specialization: u32,
    pub(super) shows_hits: u32,
    carries_surfaces: u32,
}

impl ReflectionUniform {
    /// Derives the uniform from `settings`, for the frame `now` after the `last` one, with texels of `divisor` pixels per side.
    pub fn new(
        settings: &LeanScreenSpaceReflections,
        divisor: u32,
        now: &LastFrame,
        last: Option<&LastFrame>,
    ) -> Self {
        let clip_from_view = now.clip_from_view;
        let size = now.viewport.size();
        let thickness = up_to(LARGEST_METRES, settings.thickness);
        let marches = settings.marches(divisor);
        let pixels_per_metre = pixels_per_metre(clip_from_view, size);
        Self {
            view_from_pixel: view_from_pixel(clip_from_view, size),
            pixel_from_view: pixels_of(now),
            view_from_world: now.world_from_view.inverse(),
            last_pixel_from_view: last
                .map_or(Mat4::IDENTITY, |last| last_pixel_from_view(now, last)),
            last_distance: last.map_or(Vec4::ZERO, |last| last_distance(now, last)),
            fog: FogUniform::default(),
            pixels_per_metre,
            edge: edge_of(clip_from_view, size),
            behind: behind_of(clip_from_view, thickness),
            history_size: Vec2::ONE,
            last_viewport_size: last.map_or(size, |last| last.viewport.size()).as_vec2(),
            viewport_origin: now.viewport.min,
            viewport_size: size,
            texture_size: resolution::texels(size, divisor),
            divisor: divisor as i32,
            smooth_steps: marches.smooth_steps,
            rough_segments: marches.rough_segments,
            shortest_segment: marches.shortest_segment,
            growth: marches.growth,
            edge_metres: STEEPEST / pixels_per_metre.y.abs(),
            metres_per_unit: last.map_or(1.0, |last| 1.0 / units_per_metre(last.clip_from_view)),
            thickness,
            edge_fade: up_to(0.5, settings.advanced.edge_fade) * size.y as f32,
            max_roughness: up_to(1.25, settings.max_roughness),
            intensity: up_to(1.0, settings.intensity),
            exposure_ratio: exposure_ratio(now, last),
            turn: 0.0,
            phase: 0,
            has_lobes: 0,
            has_motion: 0,
            has_specialization: 0,
            shows_hits: 0,
            carries_surfaces: last
                .is_some_and(|last| may_carry_surfaces(now, last))
                .into(),
        }
    }
}

/// Coefficients x and y for the depth that is `metres` behind a depth: in orthographic views depth - x, otherwise
/// y + q / (1 + xq) with q = depth - y.
fn behind_of(clip_from_view: Mat4, metres: f32) -> Vec2 {
    let [z, w] = [clip_from_view.z_axis.z, clip_from_view.w_axis.z];
    if projection_of(clip_from_view) == ProjectionKind::Orthographic {
        Vec2::new(metres * z.abs(), 0.0)
    } else {
        Vec2::new(metres / w.abs().max(1e-12), -z)
    }
}
