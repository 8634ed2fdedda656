// Bindings of the reflection passes. Each pass imports those that it uses.
#define_import_path bevy_lean_deferred::effects::reflections::bindings

#import bevy_lean_deferred::reconstruction::position as reconstruction
#import bevy_lean_deferred::effects::reflections::view::ReflectionUniform

@group(0) @binding(0) var<uniform> view: ReflectionUniform;
@group(0) @binding(1) var depth_texture: texture_depth_2d;
@group(0) @binding(2) var depth_sampler: sampler;
@group(0) @binding(3) var normal_texture: texture_2d<u32>;
@group(0) @binding(4) var valid_mask_texture: texture_2d<u32>;
@group(0) @binding(5) var specialization_texture: texture_2d<u32>;
/// Motion of each pixel since the last frame; valid with `view.has_motion`.
@group(0) @binding(6) var motion_texture: texture_2d<f32>;
/// Last frame: light, and distance in alpha, in a unit of its own.
@group(0) @binding(7) var history_texture: texture_2d<f32>;
@group(0) @binding(8) var history_sampler: sampler;
/// Nearest and furthest depth of cells of pixels, packed.
@group(0) @binding(9) var hi_z_texture: texture_2d<u32>;
@group(0) @binding(10) var hi_z_output: texture_storage_2d<r32uint, write>;
/// Surface of each texel: its normal word, as in the G-buffer, and its depth, packed by `pack_begin`; 0 without a ray.
@group(0) @binding(11) var surfaces_texture: texture_2d<u32>;
@group(0) @binding(12) var surfaces_output: texture_storage_2d<rg32uint, write>;
/// Result of each ray: light and confidence, and its hit, packed by `pack_hit`.
@group(0) @binding(13) var rays_texture: texture_2d<f32>;
@group(0) @binding(14) var rays_output: texture_storage_2d<rgba16float, write>;
@group(0) @binding(15) var hits_texture: texture_2d<u32>;
@group(0) @binding(16) var hits_output: texture_storage_2d<r32uint, write>;
/// Light times confidence, and confidence, of each texel's lobe.
@group(0) @binding(17) var filtered_texture: texture_2d<f32>;
@group(0) @binding(18) var filtered_output: texture_storage_2d<rgba16float, write>;
@group(0) @binding(19) var output_texture: texture_storage_2d<rgba16float, write>;
/// Lobes that the last frames made at each texel, packed by `pack_lobes`.
@group(0) @binding(20) var lobes_texture: texture_2d<u32>;
@group(0) @binding(21) var lobes_output: texture_storage_2d<rgba32uint, write>;

/// View-space position of a point of the picture, in pixels.
fn view_position(at: vec2<f32>, depth: f32) -> vec3<f32> {
    return reconstruction::view_position(view.view_from_pixel, vec3(at, depth));
}

/// Projects a position (`w` of 1) or a direction (`w` of 0) from view space to pixels and depth, homogeneous.
fn homogeneous_pixel(position: vec3<f32>, w: f32) -> vec4<f32> {
    let m = view.pixel_from_view;
#ifdef PROJECTION_PERSPECTIVE
    // The omitted elements are 0.
    let xy = position.xy * vec2(m[0].x, m[1].y) + position.z * m[2].xy;
    return vec4(xy, position.z * m[2].z + w * m[3].z, position.z * m[2].w);
#else
    return m * vec4(position, w);
#endif
}

/// Unit vector from `position` to the viewer.
fn to_viewer(position: vec3<f32>) -> vec3<f32> {
#ifdef PROJECTION_ORTHOGRAPHIC
    return vec3(0.0, 0.0, 1.0);
#else
    return normalize(-position);
#endif
}

/// Cosine between the normal of a surface, seen at `at` in pixels, and the direction to the viewer.
fn facing_viewer(normal: vec3<f32>, at: vec2<f32>, depth: f32) -> f32 {
#ifdef PROJECTION_ORTHOGRAPHIC
    return normal.z;
#else
#ifdef PROJECTION_PERSPECTIVE
    // In the direction of the position, whatever the depth.
    let seen = vec3(reconstruction::ray_at(view.view_from_pixel, at), view.view_from_pixel[3].z);
#else
    let seen = view_position(at, depth);
#endif
    return -dot(normal, seen) * inverseSqrt(dot(seen, seen));
#endif
}

/// Depth step that separates surfaces `pixels` apart.
fn edge_step(depth: f32, pixels: f32) -> f32 {
    return (view.edge.x * depth + view.edge.y) * pixels;
}

/// Depth of the back of a surface whose front is at `depth`.
fn behind(depth: f32) -> f32 {
#ifdef PROJECTION_ORTHOGRAPHIC
    return depth - view.behind.x;
#else
    // Depth minus a constant is inversely proportional to distance.
    let inverse = depth - view.behind.y;
    return view.behind.y + inverse / (1.0 + view.behind.x * inverse);
#endif
}

/// Depth at a pixel, clamped to the viewport.
fn depth_in_view(pixel: vec2<i32>) -> f32 {
    let inside = clamp(pixel, vec2(0), vec2<i32>(view.viewport_size) - 1);
    return textureLoad(depth_texture, vec2<i32>(view.viewport_origin) + inside, 0);
}

/// Pixel `i` of the four that a texel's ray may start at: in 2×2 all of them, in 4×4 one of each row and column.
fn place_in_texel(i: i32) -> vec2<i32> {
    let bits = vec2(i & 1, i >> 1u);
    return select(bits, vec2(i, 2 * bits.x + bits.y), view.divisor == 4);
}

/// Packs the depth at which a ray starts, and in its last bits, the number of its pixel: see `place_in_texel`.
fn pack_begin(depth: f32, i: i32) -> u32 {
    return (bitcast<u32>(depth) & ~3u) | u32(i);
}

/// Pixel at which a texel's ray starts.
fn unpack_begin(texel: vec2<i32>, word: u32) -> vec2<i32> {
    return min(texel * view.divisor + place_in_texel(i32(word & 3u)), vec2<i32>(view.viewport_size) - 1);
}

/// Bit of a packed hit whose ray has another direction in each of several frames.
const CHANGES: u32 = 1u;

/// Bit of a packed hit of a surface that moves on its own.
const MOVES: u32 = 2u;

/// Packs a hit: the distance to its mirror image, seen straight through the mirror, in metres (0: miss), and in the lower bits the
/// weight of the ray. `bits`: `CHANGES` and `MOVES`.
fn pack_hit(distance: f32, weight: f32, bits: u32) -> u32 {
    return (bitcast<u32>(distance) & 0xffffff00u) | (u32(saturate(weight) * 63.0 + 0.5) << 2u) | bits;
}

fn unpack_distance(hit: u32) -> f32 {
    return bitcast<f32>(hit & 0xffffff00u);
}

/// 0 to 1.
fn unpack_weight(hit: u32) -> f32 {
    return f32((hit >> 2u) & 0x3fu) / 63.0;
}
