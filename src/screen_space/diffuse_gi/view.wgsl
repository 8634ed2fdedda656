// What the passes of diffuse GI know of a view.
#define_import_path bevy_lean_deferred::screen_space::diffuse_gi::view

/// Pixels count from the viewport's corner. A texel stands for a square of pixels, and has the depth of its first one.
struct GiView {
    /// From (pixel x, pixel y, depth, 1) to view space, homogeneous.
    view_from_pixel: mat4x4<f32>,
    view_from_world: mat4x4<f32>,
    /// From view space to (pixel x, pixel y, depth, 1) of the last frame, homogeneous.
    last_pixel_from_view: mat4x4<f32>,
    /// At a distance of one metre; in orthographic views anywhere. Negative along axes that the projection mirrors.
    pixels_per_metre: vec2<f32>,
    /// From one to the next whole `reconstruction::position::ray_at`.
    pixels_per_ray: vec2<f32>,
    /// The step in depth that separates surfaces a pixel apart is `edge.x * depth + edge.y`.
    edge: vec2<f32>,
    viewport_origin: vec2<u32>,
    viewport_size: vec2<u32>,
    /// Texels of the viewport.
    texture_size: vec2<u32>,
    /// Metres.
    radius: f32,
    largest_radius_in_pixels: f32,
    inverse_falloff: f32,
    sin_bias: f32,
    intensity: f32,
    /// This frame's exposure over that of the last one; 0 without a last frame.
    exposure_ratio: f32,
    /// What of the pattern's turn changes from frame to frame, 0 to 1; 0 without TAA.
    turn: f32,
    row_stride: u32,
    /// 1 if `motion_texture` has the motion of each pixel. Not a shader definition: motion comes and goes with what averages
    /// frames, and must not leave the view without light while shaders compile.
    has_motion: u32,
}
