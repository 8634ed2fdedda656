// View uniform of the reflection passes.
#define_import_path bevy_lean_deferred::effects::reflections::view

#import bevy_lean_deferred::distance_fog::FogUniform

/// Pixel coordinates are relative to the viewport's corner. A texel covers a square of pixels, and its ray starts at the first
/// one, or at one of three others if that does not reflect.
struct ReflectionUniform {
    /// From (pixel x, pixel y, depth, 1) to view space, homogeneous.
    view_from_pixel: mat4x4<f32>,
    /// From view space to (pixel x, pixel y, depth, 1), homogeneous.
    pixel_from_view: mat4x4<f32>,
    view_from_world: mat4x4<f32>,
    /// From view space to (pixel x, pixel y, depth, 1) of the last frame, homogeneous.
    last_pixel_from_view: mat4x4<f32>,
    /// Its dot product with a homogeneous view-space position is the distance along the last frame's view direction.
    last_distance: vec4<f32>,
    /// Distance fog in this frame's picture, and in the last one's.
    fog: FogUniform,
    /// Value at a distance of one metre; in orthographic views, at any distance. Negative along axes that the projection mirrors.
    pixels_per_metre: vec2<f32>,
    /// `edge.x * depth + edge.y` is the depth step that separates surfaces one pixel apart.
    edge: vec2<f32>,
    /// Parameters of `behind`, the depth of the backs of surfaces.
    behind: vec2<f32>,
    /// Size of the texture of the history's first level, which may be larger than the last frame's viewport.
    history_size: vec2<f32>,
    /// Size of the viewport in the last frame.
    last_viewport_size: vec2<f32>,
    viewport_origin: vec2<u32>,
    viewport_size: vec2<u32>,
    /// Size of the viewport in texels.
    texture_size: vec2<u32>,
    /// Side of a texel in pixels.
    divisor: i32,
    /// Most steps of a ray from a smooth surface before it continues in segments.
    smooth_steps: u32,
    /// Most segments of a ray.
    rough_segments: u32,
    /// Length of the shortest segment, in pixels.
    shortest_segment: f32,
    /// Growth of a ray's segments with its length, per squared roughness. 0.5 is the radius of the part that one of sixteen rays
    /// represents: a quarter of the lobe's radius.
    growth: f32,
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
    /// This frame's exposure divided by that of the last one; 0 without a last frame.
    exposure_ratio: f32,
    /// Temporal part of the pattern, 0 to 1; 0 without TAA.
    turn: f32,
    /// Quarter of the directions that scattered rays take in this frame, 0 to 3.
    phase: u32,
    /// 1 if `lobes_texture` has lobes of the last frame.
    has_lobes: u32,
    /// 1 if `motion_texture` has the motion of each pixel. Not a shader definition: motion is toggled with effects that average
    /// frames, and compiling shaders would leave the view without reflections meanwhile.
    has_motion: u32,
    /// 1 if `specialization_texture` has words of special surfaces.
    has_specialization: u32,
    /// 1 if a debug view shows the hits, which are then written for texels without a ray too.
    shows_hits: u32,
    /// 1 if the camera moved, so that surfaces may have moved with it. Without motion vectors these are looked for in place.
    carries_surfaces: u32,
}
