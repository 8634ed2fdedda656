// View uniform of the diffuse GI passes.
#define_import_path bevy_lean_deferred::effects::diffuse_gi::view

#import bevy_lean_deferred::distance_fog::FogUniform

/// Pixel coordinates are relative to the viewport's corner. A texel covers a square of pixels, and shows one of them.
struct GiUniform {
    /// From (pixel x, pixel y, depth, 1) to view space, homogeneous.
    view_from_pixel: mat4x4<f32>,
    view_from_world: mat4x4<f32>,
    /// From view space to (pixel x, pixel y, depth, 1) of the last frame, homogeneous.
    last_pixel_from_view: mat4x4<f32>,
    /// Distance fog in the picture.
    fog: FogUniform,
    /// Value at a distance of one metre; in orthographic views, at any distance. Negative along axes that the projection mirrors.
    pixels_per_metre: vec2<f32>,
    /// Pixels per unit of `reconstruction::position::ray_at`.
    pixels_per_ray: vec2<f32>,
    /// `edge.x * depth + edge.y` is the depth step that separates surfaces one pixel apart.
    edge: vec2<f32>,
    /// `approach.x * depth + approach.y` is the depth step by which a surface may come nearer, or move away, in a frame on its own.
    approach: vec2<f32>,
    viewport_origin: vec2<u32>,
    viewport_size: vec2<u32>,
    /// Size of the viewport in the last frame.
    last_viewport_size: vec2<u32>,
    /// Size of the viewport in texels.
    texture_size: vec2<u32>,
    /// The same in the last frame.
    last_texture_size: vec2<u32>,
    /// Side of a texel in pixels: 1 or 2.
    divisor: i32,
    /// The same in the last frame.
    last_divisor: i32,
    /// In metres.
    radius: f32,
    largest_radius_in_pixels: f32,
    inverse_falloff: f32,
    sin_bias: f32,
    intensity: f32,
    /// This frame's exposure divided by that of the last one; 0 without a last frame.
    exposure_ratio: f32,
    /// Temporal part of the pattern's rotation, 0 to 1; 0 without TAA.
    turn: f32,
    /// 1 if `motion_texture` has the motion of each pixel. Not a shader definition: motion is toggled with effects that average
    /// frames, and compiling shaders would leave the view without light meanwhile.
    has_motion: u32,
    /// 1 if the camera moved, so that surfaces may have moved with it. Without motion vectors these are looked for in place.
    carries_surfaces: u32,
}
