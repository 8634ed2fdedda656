// View uniform of the subsurface scattering passes.
#define_import_path bevy_lean_deferred::effects::subsurface::view

/// Pixel coordinates are relative to the viewport's corner.
struct SubsurfaceUniform {
    view_from_world: mat4x4<f32>,
    /// Pixel straight ahead of the camera, with fractions.
    center: vec2<f32>,
    /// Value at a distance of one metre; in orthographic views, at any distance. Negative along axes that point the other way.
    pixels_per_metre: vec2<f32>,
    viewport_origin: vec2<u32>,
    viewport_size: vec2<u32>,
    /// Number of blocks of 32×32 pixels in the textures.
    blocks: vec2<u32>,
    /// Finest level that a pass writes. Its texels are 2 to this power pixels wide.
    level: u32,
    /// Largest radius from which light comes, in pixels.
    largest_radius: f32,
    /// 1 if all directions to the viewer are the same.
    is_orthographic: u32,
}
