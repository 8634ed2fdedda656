// The bindings of the crate's own when it lights a mesh of Bevy's passes, beside those of Bevy.
#define_import_path bevy_lean_deferred::lighting::forward::bindings

#ifdef LIGHT_LAYERS
#import bevy_lean_deferred::lighting::bindings::LightLayersTable
#endif

#ifdef FORWARD_REFLECTIONS
#import bevy_lean_deferred::distance_fog::FogUniform
#endif

#ifdef LIGHT_LAYERS
@group(4) @binding(0) var<storage> light_layers: LightLayersTable;
#endif

#ifdef FORWARD_REFLECTIONS
/// The view for rays of forward meshes. Pixel coordinates are relative to the viewport's corner.
struct ForwardReflectionUniform {
    /// From view space to (pixel x, pixel y, depth, 1), homogeneous.
    pixel_from_view: mat4x4<f32>,
    view_from_world: mat4x4<f32>,
    /// From view space to (pixel x, pixel y, depth, 1) of the last frame, homogeneous.
    last_pixel_from_view: mat4x4<f32>,
    /// Its dot product with a homogeneous view-space position is the distance along the last frame's view direction.
    last_distance: vec4<f32>,
    /// Distance fog in this frame's picture, and in the last one's.
    fog: FogUniform,
    /// Size of the texture of the history's first level, which may be larger than the last frame's viewport.
    history_size: vec2<f32>,
    /// Size of the viewport in the last frame.
    last_viewport_size: vec2<f32>,
    viewport_size: vec2<u32>,
    /// Most steps of a ray.
    steps: u32,
    /// 1 if all view rays are parallel.
    is_orthographic: u32,
    /// Pixels per metre at a distance of one metre; in orthographic views, at any distance.
    pixels_per_metre: f32,
    /// Metres that separate surfaces one pixel apart, at a distance of one metre; in orthographic views, at any distance.
    edge_metres: f32,
    /// Unit of distances in the history.
    metres_per_unit: f32,
    /// Assumed thickness of surfaces, in metres.
    thickness: f32,
    /// Distance from the edge of the picture over which reflections fade, in pixels.
    edge_fade: f32,
    /// Perceptual roughness from which on there are no reflections.
    max_roughness: f32,
    /// Factor of the confidence.
    intensity: f32,
    /// This frame's exposure divided by that of the last one; 0 without a last frame, and while there is no hi-z.
    exposure_ratio: f32,
}

@group(4) @binding(1) var<uniform> reflections: ForwardReflectionUniform;
/// Nearest and furthest depth of cells of pixels in this frame, packed.
@group(4) @binding(2) var hi_z_texture: texture_2d<u32>;
/// Last frame: light, and distance in alpha, in a unit of its own.
@group(4) @binding(3) var history_texture: texture_2d<f32>;
@group(4) @binding(4) var history_sampler: sampler;
#endif
