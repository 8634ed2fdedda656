// What the passes bind: each imports what it uses.
#define_import_path bevy_lean_deferred::screen_space::reflections::bindings

#import bevy_lean_deferred::reconstruction::position as reconstruction
#import bevy_lean_deferred::screen_space::reflections::view::ReflectionView

@group(0) @binding(0) var<uniform> view: ReflectionView;
@group(0) @binding(1) var depth_texture: texture_depth_2d;
@group(0) @binding(2) var normal_texture: texture_2d<u32>;
@group(0) @binding(3) var written_texture: texture_2d<u32>;
@group(0) @binding(4) var specialization_texture: texture_2d<u32>;
/// From where the motion of each pixel began, with `view.has_motion`.
@group(0) @binding(5) var motion_texture: texture_2d<f32>;
/// The last frame: light, and distance in alpha, in a unit of its own.
@group(0) @binding(6) var history_texture: texture_2d<f32>;
@group(0) @binding(7) var history_sampler: sampler;
/// The nearest and the furthest depth of cells of pixels: words.
@group(0) @binding(8) var cells_texture: texture_2d<u32>;
@group(0) @binding(9) var cells_output: texture_storage_2d<r32uint, write>;
/// What each ray has found: light and confidence; and where it was: see `pack_hit`.
@group(0) @binding(10) var rays_texture: texture_2d<f32>;
@group(0) @binding(11) var hits_texture: texture_2d<u32>;
@group(0) @binding(12) var rays_output: texture_storage_2d<rgba16float, write>;
@group(0) @binding(13) var hits_output: texture_storage_2d<r32uint, write>;
/// The surface of each texel: its normal, as the G-buffer has it, and its depth; 0 if it
/// sends no ray.
@group(0) @binding(18) var surfaces_texture: texture_2d<u32>;
@group(0) @binding(19) var surfaces_output: texture_storage_2d<rg32uint, write>;
/// Light times confidence, and confidence, of the lobe of each texel.
@group(0) @binding(16) var lobes_texture: texture_2d<f32>;
@group(0) @binding(17) var lobes_output: texture_storage_2d<rgba16float, write>;
@group(0) @binding(14) var output_texture: texture_storage_2d<rgba16float, write>;
@group(0) @binding(15) var depth_sampler: sampler;

/// Pixels a side of a texel of rays.
const DIVISOR: i32 = #{DIVISOR};

/// View-space position of a point of the picture, in pixels.
fn view_position(at: vec2<f32>, depth: f32) -> vec3<f32> {
    return reconstruction::view_position(view.view_from_pixel, vec3(at, depth));
}

/// Where a position in view space (`w` is 1) or a direction (0) is seen: in pixels and depth, homogeneous.
fn homogeneous_pixel(position: vec3<f32>, w: f32) -> vec4<f32> {
    let m = view.pixel_from_view;
#ifdef PROJECTION_PERSPECTIVE
    // What is left out is 0.
    let xy = position.xy * vec2(m[0].x, m[1].y) + position.z * m[2].xy;
    return vec4(xy, position.z * m[2].z + w * m[3].z, position.z * m[2].w);
#else
    return m * vec4(position, w);
#endif
}

/// Towards where the camera is from `position`, unit length.
fn to_viewer(position: vec3<f32>) -> vec3<f32> {
#ifdef PROJECTION_ORTHOGRAPHIC
    return vec3(0.0, 0.0, 1.0);
#else
    return normalize(-position);
#endif
}

/// The step in depth that separates surfaces so many pixels apart.
fn edge_step(depth: f32, pixels: f32) -> f32 {
    return (view.edge.x * depth + view.edge.y) * pixels;
}

/// Depth where a surface whose front is at `depth` ends.
fn behind(depth: f32) -> f32 {
#ifdef PROJECTION_ORTHOGRAPHIC
    return depth - view.behind.x;
#else
    // Depth less a constant is inverse to the distance.
    let inverse = depth - view.behind.y;
    return view.behind.y + inverse / (1.0 + view.behind.x * inverse);
#endif
}

/// Depth at a pixel of the viewport, or at the nearest one.
fn depth_in_view(pixel: vec2<i32>) -> f32 {
    let inside = clamp(pixel, vec2(0), vec2<i32>(view.viewport_size) - 1);
    return textureLoad(depth_texture, vec2<i32>(view.viewport_origin) + inside, 0);
}

/// Where a ray ended: the distance at which its mirror image is seen, straight on through the mirror, in metres (0: nowhere), and
/// in the lower bits the weight of its direction.
fn pack_hit(distance: f32, weight: f32) -> u32 {
    return (bitcast<u32>(distance) & 0xffffff00u) | (u32(saturate(weight) * 127.0 + 0.5) << 1u);
}

fn unpack_distance(hit: u32) -> f32 {
    return bitcast<f32>(hit & 0xffffff00u);
}

/// 0 to 127: compared with others only.
fn unpack_weight(hit: u32) -> f32 {
    return f32((hit >> 1u) & 0x7fu);
}
