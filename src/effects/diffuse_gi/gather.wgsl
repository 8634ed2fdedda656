// Gathers the light on each texel from other surfaces, and the share of the hemisphere that these cover. Along slices of the
// picture, each surface above all previous ones covers an arc of the hemisphere and fills it with its light (Mayaux 2018,
// "Horizon-based indirect lighting"). Cosine-weighted in closed form, like ambient occlusion.
#import bevy_lean_deferred::gbuffer::layout::{NO_GEOMETRY, is_finite, unpack_normal}
#import bevy_lean_deferred::horizon::{PI, SliceNormal, side_occlusion, slice_normal, tangents}
#import bevy_lean_deferred::pattern::rotation_index
#import bevy_lean_deferred::reconstruction::normal_from_depth::{DepthView, depths_around, geometric_normal}
#import bevy_lean_deferred::reconstruction::position::{position_on, ray_at, ray_step}
#import bevy_lean_deferred::rounding::{Start, rounded, start_at}
#import bevy_lean_deferred::effects::diffuse_gi::bindings::{
    depth_texture, edge_step, gathered_output, levels, normal_texture, view,
}
#import bevy_lean_deferred::effects::diffuse_gi::entry::{Entry, unpack_depth, unpack_entry}
#import bevy_lean_deferred::tiles::pixel_in_view

const SLICES: u32 = #{SLICES}u;
const STEPS: u32 = #{STEPS}u;
/// Index of the coarsest level.
const LAST_LEVEL: i32 = 3;

/// Surface that receives the light.
struct Receiver {
    texel: Start,
    /// `ray_at` of the pixel from which its depth was taken.
    ray: vec2<f32>,
    /// Change of the ray per texel.
    ray_per_texel: vec2<f32>,
    position: vec3<f32>,
    to_viewer: vec3<f32>,
    geometric: vec3<f32>,
    /// A surface's weight falls by this times its squared distance.
    decline: f32,
}

/// Vector from the receiver to the surface of this depth, `texels` away on screen.
fn delta_to(receiver: Receiver, texels: vec2<f32>, depth: f32) -> vec3<f32> {
    let ray = receiver.ray + texels * receiver.ray_per_texel;
    return position_on(view.view_from_pixel, ray, depth) - receiver.position;
}

/// Horizon cosine of a surface at `delta` from the receiver; `base` if it does not count.
fn height_of(receiver: Receiver, base: f32, delta: vec3<f32>) -> f32 {
    let distance_squared = dot(delta, delta);
    let inverse_distance = inverseSqrt(distance_squared);
    let weight = saturate(view.inverse_falloff - distance_squared * receiver.decline);
    let elevation = dot(delta, receiver.geometric) * inverse_distance;
    let cosine = dot(delta, receiver.to_viewer) * inverse_distance;
    let counts = elevation > view.sin_bias && weight > 0.0;
    return select(base, mix(base, cosine, weight), counts);
}

/// Vector to the surface at `texel`, which is `texels` from the receiver, continued by half of the `gap` to the next sample: the
/// surface ends somewhere between the two. Two depths define a plane, because depth is affine on screen.
fn further_out(
    receiver: Receiver,
    texel: vec2<i32>,
    texels: vec2<f32>,
    depth: f32,
    direction: vec2<f32>,
    gap: f32,
) -> vec3<f32> {
    let step = round(direction);
    let inside = clamp(texel + vec2<i32>(step), vec2(0), vec2<i32>(view.texture_size) - 1);
    let beside = unpack_depth(textureLoad(levels, inside, 0).r);
    let slope = beside - depth;
    let is_surface = beside > 0.0 && abs(slope) < edge_step(depth, f32(view.divisor));
    let way = select(0.0, 0.5 * gap, is_surface);
    return delta_to(receiver, texels + step * way, max(depth + slope * way, 0.5 * depth));
}

/// Light of a surface times the weight with which it is known, and that weight, averaged over about as many texels as there are to
/// the next sample.
fn light_of(texel: vec2<i32>, entry: Entry, gap: f32) -> vec4<f32> {
    let level = clamp(i32(log2(max(gap, 1.0))) - 1, 0, LAST_LEVEL);
    let fine = vec4(entry.light, 1.0) * entry.known;
    if level == 0 {
        return fine;
    }
    let coarse = unpack_entry(textureLoad(levels, texel >> vec2(u32(level)), level).rg);
    let is_surface = abs(coarse.depth - entry.depth) < edge_step(entry.depth, f32(view.divisor << u32(level)));
    return select(fine, vec4(coarse.light, 1.0) * coarse.known, is_surface);
}

/// Light from one side of a slice, and in w the part of the hemisphere that it covers. Surfaces of unknown light count in neither:
/// the environment that they hide stays in their place.
fn march(
    receiver: Receiver,
    lobe: SliceNormal,
    base: f32,
    side: f32,
    direction: vec2<f32>,
    reach: f32,
    offset: f32,
) -> vec4<f32> {
    var found = vec4(0.0);
    var highest = base;
    var before = 0.0;
    for (var i = 0u; i < STEPS; i++) {
        // Denser near the texel; no sample repeats the texel or the last sample.
        let t = (f32(i) + offset) / f32(STEPS);
        let distance = max(reach * t * t, f32(i + 1u));
        let gap = max(reach * (2.0 * t + 1.0 / f32(STEPS)) / f32(STEPS), 1.0);
        let sample = rounded(receiver.texel, direction, distance);
        let texel = sample.place;
        if any(texel < vec2(0)) || any(texel >= vec2<i32>(view.texture_size)) {
            break;
        }
        let entry = unpack_entry(textureLoad(levels, texel, 0).rg);
        // The sky is no surface.
        if !(entry.depth > 0.0) {
            continue;
        }
        var height = height_of(receiver, base, delta_to(receiver, sample.step, entry.depth));
        if height > highest {
            let end = further_out(receiver, texel, sample.step, entry.depth, direction, gap);
            height = max(height, height_of(receiver, base, end));
            highest = height;
            let covered = side_occlusion(lobe, base, height, side);
            let more = max(covered - before, 0.0);
            found += light_of(texel, entry, gap) * more;
            before = max(covered, before);
        }
    }
    return found;
}

