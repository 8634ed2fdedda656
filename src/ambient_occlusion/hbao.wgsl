// Horizon-based ambient occlusion: Bavoil and Sainz 2008, "Image-space horizon-based ambient occlusion".
#define_import_path bevy_lean_deferred::ambient_occlusion::hbao

#import bevy_lean_deferred::ambient_occlusion::bindings::{
    depth_at, direction_to_viewer, is_in_view, largest_side, radius_at, view, view_position,
}
#import bevy_lean_deferred::ambient_occlusion::horizon::{
    PI, side_occlusion, slice_normal,
}
#import bevy_lean_deferred::lighting::geometric_normal::{nearer_side, normal_from_positions}

#ifdef SHADING_NORMALS
#import bevy_lean_deferred::ambient_occlusion::bindings::normal_texture
#import bevy_lean_deferred::gbuffer::layout::{NO_GEOMETRY, unpack_normal}
#endif

/// Further from any surface than the other side of an axis can be, so that that is chosen.
const OUTSIDE: f32 = 1e9;

fn depth_or_outside(pixel: vec2<i32>) -> f32 {
    if !is_in_view(pixel) {
        return OUTSIDE;
    }
    let depth = depth_at(pixel);
    // Nor is the sky a neighbour, though its depth of 0 may be the nearer one at a horizon.
    return select(OUTSIDE, depth, depth > 0.0);
}

/// Depth of the neighbour on the chosen side. What stands before both sides, or has none, is a ridge or too thin to have
/// a neighbour of its own surface: it faces the viewer.
fn depth_on_side(center: f32, before: f32, after: f32, side: f32) -> f32 {
    let faces_viewer = max(before, after) < center || min(before, after) == OUTSIDE;
    return select(select(before, after, side > 0.0), center, faces_viewer);
}

fn geometric_normal(pixel: vec2<i32>, depth: f32, position: vec3<f32>, to_viewer: vec3<f32>) -> vec3<f32> {
    let x = vec2(1, 0);
    let y = vec2(0, 1);
    let left = depth_or_outside(pixel - x);
    let right = depth_or_outside(pixel + x);
    let top = depth_or_outside(pixel - y);
    let bottom = depth_or_outside(pixel + y);
    let h = nearer_side(depth, left, right);
    let v = nearer_side(depth, top, bottom);
    let n = normal_from_positions(
        position,
        view_position(pixel + i32(h) * x, depth_on_side(depth, left, right, h)), h,
        view_position(pixel + i32(v) * y, depth_on_side(depth, top, bottom, v)), v,
    );
    return select(n, -n, dot(n, to_viewer) < 0.0);
}

/// One side of a slice.
struct March {
    pixel: vec2<i32>,
    position: vec3<f32>,
    to_viewer: vec3<f32>,
    geometric: vec3<f32>,
    /// Pixels to the radius.
    reach: vec2<f32>,
    inverse_radius_squared: f32,
    /// Where the first step stands between two, 0 to 1.
    offset: f32,
}

/// Cosine of the angle between the viewer and the highest sample; `base` if none is above the surface.
fn horizon(march: March, base: f32) -> f32 {
    var highest = base;
    for (var i = 0u; i < #{STEPS}u; i++) {
        let t = (f32(i) + march.offset) / f32(#{STEPS}u);
        // Closer together near the pixel, and never the pixel itself.
        let reach = march.reach * t * sqrt(t);
        let nearest = f32(i + 1u) / max(max(abs(reach.x), abs(reach.y)), 1e-6);
        let sample = march.pixel + vec2<i32>(round(reach * max(nearest, 1.0)));
        if !is_in_view(sample) {
            continue;
        }
        let depth = depth_at(sample);
        let delta = view_position(sample, depth) - march.position;
        let distance_squared = dot(delta, delta);
        let inverse_distance = inverseSqrt(distance_squared);
        let is_above = dot(delta, march.geometric) * inverse_distance > view.sin_bias;
        let nearness = 1.0 - distance_squared * march.inverse_radius_squared;
        let weight = saturate(nearness * view.inverse_falloff);
        let cosine = dot(delta, march.to_viewer) * inverse_distance;
        // The sky is no occluder, though projections with a far plane place it there.
        let height = select(base, mix(base, cosine, weight), is_above && weight > 0.0 && depth > 0.0);
        highest = max(height, mix(height, highest, view.thickness));
    }
    return highest;
}

/// Two unit vectors across `n`, which faces +Z at least a little, and across each other (Duff et al. 2017, "Building an
/// Orthonormal Basis, Revisited").
fn tangents(n: vec3<f32>) -> mat2x3<f32> {
    let a = 1.0 / (1.0 + n.z);
    let b = -n.x * n.y * a;
    return mat2x3(vec3(1.0 - n.x * n.x * a, b, -n.x), vec3(b, 1.0 - n.y * n.y * a, -n.y));
}

/// Cosine-weighted occlusion of a pixel, 0 to 1, from its own slices of the 2×2 pattern.
fn hbao(texel: vec2<u32>, pixel: vec2<i32>, depth: f32) -> f32 {
    let position = view_position(pixel, depth);
    let radius = radius_at(position);
    // Also true of what is not a number.
    if !(largest_side(radius.pixels) > 1.0) {
        return 0.0;
    }
    var march: March;
    march.pixel = pixel;
    march.position = position;
    march.to_viewer = direction_to_viewer(position);
    march.geometric = geometric_normal(pixel, depth, position, march.to_viewer);
    march.inverse_radius_squared = 1.0 / (radius.metres * radius.metres);

    var normal = march.geometric;
#ifdef SHADING_NORMALS
    let word = textureLoad(normal_texture, vec2<i32>(view.viewport_origin) + pixel, 0).r;
    if word != NO_GEOMETRY {
        normal = (view.view_from_world * vec4(unpack_normal(word), 0.0)).xyz;
    }
#endif

    // 0 3 / 2 1: neighbours along an axis look in rather different directions.
    let x = texel.x & 1u;
    let phase = f32(select(2u - x, 3u * x, (texel.y & 1u) == 0u));
    let basis = tangents(march.to_viewer);
    var occlusion = 0.0;
    for (var slice = 0u; slice < #{SLICES}u; slice++) {
        let turn = (f32(slice) + 0.25 * (phase + view.turn)) / f32(#{SLICES}u);
        // Evenly about the view direction, not on the screen: so perspective is exact off its centre too.
        let tangent = basis * vec2(cos(PI * turn), sin(PI * turn));
#ifdef PROJECTION_ORTHOGRAPHIC
        let direction = tangent.xy;
#else
        let direction = tangent.xy - tangent.z * position.xy / position.z;
#endif
        let lobe = slice_normal(normal, march.to_viewer, tangent);
        let surface = slice_normal(march.geometric, march.to_viewer, tangent);
        // The surface's own horizons.
        let bases = vec2(-surface.sine, surface.sine);

        march.offset = fract(0.125 + 0.25 * phase + 0.618 * f32(slice) + view.turn);
        march.reach = radius.pixels * vec2(direction.x, -direction.y);
        let ahead = horizon(march, bases.x);
        march.offset = fract(march.offset + 0.5);
        march.reach = -march.reach;
        let behind = horizon(march, bases.y);

        occlusion += side_occlusion(lobe, bases.x, ahead, 1.0)
            + side_occlusion(lobe, bases.y, behind, -1.0);
    }
    return occlusion / f32(#{SLICES}u);
}
