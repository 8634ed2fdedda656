// View uniform of the ambient occlusion passes.
#define_import_path bevy_lean_deferred::effects::ambient_occlusion::view

/// Pixel coordinates are relative to the viewport's corner.
struct OcclusionUniform {
    /// From (pixel x, pixel y, depth, 1) to view space, homogeneous.
    view_from_pixel: mat4x4<f32>,
    view_from_world: mat4x4<f32>,
    /// 1 / view-space distance is `edge.x * depth + edge.y`. Its square times `edge.z` is the depth step that separates surfaces.
    edge: vec4<f32>,
    /// Extinction of distance fog: parameters a and b of its mode, alpha, mode; 0 without fog.
    fog: vec4<f32>,
    /// Cosine and sine of the rotation of each phase's directions (xy), and, with a wide filter, of the further rotation in each
    /// block of texels (zw).
    rotations: array<vec4<f32>, 4>,
    /// Cosine and sine of the angle between a slice and the next.
    slice_rotation: vec2<f32>,
    /// Pixels per unit of `reconstruction::position::ray_at`.
    pixels_per_ray: vec2<f32>,
    /// Radius at a distance of one metre; in orthographic views, at any distance. Negative along axes that the projection mirrors.
    radius_in_pixels: vec2<f32>,
    viewport_origin: vec2<u32>,
    viewport_size: vec2<u32>,
    /// Size of the occlusion texture in texels.
    texture_size: vec2<u32>,
    /// Side of a texel in pixels.
    divisor: u32,
    /// 1 if directions are spread over 4×4 texels, for a wide filter; otherwise over 2×2.
    has_wide_pattern: u32,
    /// In metres.
    radius: f32,
    /// 1 / the distance below which the projected radius is clamped.
    largest_nearness: f32,
    intensity: f32,
    sin_bias: f32,
    inverse_falloff: f32,
    /// A sample's weight falls by the square of this times its distance, where the radius is not clamped. Above 0.
    decline: f32,
    /// Binary logarithm of the factor by which horizons sink behind a thin occluder, over the radius: 0 or more.
    decay: f32,
    /// Temporal part of the step pattern, 0 to 1; 0 without TAA.
    turn: f32,
}
