// Horizon-based ambient occlusion: Bavoil and Sainz 2008, "Image-space horizon-based ambient occlusion".
#define_import_path bevy_lean_deferred::ambient_occlusion::hbao

#import bevy_lean_deferred::ambient_occlusion::bindings::{
    depth_at, direction_to_viewer, is_in_view, largest_side, radius_at, view, view_position,
}
#import bevy_lean_deferred::ambient_occlusion::horizon::{
    PI, side_occlusion, slice_normal,
}
#import bevy_lean_deferred::reconstruction::normal::{normal_from_positions, straighter_side}

#ifdef SHADING_NORMALS
#import bevy_lean_deferred::ambient_occlusion::bindings::normal_texture
#import bevy_lean_deferred::gbuffer::layout::{NO_GEOMETRY, unpack_normal}
#endif

/// Further from any surface than the other side of an axis can be, so that that is chosen.
const OUTSIDE: f32 = 1e9;

fn depth_or_outside(pixel: vec2<i32>, is_inside: bool) -> f32 {
    if !is_inside && !is_in_view(pixel) {
        return OUTSIDE;
    }
    let depth = depth_at(pixel);
    // Nor is the sky a neighbour, though its depth of 0 may be the nearer one at a horizon.
    return select(OUTSIDE, depth, depth > 0.0);
}

/// Depth of the neighbour's neighbour; the neighbour's where there is none, which leaves nearness alone to choose by.
fn second_depth(pixel: vec2<i32>, first: f32, is_inside: bool) -> f32 {
    let second = depth_or_outside(pixel, is_inside);
    return select(second, first, second == OUTSIDE);
}

/// Depth of the neighbour on the chosen side. What stands before both sides, or has none, is a ridge or too thin to have
/// a neighbour of its own surface: it faces the viewer.
fn depth_on_side(center: f32, before: f32, after: f32, side: f32) -> f32 {
    let faces_viewer = max(before, after) < center || min(before, after) == OUTSIDE;
    return select(select(before, after, side > 0.0), center, faces_viewer);
}

/// The unit normal of the surface that depth shows, towards the viewer. Nine taps: see `straighter_side`.
fn geometric_normal(
    pixel: vec2<i32>,
    depth: f32,
    position: vec3<f32>,
    to_viewer: vec3<f32>,
    is_inside: bool,
) -> vec3<f32> {
    let x = vec2(1, 0);
    let y = vec2(0, 1);
    let left = depth_or_outside(pixel - x, is_inside);
    let right = depth_or_outside(pixel + x, is_inside);
    let top = depth_or_outside(pixel - y, is_inside);
    let bottom = depth_or_outside(pixel + y, is_inside);
    let h = straighter_side(
        depth,
        left, second_depth(pixel - 2 * x, left, is_inside),
        right, second_depth(pixel + 2 * x, right, is_inside),
    );
    let v = straighter_side(
        depth,
        top, second_depth(pixel - 2 * y, top, is_inside),
        bottom, second_depth(pixel + 2 * y, bottom, is_inside),
    );
    let n = normal_from_positions(
        position,
        view_position(pixel + i32(h) * x, depth_on_side(depth, left, right, h)), h,
        view_position(pixel + i32(v) * y, depth_on_side(depth, top, bottom, v)), v,
    );
    return select(n, -n, dot(n, to_viewer) < 0.0);
}

// The presets are compiled for their numbers, so that loops unroll.
#ifdef SLICES
fn slice_count() -> u32 {
    return #{SLICES}u;
}

fn steps_on_each_side() -> u32 {
    return #{STEPS}u;
}
#else
fn slice_count() -> u32 {
    return view.slices;
}

fn steps_on_each_side() -> u32 {
    return view.steps;
}
#endif

/// One side of a slice.
struct March {
    pixel: vec2<i32>,
    position: vec3<f32>,
    to_viewer: vec3<f32>,
    geometric: vec3<f32>,
    /// On screen; its longer side is a pixel long.
    direction: vec2<f32>,
    /// Pixels to the radius along that side.
    reach: f32,
    inverse_radius_squared: f32,
    /// Where the first step stands between two, 0 to 1.
    offset: f32,
    /// No sample can lie outside of the view.
    is_inside: bool,
}

