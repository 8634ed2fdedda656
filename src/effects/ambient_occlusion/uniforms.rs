//! Uniforms of a view.

use core::f32::consts::{FRAC_PI_2, LOG2_E, PI};

use bevy::{
    pbr::{DistanceFog, FogFalloff},
    prelude::*,
    render::render_resource::{ShaderType, TextureView},
};

use super::settings::LeanScreenSpaceAmbientOcclusion;
use crate::{
    shader_library::{
        reconstruction::position::{
            ProjectionKind, pixels_per_metre, pixels_per_ray, projection_of, view_from_pixel,
        },
        tiles,
    },
    view::AmbientOcclusion,
};

/// Largest radius on screen, as a share of the viewport's height. With a larger one, samples would be too sparse for a smooth image.
const LARGEST_RADIUS: f32 = 0.25;
/// Upper bound of the radius, in metres: keeps its size in pixels finite.
const LARGEST_METRES: f32 = 1e9;
/// Depth steps above this share of the radius separate surfaces.
const EDGE: f32 = 0.1;
/// Upper bound of the decay per radius: nothing remains of a horizon after a step.
const FASTEST_DECAY: f32 = 1e9;

/// Uniform of the passes, one per view.
#[derive(ShaderType, Reflect, Clone, Copy, Debug, Default)]
#[reflect(no_auto_register)]
pub struct OcclusionUniform {
    view_from_pixel: Mat4,
    pub(super) view_from_world: Mat4,
    edge: Vec4,
    pub(super) fog: Vec4,
    rotations: [Vec4; 4],
    slice_rotation: Vec2,
    pixels_per_ray: Vec2,
    radius_in_pixels: Vec2,
    /// In pixels.
    pub viewport_origin: UVec2,
    viewport_size: UVec2,
    /// Size of the occlusion texture, in texels.
    pub texture_size: UVec2,
    divisor: u32,
    has_wide_pattern: u32,
    radius: f32,
    largest_nearness: f32,
    intensity: f32,
    sin_bias: f32,
    inverse_falloff: f32,
    decline: f32,
    decay: f32,
    turn: f32,
}

impl OcclusionUniform {
    /// Derives the uniform from `settings`, the projection and the viewport's size in pixels. `view_from_world`, `fog` and
    /// `viewport_origin` stay 0.
    pub fn new(
        settings: &LeanScreenSpaceAmbientOcclusion,
        clip_from_view: Mat4,
        viewport_size: UVec2,
    ) -> Self {
        let view_from_pixel = view_from_pixel(clip_from_view, viewport_size);
        let radius = up_to(LARGEST_METRES, settings.radius);

        // In perspective, 1 / distance is affine in depth: a step in metres is a depth step proportional to 1 / distance².
        let m = &view_from_pixel;
        let step = EDGE * radius;
        let (slices, _) = settings.samples();
        let edge = if projection_of(clip_from_view) == ProjectionKind::Orthographic {
            Vec4::new(0.0, 1.0, step / m.z_axis.z.abs(), 0.0)
        } else {
            Vec4::new(m.z_axis.w, m.w_axis.w, step / m.z_axis.w.abs(), 0.0)
        };
        let radius_in_pixels = radius * pixels_per_metre(clip_from_view, viewport_size);
        let largest_radius = (LARGEST_RADIUS * viewport_size.y as f32).max(1.0);
        // At least 1e-4, so that 0 is a hard edge without a division by 0.
        let inverse_falloff = 1.0 / settings.advanced.falloff.clamp(1e-4, 1.0);
        let mut view = Self {
            view_from_pixel,
            edge,
            pixels_per_ray: pixels_per_ray(view_from_pixel),
            radius_in_pixels,
            viewport_size,
            texture_size: texture_size(settings, viewport_size),
            divisor: settings.resolution.divisor(),
            has_wide_pattern: settings.has_wide_pattern().into(),
            radius,
            largest_nearness: up_to(
                f32::MAX,
                largest_radius / radius_in_pixels.abs().max_element(),
            ),
            intensity: up_to(f32::MAX, settings.intensity),
            sin_bias: settings.advanced.bias.clamp(0.0, FRAC_PI_2).sin(),
            inverse_falloff,
            // A divisor in the shader, which skips pixels with a radius of 0.
            decline: (inverse_falloff.sqrt() / radius).clamp(1e-15, 1e15),
            // 0 / 0 is the bound too.
            decay: settings.thickness.map_or(0.0, |thickness| {
                (LOG2_E * radius / up_to(LARGEST_METRES, thickness)).min(FASTEST_DECAY)
            }),
            ..default()
        };
        view.set_pattern(slices, 0.0);
        view
    }

    /// Inputs of lighting to apply the occlusion in `texture`.
    pub(super) fn for_lighting(
        &self,
        settings: &LeanScreenSpaceAmbientOcclusion,
        texture: TextureView,
    ) -> AmbientOcclusion {
        AmbientOcclusion {
            texture,
            edge: self.edge.truncate(),
            intensity: self.intensity,
            of_direct_light: settings.direct_light.clamp(0.0, 1.0),
            of_baked_light: up_to(1.0, settings.advanced.baked_light),
        }
    }

    /// Sets the directions of `slices`, and the part of the pattern that changes per frame, 0 to 1.
    pub(super) fn set_pattern(&mut self, slices: u32, turn: f32) {
        self.turn = turn;
        let angle = PI / slices.max(1) as f32;
        self.slice_rotation = Vec2::from_angle(angle);
        let quarter = 0.25 * angle;
        for (i, rotation) in self.rotations.iter_mut().enumerate() {
            let phase = Vec2::from_angle(quarter * (i as f32 + turn));
            let block = Vec2::from_angle(quarter * 0.25 * i as f32);
            *rotation = phase.extend(block.x).extend(block.y);
        }
    }
}

/// Clamps `x` to 0..`largest`; NaN becomes 0.
fn up_to(largest: f32, x: f32) -> f32 {
    if x > 0.0 { x.min(largest) } else { 0.0 }
}

/// Size of the occlusion texture, in texels.
fn texture_size(settings: &LeanScreenSpaceAmbientOcclusion, viewport_size: UVec2) -> UVec2 {
    let divisor = settings.resolution.divisor();
    // Viewports may be empty.
    viewport_size.map(|side| side.div_ceil(divisor).max(1))
}

/// Workgroups of the gather. Each covers four tiles of the texture.
pub(super) fn workgroups(texture_size: UVec2) -> UVec2 {
    tiles::count(texture_size.map(|side| side.div_ceil(2)))
}

/// Packs fog as in `OcclusionUniform::fog`. Extinction that differs per channel is averaged.
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
