// The pixel whose light is made, and what the rays of the texels around it tell of it.
#define_import_path bevy_lean_deferred::screen_space::reflections::receiver

#import bevy_lean_deferred::gbuffer::layout::light::unpack_halves
#import bevy_lean_deferred::screen_space::reflections::bindings::{unpack_distance, view}
#import bevy_lean_deferred::screen_space::reflections::texels::{SIDE, hits, likeness, lights}

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
    /// How alike it is to the surfaces of the four texels around it: `likeness_beside`.
    alike: vec4<f32>,
}

/// Texel `i` of the four around the pixel, of which `first` is the first.
fn texel_beside(first: i32, i: i32) -> i32 {
    return first + (i & 1) + SIDE * (i >> 1u);
}

/// How alike its surface is to the receiver, which is `along` of the way between them: 0 to 1.
fn likeness_beside(receiver: Receiver, first: i32, i: i32, along: vec2<f32>) -> f32 {
    let offset = vec2(f32(i & 1), f32(i >> 1u)) - along;
    let expected = receiver.depth + dot(receiver.slope, offset);
    return likeness(receiver.normal, expected, texel_beside(first, i), receiver.inverse_step);
}

/// How much texel `i` of these counts for the receiver.
fn weight_beside(receiver: Receiver, i: i32, along: vec2<f32>) -> f32 {
    let corner = vec2(i & 1, i >> 1u);
    // The one furthest away may be the only one of its surface.
    let near = max(select(1.0 - along, along, corner == vec2(1)), vec2(1e-3));
    return near.x * near.y * receiver.alike[i];
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
        let image = unpack_distance(hits[texel_beside(first, i)]);
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
        let texel = texel_beside(first, i);
        let weight = select(0.0, weight_beside(receiver, i, along), hits[texel] != 0u);
        sum += weight * unpack_halves(lights[texel]);
        weights += weight;
    }
    return sum / weights;
}