fn light_at(texel: vec2<i32>, place: vec2<u32>) -> vec4<f32> {
    let depth = unpack_depth(textureLoad(levels, texel, 0).r);
    // Without a last frame, no light is known.
    if depth == 0.0 || view.exposure_ratio == 0.0 {
        return vec4(0.0);
    }
    let pixel = texel * view.divisor;
    var receiver: Receiver;
    receiver.texel = start_at(texel, vec2(0));
    let center = vec2<f32>(pixel) + 0.5;
    receiver.ray = ray_at(view.view_from_pixel, center);
    receiver.ray_per_texel = ray_step(view.view_from_pixel, vec2(f32(view.divisor)));
    receiver.position = position_on(view.view_from_pixel, receiver.ray, depth);
#ifdef PROJECTION_ORTHOGRAPHIC
    receiver.to_viewer = vec3(0.0, 0.0, 1.0);
    var pixels = view.radius * view.pixels_per_metre;
#else
    receiver.to_viewer = normalize(-receiver.position);
    var pixels = view.radius * view.pixels_per_metre / max(-receiver.position.z, 1e-6);
#endif
    let shrink = min(view.largest_radius_in_pixels / max(abs(pixels.x), abs(pixels.y)), 1.0);
    pixels *= shrink;
    let metres = view.radius * shrink;
    // Also true of NaN.
    if !(max(abs(pixels.x), abs(pixels.y)) > f32(view.divisor)) {
        return vec4(0.0);
    }
    let texels = pixels / f32(view.divisor);
    receiver.decline = view.inverse_falloff / (metres * metres);

    let in_depth = DepthView(vec2<i32>(view.viewport_origin), vec2<i32>(view.viewport_size));
    receiver.geometric = geometric_normal(
        view.view_from_pixel, view.pixels_per_ray, center, receiver.position, receiver.to_viewer, depth,
        depths_around(depth_texture, in_depth, pixel, false),
    );
    var normal = receiver.geometric;
    let word = textureLoad(normal_texture, vec2<i32>(view.viewport_origin) + pixel, 0).r;
    if word != NO_GEOMETRY {
        normal = (view.view_from_world * vec4(unpack_normal(word), 0.0)).xyz;
        // At silhouettes, depth may belong to another surface. No shading normal leans that far from its surface.
        if dot(normal, receiver.geometric) < 0.5 {
            receiver.geometric = normal;
        }
    }

    let basis = tangents(receiver.to_viewer);
    let turn_index = rotation_index(place);
    var found = vec4(0.0);
    for (var slice = 0u; slice < SLICES; slice++) {
        let turn = (f32(slice) + (f32(turn_index) + view.turn) / 16.0) / f32(SLICES);
        // Even in angle about the view direction, not on screen: perspective is exact off-centre too.
        let tangent = basis * vec2(cos(PI * turn), sin(PI * turn));
#ifdef PROJECTION_ORTHOGRAPHIC
        let direction = tangent.xy;
#else
        let direction = tangent.xy - tangent.z * receiver.position.xy / receiver.position.z;
#endif
        let lobe = slice_normal(normal, receiver.to_viewer, tangent);
        let surface = slice_normal(receiver.geometric, receiver.to_viewer, tangent);
        let on_screen = texels * vec2(direction.x, -direction.y);
        let reach = max(abs(on_screen.x), abs(on_screen.y));
        let step = on_screen / reach;
        // Steps are jittered too, in another order than directions.
        let offset = fract((f32((turn_index * 7u) & 15u) + 0.5) / 16.0 + 0.618 * f32(slice) + view.turn);
        found += march(receiver, lobe, -surface.sine, 1.0, step, reach, offset);
        found += march(receiver, lobe, surface.sine, -1.0, -step, reach, fract(offset + 0.5));
    }
    found /= f32(SLICES);
    // Not clamped: a single slice may exceed its share of the hemisphere, and another fall below it.
    let is_number = is_finite(found.r + found.g + found.b + found.a);
    return select(vec4(0.0), vec4(found.rgb * view.intensity, found.a), is_number);
}

/// Each workgroup gathers the texels of 32×32 that share directions, so that the invocations of a subgroup march in parallel.
@compute @workgroup_size(64, 1, 1)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    let phase = workgroup.x & 15u;
    let place = vec2(phase & 3u, phase >> 2u);
    let tile = vec2(workgroup.x >> 4u, workgroup.y);
    let texel = 4u * pixel_in_view(tile, invocation) + place;
    if all(texel < view.texture_size) {
        textureStore(gathered_output, texel, light_at(vec2<i32>(texel), place));
    }
}
