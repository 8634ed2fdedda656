// Texels in workgroup memory: their surfaces, and the results of their rays. Either those whose lobes the workgroup makes (SPATIAL_FILTER),
// or those around the pixels that it resolves.
#define_import_path bevy_lean_deferred::effects::reflections::texels

#import bevy_lean_deferred::gbuffer::layout::{light::{pack_halves, unpack_halves}, unpack_normal, unpack_roughness}
#import bevy_lean_deferred::reconstruction::normal::flatter_slope
#import bevy_lean_deferred::effects::reflections::bindings::{
    edge_step, hits_texture, rays_texture, surfaces_texture, unpack_weight, view,
}

/// Side in texels of the lobes, and in pixels of the light, that a workgroup makes.
const WORKGROUP_SIDE: i32 = 16;

#ifdef SPATIAL_FILTER
/// Side in texels of the lobes.
const MADE: i32 = WORKGROUP_SIDE;
/// Border of texels that are read too: the radius of a lobe's kernel.
const RIM: i32 = 3;
const INVOCATIONS: i32 = 256;
#else
/// Side of a texel in pixels.
const DIVISOR: i32 = #{DIVISOR};
/// Side in texels of those around the pixels.
const MADE: i32 = WORKGROUP_SIDE / DIVISOR + 1;
/// Border of texels that are read too, for slopes.
const RIM: i32 = 1;
/// Fewer for fewer texels, so that they wait less for each other.
const INVOCATIONS: i32 = 256 / DIVISOR;
#endif
const CACHE_SIDE: i32 = MADE + 2 * RIM;
/// Index of the first texel inside the border.
const FIRST_MADE: i32 = RIM * (1 + CACHE_SIDE);

/// Light times confidence, and confidence (SPATIAL_FILTER: both times the ray's weight), in half floats: less memory lets more
/// workgroups run at once.
var<workgroup> lights: array<vec2<u32>, CACHE_SIDE * CACHE_SIDE>;
/// Normals and roughnesses (SPATIAL_FILTER: weights of rays) in half floats, and depths, as packed by `pack_begin`; 0 without a ray.
var<workgroup> normals: array<vec2<u32>, CACHE_SIDE * CACHE_SIDE>;
var<workgroup> depths: array<f32, CACHE_SIDE * CACHE_SIDE>;
/// Packed by `pack_hit`; 0 without a ray.
var<workgroup> hits: array<u32, CACHE_SIDE * CACHE_SIDE>;

#ifndef SPATIAL_FILTER
/// Index of the first of the four texels around a position in pixels.
fn first_beside(at: vec2<f32>) -> i32 {
    let texel = vec2<i32>(vec2<u32>(at) % u32(WORKGROUP_SIDE) / u32(DIVISOR));
    return texel.x + CACHE_SIDE * texel.y + FIRST_MADE;
}
#endif

/// Content of the textures at a texel.
struct Texel {
    place: vec2<i32>,
    surface: vec2<u32>,
    light: vec4<f32>,
    hit: u32,
}

/// `texel`, clamped to the picture.
fn nearest_inside(texel: vec2<i32>) -> vec2<i32> {
    return clamp(texel, vec2(0), vec2<i32>(view.texture_size) - 1);
}

/// Texel `read` of the workgroup. `corner` is the first one inside the border.
fn texel_at(corner: vec2<i32>, read: i32) -> Texel {
    var known: Texel;
    known.place = corner + vec2<i32>(vec2(u32(read) % u32(CACHE_SIDE), u32(read) / u32(CACHE_SIDE))) - RIM;
    let texel = nearest_inside(known.place);
    known.surface = textureLoad(surfaces_texture, texel, 0).rg;
    known.light = textureLoad(rays_texture, texel, 0);
    known.hit = textureLoad(hits_texture, texel, 0).r;
    return known;
}

/// Keeps a texel. Returns true if it counts: beyond the edge of the picture none does, and without a ray the other textures are
/// undefined.
fn keep(read: i32, known: Texel) -> bool {
    let counts = all(known.place == nearest_inside(known.place)) && known.surface.y != 0u;
    var light = vec4(known.light.rgb * known.light.a, known.light.a);
#ifdef SPATIAL_FILTER
    let fourth = unpack_weight(known.hit);
    light *= fourth;
#else
    let fourth = unpack_roughness(known.surface.x);
#endif
    lights[read] = select(vec2(0u), pack_halves(light), counts);
    hits[read] = select(0u, known.hit, counts);
    normals[read] = select(vec2(0u), pack_halves(vec4(unpack_normal(known.surface.x), fourth)), counts);
    depths[read] = select(0.0, bitcast<f32>(known.surface.y), counts);
    return counts;
}

/// Likeness, 0 to 1, of a texel's surface to one with this normal and, at the texel, the depth `expected`.
fn likeness(normal: vec3<f32>, expected: f32, texel: i32, inverse_step: f32) -> f32 {
    let near = saturate(2.0 - abs(depths[texel] - expected) * inverse_step);
    // A texel without a normal is like no surface.
    return near * saturate(8.0 * dot(normal, unpack_halves(normals[texel]).xyz) - 7.0);
}

/// Depth slope per texel.
fn slope_at(texel: i32) -> vec2<f32> {
    let depth = depths[texel];
    return vec2(
        flatter_slope(depths[texel - 1], depth, depths[texel + 1]),
        flatter_slope(depths[texel - CACHE_SIDE], depth, depths[texel + CACHE_SIDE]),
    );
}

/// 1 / the depth step that separates surfaces a texel apart.
fn inverse_step_at(depth: f32) -> f32 {
    return 1.0 / edge_step(depth, f32(view.divisor));
}
