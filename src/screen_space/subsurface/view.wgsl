// What the passes of subsurface scattering know of a view.
#define_import_path bevy_lean_deferred::screen_space::subsurface::view

/// Pixels count from the viewport's corner.
struct SubsurfaceView {
    /// To view space.
    view_from_world: mat4x4<f32>,
    /// The pixel, with fractions, of what is straight ahead.
    center: vec2<f32>,
    /// Of a metre at a distance of one metre; in orthographic views anywhere. Negative along axes that point the other way.
    pixels_per_metre: vec2<f32>,
    viewport_origin: vec2<u32>,
    viewport_size: vec2<u32>,
    /// Of 32×32 pixels, that the textures have.
    blocks: vec2<u32>,
    /// The finest level that a pass writes: its texels are 2 to the power of it pixels wide.
    level: u32,
    /// Pixels from which light comes at most.
    largest_radius: f32,
}
