// The small gather-based kernel, after AMD's HDAO (2009, "High Definition Ambient Occlusion", the DirectX 11 SDK's
// sample): opposite pairs of depths that form a valley with the pixel. A gather brings four of them.
#define_import_path bevy_lean_deferred::ambient_occlusion::hdao

#import bevy_lean_deferred::ambient_occlusion::bindings::{
    depth_texture, direction_to_viewer, is_in_view, largest_side, nearest_sampler, radius_at, view,
    view_position,
}

/// Corners of the 2×2 blocks on one side of the pixel, at a reach of 6; the others are opposite.
const BLOCKS = array<vec2<i32>, 6>(
    vec2(1, -1), vec2(0, 1), vec2(4, 0), vec2(1, 4), vec2(-4, 3), vec2(3, -5),
);
/// The pixels of a gather, in its order, from the corner.
const PARTS = array<vec2<i32>, 4>(vec2(0, 1), vec2(1, 1), vec2(1, 0), vec2(0, 0));
const REACH: f32 = 6.0;

/// Depths of the pixels (0, 1), (1, 1), (1, 0), (0, 0) from `corner`.
fn block(corner: vec2<i32>) -> vec4<f32> {
    let place = vec2<f32>(vec2<i32>(view.viewport_origin) + corner + 1);
    return textureGather(depth_texture, nearest_sampler, place / vec2<f32>(textureDimensions(depth_texture)));
}

/// To a sample: direction, and weight that falls with the distance.
fn direction_to(sample: vec2<i32>, depth: f32, position: vec3<f32>, inverse_radius_squared: f32) -> vec4<f32> {
    let delta = view_position(sample, depth) - position;
    let distance_squared = max(dot(delta, delta), 1e-30);
    let weight = saturate((1.0 - distance_squared * inverse_radius_squared) * view.inverse_falloff);
    return vec4(delta * inverseSqrt(distance_squared), select(0.0, weight, depth > 0.0 && is_in_view(sample)));
}

/// A pair counts wholly from an angle of 120° between its directions on.
const SHARPNESS: f32 = 4.0;

/// Occlusion of a pixel, 0 to 1. A pair with the angle α between its directions has (1 + cos α) / 2, as a V-groove has
/// at its edge; times `SHARPNESS`, because the few pairs that form a valley stand for all that the walls hide.
fn hdao(pixel: vec2<i32>, depth: f32) -> f32 {
    let position = view_position(pixel, depth);
    let to_viewer = direction_to_viewer(position);
    let radius = radius_at(position);
    let reach = largest_side(radius.pixels);
    if !(reach > 1.0) {
        return 0.0;
    }
    let scale = max(i32(reach / REACH), 1);
    let inverse_radius_squared = 1.0 / (radius.metres * radius.metres);
    // What two directions a little above a plane, on both sides, add up to.
    let least = view.sin_bias * view.sin_bias;

    var blocks = BLOCKS;
    var parts = PARTS;
    var sum = 0.0;
    for (var i = 0u; i < 6u; i++) {
        let corner = blocks[i] * scale;
        let here = block(pixel + corner);
        let there = block(pixel - corner - 1);
        // In the order of a gather; its opposite block runs the other way around.
        let opposite = there.zwxy;
        for (var j = 0u; j < 4u; j++) {
            let offset = corner + parts[j];
            let a = direction_to(pixel + offset, here[j], position, inverse_radius_squared);
            let b = direction_to(pixel - offset, opposite[j], position, inverse_radius_squared);
            let bisector = a.xyz + b.xyz;
            let valley = 0.25 * dot(bisector, bisector) - least;
            if dot(bisector, to_viewer) > 0.0 {
                sum += a.w * b.w * saturate(SHARPNESS * valley);
            }
        }
    }
    return sum / 24.0;
}
