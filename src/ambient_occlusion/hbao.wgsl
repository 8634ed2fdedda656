// Horizon-based ambient occlusion: Bavoil and Sainz 2008, "Image-space horizon-based ambient occlusion".
#define_import_path bevy_lean_deferred::ambient_occlusion::hbao

#import bevy_lean_deferred::ambient_occlusion::bindings::{
    depth_texture, direction_to_viewer, is_in_view, largest_side, radius_at, view,
}
#import bevy_lean_deferred::horizon::{side_occlusion, slice_normal, tangents}
#import bevy_lean_deferred::reconstruction::normal_from_depth::{DepthsAround, geometric_normal}
#import bevy_lean_deferred::reconstruction::position::{position_on, ray_at, ray_step, ray_slope}
#import bevy_lean_deferred::rounding::{Start, rounded, start_at}

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

/// A slice.
struct March {
    pixel: Start,
    /// `ray_at` its centre.
    ray: vec2<f32>,
    position: vec3<f32>,
    to_viewer: vec3<f32>,
    geometric: vec3<f32>,
    /// On screen; its longer side is a pixel long.
    direction: vec2<f32>,
    /// `steps.x` x² + `steps.y` x is how many pixels step x is away along that side: they lie closer together near the pixel.
    steps: vec2<f32>,
    /// How much samples weigh less by the square of their distance.
    decline: f32,
    /// Where the first step ahead stands between two, 0 to 1.
    offset: f32,
}

/// Cosine of the angle between the viewer and the highest sample on one `side`, 1 or -1; `base` if none is above the surface.
/// Samples outside of the view are read too, so that nothing keeps them from being read all at once.
fn horizon(march: March, side: f32, base: f32) -> f32 {
    let offset = select(fract(march.offset + 0.5), march.offset, side > 0.0);
    // The distance of the first, and how much it grows with each.
    let at_first = (march.steps.x * offset + march.steps.y) * offset;
    let growth = 2.0 * march.steps.x * offset + march.steps.y;
    // Above `base`.
    var highest = 0.0;
    for (var i = 0u; i < steps_on_each_side(); i++) {
        let x = f32(i);
        // Never the pixel itself, nor the one before.
        let distance = max(at_first + x * growth + x * x * march.steps.x, x + 1.0);
        let sample = rounded(march.pixel, march.direction, side * distance);
        // Beyond the view it may be anything.
        let depth = textureLoad(depth_texture, vec2<i32>(view.viewport_origin) + sample.place, 0);
        let ray = march.ray + ray_step(view.view_from_pixel, sample.step);
        let delta = position_on(view.view_from_pixel, ray, depth) - march.position;
        let distance_squared = dot(delta, delta);
        let inverse_distance = inverseSqrt(distance_squared);
        let weight = saturate(view.inverse_falloff - distance_squared * march.decline);
        let elevation = dot(delta, march.geometric) * inverse_distance;
        let above = dot(delta, march.to_viewer) * inverse_distance - base;
        // The sky is no occluder, though projections with a far plane place it there.
        let is_seen = is_in_view(sample.place);
        let counts = elevation > view.sin_bias && depth > 0.0 && is_seen;
        let height = select(0.0, above * weight, counts);
#ifdef THIN
        // What is not seen does not tell how thick the surfaces before it are.
        highest = select(highest, max(height, mix(height, highest, view.thickness)), is_seen);
#else
        highest = max(height, highest);
#endif
    }
    return base + highest;
}

/// By an angle; cosine and sine, of both.
fn turned(rotation: vec2<f32>, angle: vec2<f32>) -> vec2<f32> {
    return vec2(
        rotation.x * angle.x - rotation.y * angle.y,
        rotation.x * angle.y + rotation.y * angle.x,
    );
}

/// Cosine-weighted occlusion of a pixel, 0 to 1, from its own slices of the pattern: those of `phase` 0 to 3.
fn hbao(phase: u32, pixel: vec2<i32>, depth: f32, around: DepthsAround) -> f32 {
    let center = vec2<f32>(pixel) + 0.5;
    let ray = ray_at(view.view_from_pixel, center);
    let position = position_on(view.view_from_pixel, ray, depth);
    let radius = radius_at(position, depth);
    // Also true of what is not a number.
    if !(largest_side(radius.pixels) > 1.0) {
        return 0.0;
    }
    let to_viewer = direction_to_viewer(position);
    var march: March;
    march.pixel = start_at(pixel);
    march.ray = ray;
    march.position = position;
    march.to_viewer = to_viewer;
    march.geometric = geometric_normal(
        view.view_from_pixel, view.pixels_per_ray, center, position, to_viewer, depth, around,
    );
    march.decline = view.decline * radius.excess * radius.excess;

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

    // The steps are spread over 4×4 texels, and with a wide filter the directions too. What a narrow one leaves of that pattern is
    // a fine dither, not stripes.
    let quad = (vec2<u32>(pixel) / (2u * #{DIVISOR}u)) & vec2(1u);
    let block = quad.x + 2u * quad.y;
#ifdef WIDE_PATTERN
    var rotation = turned(view.rotations[phase].xy, view.rotations[block].zw);
    let offset = 0.125 + 0.25 * f32(phase + 2u * block) + 0.0625 * f32(block) + view.turn;
#else
    var rotation = view.rotations[phase].xy;
    let offset = 0.125 + 0.25 * f32(phase + block) + view.turn;
#endif

    let basis = tangents(to_viewer);
    let slope = ray_slope(view.view_from_pixel, ray, position);
    let slices = slice_count();
    var occlusion = 0.0;
    for (var slice = 0u; slice < slices; slice++) {
        // Evenly about the view direction, not on the screen: so perspective is exact off its centre too.
        let tangent = basis * rotation;
        rotation = turned(rotation, view.slice_rotation);
        let direction = tangent.xy - tangent.z * slope;
        let lobe = slice_normal(normal, to_viewer, tangent);
        let surface = slice_normal(march.geometric, to_viewer, tangent);
        // The surface's own horizons.
        let bases = vec2(-surface.sine, surface.sine);

        let on_screen = radius.pixels * vec2(direction.x, -direction.y);
        let longer_side = largest_side(on_screen);
        march.direction = on_screen / longer_side;
        let part = 0.5 / f32(steps_on_each_side());
        march.steps = longer_side * part * vec2(2.0 * part, 1.0);
        march.offset = fract(offset + 0.618 * f32(slice));
        occlusion += side_occlusion(lobe, bases.x, horizon(march, 1.0, bases.x), 1.0)
            + side_occlusion(lobe, bases.y, horizon(march, -1.0, bases.y), -1.0);
    }
    return occlusion / f32(slices);
}
