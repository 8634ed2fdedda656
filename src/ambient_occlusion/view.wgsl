// What the passes of ambient occlusion know of a view.
#define_import_path bevy_lean_deferred::ambient_occlusion::view

/// Pixels count from the viewport's corner.
struct OcclusionView {
    /// From (pixel x, pixel y, depth, 1) to view space, homogeneous.
    view_from_pixel: mat4x4<f32>,
    view_from_world: mat4x4<f32>,
    /// 1 / view-space distance is `edge.x * depth + edge.y`; its square times `edge.z` is the step in depth that
    /// separates surfaces.
    edge: vec4<f32>,
    /// Extinction of distance fog: a, b of its mode; alpha; mode.
    fog: vec4<f32>,
    /// Cosine and sine of how far the directions of each phase are turned; and of how much further with a wide filter, in each block of
    /// texels.
    rotations: array<vec4<f32>, 4>,
    /// The same of the angle between a slice and the next.
    slice_rotation: vec2<f32>,
    /// From one to the next whole `reconstruction::position::ray_at`.
    pixels_per_ray: vec2<f32>,
    /// The radius at a distance of one metre; in orthographic views anywhere. Negative along axes that the projection mirrors.
    radius_in_pixels: vec2<f32>,
    viewport_origin: vec2<u32>,
    viewport_size: vec2<u32>,
    /// Texels of the occlusion texture.
    texture_size: vec2<u32>,
    /// Metres.
    radius: f32,
    /// 1 / the distance at which it has as many pixels as it may.
    largest_nearness: f32,
    intensity: f32,
    sin_bias: f32,
    inverse_falloff: f32,
    /// Samples weigh less by the square of this times their distance, where the radius is what it should be. Above 0.
    decline: f32,
    thickness: f32,
    /// How far direct light is darkened too, 0 to 1.
    direct_light_affect: f32,
    /// The part of the pattern's steps that changes from frame to frame, 0 to 1; 0 without TAA.
    turn: f32,
    row_stride: u32,
    /// Of `OcclusionQuality::Custom`; those of the presets are compiled in.
    slices: u32,
    steps: u32,
}
