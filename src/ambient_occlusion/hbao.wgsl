// Horizon-based ambient occlusion: Bavoil and Sainz 2008, "Image-space horizon-based ambient occlusion".
#define_import_path bevy_lean_deferred::ambient_occlusion::hbao

#import bevy_lean_deferred::ambient_occlusion::bindings::{
    depth_at, direction_to_viewer, is_in_view, largest_side, radius_at, reconstructed, view, view_position,
}
#import bevy_lean_deferred::horizon::{PI, side_occlusion, slice_normal, tangents}
#import bevy_lean_deferred::reconstruction::normal_from_depth::{DepthsAround, geometric_normal}

#ifdef SHADING_NORMALS
#import bevy_lean_deferred::ambient_occlusion::bindings::normal_texture
#import bevy_lean_deferred::gbuffer::layout::{NO_GEOMETRY, unpack_normal}
#endif

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

/// Whole numbers near 0 stand in the lowest bits of this plus them.
const ROUNDER: f32 = 12582912.0;

/// The nearest whole numbers, as both.
struct Rounded {
    whole: vec2<i32>,
    number: vec2<f32>,
}

/// By an addition: conversions take four times as long. The bits that are set are set already; compilers do not know, and so do not
/// take the sum apart.
fn rounded(x: vec2<f32>) -> Rounded {
    let bits = bitcast<vec2<u32>>(x + ROUNDER) | vec2(0x4b000000u);
    return Rounded(vec2<i32>(bits) - bitcast<i32>(ROUNDER), bitcast<vec2<f32>>(bits) - ROUNDER);
}

/// A slice.
struct March {
    pixel: vec2<i32>,
    center: vec2<f32>,
    position: vec3<f32>,
    to_viewer: vec3<f32>,
    geometric: vec3<f32>,
    /// On screen; its longer side is a pixel long.
    direction: vec2<f32>,
    /// Pixels to the radius along that side.
    reach: f32,
    inverse_radius_squared: f32,
    /// Where the first step ahead stands between two, 0 to 1.
    offset: f32,
}

/// Cosine of the angle between the viewer and the highest sample on one `side`, 1 or -1; `base` if none is above the surface.
/// `is_inside` says that no sample can lie outside of the view: then nothing keeps them from being read all at once.
fn horizon(march: March, side: f32, base: f32, is_inside: bool) -> f32 {
    let steps = steps_on_each_side();
    let offset = select(fract(march.offset + 0.5), march.offset, side > 0.0);
    var highest = base;
    for (var i = 0u; i < steps; i++) {
        // Closer together near the pixel, and never the pixel itself nor the one before.
        let t = (f32(i) + offset) / f32(steps);
        let distance = max(march.reach * (0.5 * t + 0.5 * t * t), f32(i + 1u));
        let step = rounded(side * march.direction * distance);
        let sample = march.pixel + step.whole;
        if !is_inside && !is_in_view(sample) {
            continue;
        }
        let depth = depth_at(sample);
        let delta = reconstructed(vec3(march.center + step.number, depth)) - march.position;
        let distance_squared = dot(delta, delta);
        let inverse_distance = inverseSqrt(distance_squared);
        let nearness = 1.0 - distance_squared * march.inverse_radius_squared;
        let weight = saturate(nearness * view.inverse_falloff);
        let elevation = dot(delta, march.geometric) * inverse_distance;
        let cosine = dot(delta, march.to_viewer) * inverse_distance;
        // The sky is no occluder, though projections with a far plane place it there.
        let counts = elevation > view.sin_bias && depth > 0.0;
        let height = select(base, mix(base, cosine, weight), counts);
#ifdef THIN
        highest = max(height, mix(height, highest, view.thickness));
#else
        highest = max(height, highest);
#endif
    }
    return highest;
}

/// Ahead and behind.
fn horizons(march: March, bases: vec2<f32>, is_inside: bool) -> vec2<f32> {
    return vec2(horizon(march, 1.0, bases.x, is_inside), horizon(march, -1.0, bases.y, is_inside));
}

/// Cosine-weighted occlusion of a pixel, 0 to 1, from its own slices of the 2×2 pattern: those of `phase` 0 to 3.
fn hbao(phase: u32, pixel: vec2<i32>, depth: f32, around: DepthsAround) -> f32 {
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
    march.center = vec2<f32>(pixel) + 0.5;
    march.position = position;
    march.to_viewer = to_viewer;
    march.geometric = geometric_normal(view.view_from_pixel, march.center, position, to_viewer, depth, around);
    march.inverse_radius_squared = 1.0 / (radius.metres * radius.metres);

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
        var highest: vec2<f32>;
        if is_inside {
            highest = horizons(march, bases, true);
        } else {
            highest = horizons(march, bases, false);
        }
        occlusion += side_occlusion(lobe, bases.x, highest.x, 1.0)
            + side_occlusion(lobe, bases.y, highest.y, -1.0);
    }
    return occlusion / f32(slices);
}
