// What a workgroup that makes the light of pixels knows of the texels around them: their surfaces, and what their rays have found.
#define_import_path bevy_lean_deferred::screen_space::reflections::texels

#import bevy_lean_deferred::reconstruction::normal::flatter_slope
#import bevy_lean_deferred::screen_space::reflections::bindings::{ROUGH_STEP, unpack_distance, view}

/// Texels a side of a workgroup, and invocations.
const TEXELS: i32 = 16;
const INVOCATIONS: i32 = TEXELS * TEXELS;
/// Rays that a mean is of, each way from its own. The outer ones weigh half as much: each of the four directions that rays have along an
/// axis then weighs alike, and what a ray has met has no hard edges.
const REACH: i32 = 2;
/// Texels a side that are read: those of all means.
const SIDE: i32 = TEXELS + 1 + 2 * REACH * ROUGH_STEP;
/// The first of the texels whose pixels are made.
const FIRST_MADE: i32 = REACH * ROUGH_STEP * (1 + SIDE);

/// Half floats of light times confidence, and confidence: many workgroups are to find room.
var<workgroup> lights: array<vec2<u32>, SIDE * SIDE>;
/// Normals in half floats, and depths: 0 where nothing mirrors.
var<workgroup> normals: array<vec2<u32>, SIDE * SIDE>;
var<workgroup> depths: array<f32, SIDE * SIDE>;
/// With a bit for those of rough surfaces, whose rays are further apart.
var<workgroup> hits: array<u32, SIDE * SIDE>;
const IS_ROUGH: u32 = 1u;

/// The pixel whose light is made.
struct Receiver {
    /// In pixels.
    at: vec2<f32>,
    depth: f32,
    /// From texel to texel.
    slope: vec2<f32>,
    /// Of the step in depth that separates surfaces a texel apart.
    inverse_step: f32,
    /// In world space.
    normal: vec3<f32>,
    roughness: f32,
}

fn pack_halves(x: vec4<f32>) -> vec2<u32> {
    return vec2(pack2x16float(x.xy), pack2x16float(x.zw));
}

fn unpack_halves(words: vec2<u32>) -> vec4<f32> {
    return vec4(unpack2x16float(words.x), unpack2x16float(words.y));
}

/// How alike the surface of a texel is to one with this normal, which there would have the depth `expected`: 0 to 1.
fn likeness(normal: vec3<f32>, expected: f32, texel: i32, inverse_step: f32) -> f32 {
    let near = saturate(2.0 - abs(depths[texel] - expected) * inverse_step);
    // Without a normal it is like nothing.
    return near * saturate(8.0 * dot(normal, unpack_halves(normals[texel]).xyz) - 7.0);
}

/// How alike the surface of a texel is to the receiver, from which it is `offset` texels away.
fn likeness_of(receiver: Receiver, texel: i32, offset: vec2<f32>) -> f32 {
    let expected = receiver.depth + dot(receiver.slope, offset);
    return likeness(receiver.normal, expected, texel, receiver.inverse_step);
}

/// From texel to texel.
fn slope_at(texel: i32) -> vec2<f32> {
    let depth = depths[texel];
    return vec2(
        flatter_slope(depths[texel - 1], depth, depths[texel + 1]),
        flatter_slope(depths[texel - SIDE], depth, depths[texel + SIDE]),
    );
}

/// How wide a lobe of a roughness squared of 1 is on screen, at so many metres on its way and so far from the camera, in pixels.
fn lobe_width(metres: f32, distance: f32) -> f32 {
#ifdef PROJECTION_ORTHOGRAPHIC
    return 2.0 * metres * abs(view.pixels_per_metre.y);
#else
    return 2.0 * metres * abs(view.pixels_per_metre.y) / max(distance, 1e-6);
#endif
}

/// How wide the lobe of a texel is on screen where the rays beside it ended, in pixels, for a roughness squared of 1.
fn width_at(first: i32, position: vec3<f32>) -> f32 {
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0; i < 4; i++) {
        let image = unpack_distance(hits[first + (i & 1) + SIDE * (i >> 1u)]);
        sum += image;
        count += select(0.0, 1.0, image > 0.0);
    }
    let distance = length(position);
#ifdef PROJECTION_ORTHOGRAPHIC
    let begin = 0.0;
#else
    let begin = distance;
#endif
    // Where they met nothing, as wide as if that was as far away as the mirror: what others met further beside is in the lobe of
    // a rough one, and not what a smooth one mirrors.
    let metres = select(distance, sum / max(count, 1.0) - begin, count > 0.0);
    // What is mirrored is about as far away as the mirror: nearer or further is nothing that matters.
    return lobe_width(metres, distance);
}

/// What the rays of the texels around have found themselves, for outlines: light times confidence, and confidence.
fn light_around(receiver: Receiver, first: i32, along: vec2<f32>) -> vec4<f32> {
    var sum = vec4(0.0);
    var weights = 1e-12;
    for (var i = 0; i < 4; i++) {
        let corner = vec2<f32>(vec2(i & 1, i >> 1u));
        let texel = first + (i & 1) + SIDE * (i >> 1u);
        // Of rough surfaces a ray beside it may be the only one.
        let near = max(1.0 - abs(corner - along), vec2(1e-3));
        let alike = likeness_of(receiver, texel, corner - along);
        let weight = select(0.0, near.x * near.y * alike, hits[texel] > IS_ROUGH);
        sum += weight * unpack_halves(lights[texel]);
        weights += weight;
    }
    return sum / weights;
}
