// What the passes of reflections know of a view.
#define_import_path bevy_lean_deferred::screen_space::reflections::view

/// Pixels count from the viewport's corner. A texel stands for a square of pixels, and its ray starts at the first one.
struct ReflectionView {
    /// From (pixel x, pixel y, depth, 1) to view space, homogeneous.
    view_from_pixel: mat4x4<f32>,
    /// From view space to (pixel x, pixel y, depth, 1), homogeneous.
    pixel_from_view: mat4x4<f32>,
    view_from_world: mat4x4<f32>,
    /// From view space to (pixel x, pixel y, depth, 1) of the last frame, homogeneous.
    last_pixel_from_view: mat4x4<f32>,
    /// The distance along the last frame's view direction is the dot product with a homogeneous position in view space.
    last_distance: vec4<f32>,
    /// At a distance of one metre; in orthographic views anywhere. Negative along axes that the projection mirrors.
    pixels_per_metre: vec2<f32>,
    /// The step in depth that separates surfaces a pixel apart is `edge.x * depth + edge.y`.
    edge: vec2<f32>,
    /// How surfaces end behind their front: see `behind`.
    behind: vec2<f32>,
    /// The first level of the history.
    history_size: vec2<f32>,
    viewport_origin: vec2<u32>,
    viewport_size: vec2<u32>,
    /// Texels of the viewport.
    texture_size: vec2<u32>,
    /// Metres that separate surfaces a pixel apart, at a distance of one; in orthographic views anywhere.
    edge_metres: f32,
    /// In the history.
    metres_per_unit: f32,
    /// Metres.
    thickness: f32,
    /// Pixels from the rim over which reflections fade.
    edge_fade: f32,
    /// Perceptual roughness from which on nothing is mirrored.
    max_roughness: f32,
    /// Factor of the confidence.
    intensity: f32,
    /// This frame's exposure over that of the last one; 0 without a last frame.
    exposure_ratio: f32,
    /// What of the pattern changes from frame to frame, 0 to 1; 0 without TAA.
    turn: f32,
    row_stride: u32,
    /// 1 if `motion_texture` has the motion of each pixel. Not a shader definition: motion comes and goes with what averages
    /// frames, and must not leave the view without reflections while shaders compile.
    has_motion: u32,
}