/// Cosine of the angle between the viewer and the highest sample; `base` if none is above the surface.
fn horizon(march: March, base: f32) -> f32 {
    let steps = steps_on_each_side();
    var highest = base;
    for (var i = 0u; i < steps; i++) {
        // Closer together near the pixel, and never the pixel itself nor the one before.
        let t = (f32(i) + march.offset) / f32(steps);
        let distance = max(march.reach * (0.5 * t + 0.5 * t * t), f32(i + 1u));
        let sample = march.pixel + vec2<i32>(round(march.direction * distance));
        if !march.is_inside && !is_in_view(sample) {
            continue;
        }
        let depth = depth_at(sample);
        let delta = view_position(sample, depth) - march.position;
        let distance_squared = dot(delta, delta);
        let inverse_distance = inverseSqrt(distance_squared);
        let nearness = 1.0 - distance_squared * march.inverse_radius_squared;
        let weight = saturate(nearness * view.inverse_falloff);
        let elevation = dot(delta, march.geometric) * inverse_distance;
        let cosine = dot(delta, march.to_viewer) * inverse_distance;
        // The sky is no occluder, though projections with a far plane place it there.
        let counts = elevation > view.sin_bias && weight > 0.0 && depth > 0.0;
        let height = select(base, mix(base, cosine, weight), counts);
#ifdef THIN
        highest = max(height, mix(height, highest, view.thickness));
#else
        highest = max(height, highest);
#endif
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

/// Cosine-weighted occlusion of a pixel, 0 to 1, from its own slices of the 2×2 pattern: those of `phase` 0 to 3.
fn hbao(phase: u32, pixel: vec2<i32>, depth: f32) -> f32 {
    let position = view_position(pixel, depth);
    let radius = radius_at(position);
    let reach = largest_side(radius.pixels);
    // Also true of what is not a number.
    if !(reach > 1.0) {
        return 0.0;
    }
    // On the screen's rim directions are stretched, at most by the ratio of the ray's length to its depth.
    let to_viewer = direction_to_viewer(position);
    let margin = i32(max(reach / max(to_viewer.z, 0.1), f32(steps_on_each_side()))) + 2;
    let is_inside = is_in_view(pixel - margin) && is_in_view(pixel + margin);

    var march: March;
    march.pixel = pixel;
    march.position = position;
    march.to_viewer = to_viewer;
    march.geometric = geometric_normal(pixel, depth, position, to_viewer, is_inside);
    march.inverse_radius_squared = 1.0 / (radius.metres * radius.metres);
    march.is_inside = is_inside;

    var normal = march.geometric;
#ifdef SHADING_NORMALS
    let word = textureLoad(normal_texture, vec2<i32>(view.viewport_origin) + pixel, 0).r;
    if word != NO_GEOMETRY {
        normal = (view.view_from_world * vec4(unpack_normal(word), 0.0)).xyz;
        // On outlines depth may tell of another surface; no shading normal leans that far off its own.
        if dot(normal, march.geometric) < 0.5 {
            march.geometric = normal;
        }
    }
#endif

    // The steps are spread over 4×4 texels: what is left of that pattern after the filter is a fine dither, not stripes.
    let quad = (vec2<u32>(pixel) / (2u * #{DIVISOR}u)) & vec2(1u);
    let block = quad.x + 2u * quad.y;

    let basis = tangents(to_viewer);
    let slices = slice_count();
    var occlusion = 0.0;
    for (var slice = 0u; slice < slices; slice++) {
        let turn = (f32(slice) + 0.25 * (f32(phase) + view.turn)) / f32(slices);
        // Evenly about the view direction, not on the screen: so perspective is exact off its centre too.
        let tangent = basis * vec2(cos(PI * turn), sin(PI * turn));
#ifdef PROJECTION_ORTHOGRAPHIC
        let direction = tangent.xy;
#else
        let direction = tangent.xy - tangent.z * position.xy / position.z;
#endif
        let lobe = slice_normal(normal, to_viewer, tangent);
        let surface = slice_normal(march.geometric, to_viewer, tangent);
        // The surface's own horizons.
        let bases = vec2(-surface.sine, surface.sine);

        let on_screen = radius.pixels * vec2(direction.x, -direction.y);
        march.reach = largest_side(on_screen);
        march.direction = on_screen / march.reach;
        march.offset = fract(0.125 + 0.25 * f32(phase + block) + 0.618 * f32(slice) + view.turn);
        let ahead = horizon(march, bases.x);
        march.direction = -march.direction;
        march.offset = fract(march.offset + 0.5);
        let behind = horizon(march, bases.y);

        occlusion += side_occlusion(lobe, bases.x, ahead, 1.0)
            + side_occlusion(lobe, bases.y, behind, -1.0);
    }
    return occlusion / f32(slices);
}
