// What the passes of subsurface scattering know of a view.
#define_import_path bevy_lean_deferred::screen_space::subsurface::view

/// Pixels count from the viewport's corner.
struct SubsurfaceView {
    /// From (pixel x, pixel y, depth, 1) to view space, homogeneous.
    view_from_pixel: mat4x4<f32>,
    /// The pixel, with fractions, of what is straight ahead.
    center: vec2<f32>,
    /// Of a metre at a distance of one metre; in orthographic views anywhere. Negative along axes that point the other way.
    pixels_per_metre: vec2<f32>,
    viewport_origin: vec2<u32>,
    viewport_size: vec2<u32>,
    /// Pixels from which light comes at most.
    largest_radius: f32,
    /// What of the pattern's turn changes from frame to frame, 0 to 1; 0 without TAA.
    turn: f32,
}
