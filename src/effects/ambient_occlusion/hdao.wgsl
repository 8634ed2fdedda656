// Small gather-based kernel, after AMD's HDAO (2009, "High Definition Ambient Occlusion", sample of the DirectX 11 SDK):
// opposite pairs of depths that form a valley with the pixel. A gather reads four of them. Depth is affine on screen, so a
// plane is no valley, whatever its tilt.
#define_import_path bevy_lean_deferred::effects::ambient_occlusion::hdao

#import bevy_lean_deferred::effects::ambient_occlusion::bindings::{
    depth_texture, is_in_view, largest_side, nearest_sampler, radius_at, view, view_position,
}

#ifdef PROJECTION_PERSPECTIVE
#import bevy_lean_deferred::reconstruction::position::view_z
#endif

/// Corners of the 2×2 blocks on one side of the pixel, at a reach of 6. The other blocks are opposite.
const BLOCKS = array<vec2<i32>, 4>(vec2(1, 0), vec2(-1, 2), vec2(3, 3), vec2(4, -3));
/// Pixels of a gather relative to its corner, in component order.
const PARTS = array<vec2<i32>, 4>(vec2(0, 1), vec2(1, 1), vec2(1, 0), vec2(0, 0));
const REACH: f32 = 6.0;
/// Factor from slope to occlusion. Few pairs form a valley; they represent all directions that its walls occlude.
const SHARPNESS: f32 = 1.0;

/// Depths of the pixels (0, 1), (1, 1), (1, 0), (0, 0) from `corner`.
fn block(corner: vec2<i32>) -> vec4<f32> {
    let place = vec2<f32>(vec2<i32>(view.viewport_origin) + corner + 1);
    return textureGather(depth_texture, nearest_sampler, place / vec2<f32>(textureDimensions(depth_texture)));
}

/// View-space z of a block's pixels.
fn heights(corner: vec2<i32>, depths: vec4<f32>) -> vec4<f32> {
#ifdef PROJECTION_PERSPECTIVE
    return view_z(view.view_from_pixel, depths);
#else
    return vec4(
        view_position(corner + vec2(0, 1), depths.x).z,
        view_position(corner + vec2(1, 1), depths.y).z,
        view_position(corner + vec2(1, 0), depths.z).z,
        view_position(corner, depths.w).z,
    );
#endif
}

/// Occlusion of a pixel, 0 to 1.
fn hdao(pixel: vec2<i32>, depth: f32) -> f32 {
    let position = view_position(pixel, depth);
    let radius = radius_at(position, depth);
    let reach = largest_side(radius.pixels);
    if !(reach > 1.0) {
        return 0.0;
    }
    let scale = max(i32(reach / REACH), 1);
    let margin = 6 * scale + 2;
    let is_inside = is_in_view(pixel - margin) && is_in_view(pixel + margin);

    // Metres towards the viewer per unit of depth: exact on planes for the sum of two opposite samples.
    let m = view.view_from_pixel;
#ifdef PROJECTION_ORTHOGRAPHIC
    let metres = abs(m[2].z);
#else ifdef PROJECTION_PERSPECTIVE
    let metres = abs(m[2].w) * position.z * position.z;
#else
    let step = 1e-3 * depth;
    let around = view_position(pixel, depth + step).z - view_position(pixel, depth - step).z;
    let metres = abs(around) / (2.0 * step);
#endif
    let inverse_radius = radius.excess / view.radius;
    let pixels_per_metre = reach * inverse_radius;

    var blocks = BLOCKS;
    var parts = PARTS;
    var sum = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let corner = blocks[i] * scale;
        let here = block(pixel + corner);
        // The components of the opposite block are in point-mirrored order.
        let there = block(pixel - corner - 1).zwxy;
        let rise = heights(pixel + corner, here) - position.z;
        let opposite_rise = heights(pixel - corner - 1, there.zwxy).zwxy - position.z;
        let nearness = 1.0 - max(rise * rise, opposite_rise * opposite_rise) * inverse_radius * inverse_radius;
        let weight = saturate(nearness * view.inverse_falloff);
        let valley = 0.5 * (here + there - 2.0 * depth) * metres;
        for (var j = 0u; j < 4u; j++) {
            let offset = corner + parts[j];
            let is_sky = min(here[j], there[j]) <= 0.0;
            if is_sky || !is_inside && !(is_in_view(pixel + offset) && is_in_view(pixel - offset)) {
                continue;
            }
            let slope = valley[j] * pixels_per_metre * inverseSqrt(f32(dot(offset, offset)));
            sum += weight[j] * saturate(SHARPNESS * (slope - view.sin_bias));
        }
    }
    return sum / 16.0;
}
