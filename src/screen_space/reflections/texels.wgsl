// What a workgroup knows of texels: their surfaces, and what their rays have found. Either of those whose lobes it makes (LOBES), or
// of those around the pixels whose light it makes.
#define_import_path bevy_lean_deferred::screen_space::reflections::texels

#import bevy_lean_deferred::gbuffer::layout::{light::{pack_halves, unpack_halves}, unpack_normal}
#import bevy_lean_deferred::reconstruction::normal::flatter_slope
#import bevy_lean_deferred::screen_space::reflections::bindings::{
    DIVISOR, edge_step, hits_texture, rays_texture, surfaces_texture, view,
}

/// Texels a side whose lobes a workgroup makes, and pixels a side whose light one makes.
const WORKGROUP_SIDE: i32 = 16;

#ifdef LOBES
/// Texels a side that something is made of.
const MADE: i32 = WORKGROUP_SIDE;
/// Texels around them that are read too: a lobe is of so many rays each way from its own.
const RIM: i32 = 2;
const INVOCATIONS: i32 = 256;
#else
/// Texels a side that something is made of: those around the pixels.
const MADE: i32 = WORKGROUP_SIDE / DIVISOR + 1;
/// Texels around them that are read too, for their slopes.
const RIM: i32 = 1;
/// Of fewer texels fewer: then they wait less for each other.
const INVOCATIONS: i32 = 256 / DIVISOR;
#endif
const SIDE: i32 = MADE + 2 * RIM;
/// The first texel that something is made of.
const FIRST_MADE: i32 = RIM * (1 + SIDE);

/// Half floats of light times confidence, and confidence: many workgroups are to find room.
var<workgroup> lights: array<vec2<u32>, SIDE * SIDE>;
/// Normals in half floats, and depths: 0 where there is no ray.
var<workgroup> normals: array<vec2<u32>, SIDE * SIDE>;
var<workgroup> depths: array<f32, SIDE * SIDE>;
/// See `pack_hit`; 0 where there is no ray.
var<workgroup> hits: array<u32, SIDE * SIDE>;

/// What the textures hold of a texel.
struct Texel {
    place: vec2<i32>,
    surface: vec2<u32>,
    light: vec4<f32>,
    hit: u32,
}

/// The nearest one in the picture.
fn nearest_inside(texel: vec2<i32>) -> vec2<i32> {
    return clamp(texel, vec2(0), vec2<i32>(view.texture_size) - 1);
}

/// Texel `read` of the workgroup. `corner` is the first one that something is made of.
fn texel_at(corner: vec2<i32>, read: i32) -> Texel {
    var known: Texel;
    known.place = corner + vec2<i32>(vec2(u32(read) % u32(SIDE), u32(read) / u32(SIDE))) - RIM;
    let texel = nearest_inside(known.place);
    known.surface = textureLoad(surfaces_texture, texel, 0).rg;
    known.light = textureLoad(rays_texture, texel, 0);
    known.hit = textureLoad(hits_texture, texel, 0).r;
    return known;
}

/// Keeps it, and says whether it counts: beyond the rim of the picture nothing does, and where there is no ray the other textures
/// hold anything.
fn keep(read: i32, known: Texel) -> bool {
    let counts = all(known.place == nearest_inside(known.place)) && known.surface.y != 0u;
    let light = vec4(known.light.rgb * known.light.a, known.light.a);
    lights[read] = select(vec2(0u), pack_halves(light), counts);
    hits[read] = select(0u, known.hit, counts);
    normals[read] = select(vec2(0u), pack_halves(vec4(unpack_normal(known.surface.x), 0.0)), counts);
    depths[read] = select(0.0, bitcast<f32>(known.surface.y), counts);
    return counts;
}

/// How alike the surface of a texel is to one with this normal, which there would have the depth `expected`: 0 to 1.
fn likeness(normal: vec3<f32>, expected: f32, texel: i32, inverse_step: f32) -> f32 {
    let near = saturate(2.0 - abs(depths[texel] - expected) * inverse_step);
    // Without a normal it is like nothing.
    return near * saturate(8.0 * dot(normal, unpack_halves(normals[texel]).xyz) - 7.0);
}

/// From texel to texel.
fn slope_at(texel: i32) -> vec2<f32> {
    let depth = depths[texel];
    return vec2(
        flatter_slope(depths[texel - 1], depth, depths[texel + 1]),
        flatter_slope(depths[texel - SIDE], depth, depths[texel + SIDE]),
    );
}

/// Of the step in depth that separates surfaces a texel apart.
fn inverse_step_at(depth: f32) -> f32 {
    return 1.0 / edge_step(depth, f32(DIVISOR));
}
