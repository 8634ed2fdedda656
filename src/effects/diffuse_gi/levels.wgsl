// Depth, and the light that each surface sent out in the last frame, reprojected to this one. Four levels, each half as large
// as the one before.
#import bevy_lean_deferred::reconstruction::position::homogeneous_position
#import bevy_lean_deferred::gbuffer::layout::light::unpack_light
#import bevy_lean_deferred::effects::diffuse_gi::bindings::{
    diffuse_light_texture, edge_step, last_levels, level_0, level_1, level_2, level_3, motion_texture,
    shown_exposure, view,
}
#import bevy_lean_deferred::effects::diffuse_gi::entry::{Entry, pack_entry, unpack_depth}
#import bevy_lean_deferred::effects::diffuse_gi::shown_pixel::shown_pixel
#import bevy_lean_deferred::effects::reprojection::{filled_up, own_motion, weight_of_match}
#import bevy_lean_deferred::effects::shown_exposure::light_of_whites

/// Clamp of a texel's light, in multiples of what shows as white: brighter single texels would make neighbours flicker. The total
/// light of a source is not clamped, because it may cover more texels.
const MOST_WHITES: f32 = 256.0;

/// Depth steps within which a texel of the last frame shows the same surface, which may lie between two texels. Its weight is 0
/// from twice as many on.
const SAME_SURFACE: f32 = 2.0;
/// Depth steps by which a surface may have moved towards the camera or away from it for each pixel that it moved across on its own: a
/// step is eight pixels deep (`STEEPEST`).
const DEEP_PER_PIXEL: f32 = 0.125;

/// Light times the weight with which it is known, and depth.
var<workgroup> entries_0: array<vec4<f32>, 256>;
var<workgroup> entries_1: array<vec4<f32>, 64>;
var<workgroup> entries_2: array<vec4<f32>, 16>;
/// These weights.
var<workgroup> known_0: array<f32, 256>;
var<workgroup> known_1: array<f32, 64>;
var<workgroup> known_2: array<f32, 16>;

/// Mean light of a texel of the last frame, which covers a pixel or 2×2.
fn light_of(texel: vec2<i32>) -> vec3<f32> {
    if view.last_divisor == 1 {
        return unpack_light(textureLoad(diffuse_light_texture, texel, 0).r);
    }
    let last_pixel = vec2<i32>(view.last_viewport_size) - 1;
    var light = vec3(0.0);
    for (var i = 0; i < 4; i++) {
        let pixel = min(texel * 2 + vec2(i & 1, i >> 1u), last_pixel);
        light += unpack_light(textureLoad(diffuse_light_texture, pixel, 0).r);
    }
    return light / 4.0;
}

/// Depth step within which the last frame shows the same surface.
fn tolerance_at(depth: f32) -> f32 {
    return SAME_SURFACE * edge_step(depth, f32(view.last_divisor));
}

/// Light that the last frame showed around `at`, in its pixels, on the surface whose depth was `at_rest`, `with_view`, or between
/// the two. w: the weight, 0 to 1, with which it is that surface. `corner`: pixel of this frame's texel that shows it, as that of the
/// last frame's did.
fn light_around(at: vec2<f32>, corner: vec2<f32>, at_rest: f32, with_view: f32, tolerance: f32) -> vec4<f32> {
    if !(all(at >= vec2(0.0)) && all(at < vec2<f32>(view.last_viewport_size))) {
        return vec4(0.0);
    }
    // Of the four texels around, the nearest one that shows the surface.
    let texels = (at - 0.5 - corner) / f32(view.last_divisor);
    let first = vec2<i32>(floor(texels + 1e-3));
    let along = texels - vec2<f32>(first);
    var best = vec2(-1);
    var best_weight = 0.0;
    var known = 0.0;
    for (var i = 0; i < 4; i++) {
        let corner = vec2(i & 1, i >> 1u);
        let texel = clamp(first + corner, vec2(0), vec2<i32>(view.last_texture_size) - 1);
        let kept = unpack_depth(textureLoad(last_levels, texel, 0).r);
        let alike = select(0.0, weight_of_match(kept, at_rest, with_view, tolerance), kept > 0.0);
        let near = select(1.0 - along, along, corner == vec2(1));
        let weight = alike * (max(near.x, 0.0) * max(near.y, 0.0) + 1e-6);
        if weight > best_weight {
            best = texel;
            best_weight = weight;
            known = alike;
        }
    }
    if known == 0.0 {
        return vec4(0.0);
    }
    return vec4(light_of(best), known);
}

/// Light that the surface at `pixel` sent out in the last frame. w: the weight, 0 to 1, with which it is known.
fn last_light(pixel: vec2<i32>, depth: f32) -> vec4<f32> {
    let here = vec2<f32>(pixel) + 0.5;
    let last = view.last_pixel_from_view * homogeneous_position(view.view_from_pixel, vec3(here, depth));
    // Not behind the camera, nor NaN.
    let was_in_front = last.w > 0.0;
    let at_rest = select(vec3(-1.0), last.xyz / last.w, was_in_front);
    let last_size = vec2<f32>(view.last_viewport_size);
    let corner = vec2<f32>(pixel & vec2(min(view.divisor, view.last_divisor) - 1));
    // A surface that moves with the camera stays where it is, and keeps its depth while the projection does.
    let with_view = here / vec2<f32>(view.viewport_size) * last_size;
    var at = at_rest.xy;
    var expected = vec2(at_rest.z);
    var tolerance = tolerance_at(at_rest.z);
    if view.has_motion != 0u {
        let motion = textureLoad(motion_texture, vec2<i32>(view.viewport_origin) + pixel, 0).rg;
        at = with_view - motion * last_size;
        expected = vec2(select(depth, at_rest.z, was_in_front), depth);
        let own = DEEP_PER_PIXEL * own_motion(at, at_rest.xy, with_view);
        tolerance = tolerance_at(depth) + edge_step(depth, own) + view.approach.x * depth + view.approach.y;
    }
    // At rest, surfaces that were behind the camera are outside of the view: `at` is negative.
    var light = light_around(at, corner, expected.x, expected.y, tolerance);
    if view.has_motion == 0u && view.carries_surfaces != 0u && light.w < 1.0 {
        light = filled_up(light, light_around(with_view, corner, depth, depth, tolerance_at(depth)));
    }
    return light;
}

/// Light of the last frame at this frame's exposure, bounded.
fn exposed(light: vec3<f32>) -> vec3<f32> {
    let now = light * view.exposure_ratio;
    let brightest = max(now.r, max(now.g, now.b));
    let bound = light_of_whites(MOST_WHITES, shown_exposure.x);
    return now * min(bound / max(brightest, 1e-6), 1.0);
}

fn entry_at(texel: vec2<u32>) -> Entry {
    let shown = shown_pixel(vec2<i32>(texel));
    var entry: Entry;
    // Sky and NaN stay 0.
    if shown.depth > 0.0 {
        entry.depth = shown.depth;
        entry.pixel = shown.number;
        if view.exposure_ratio > 0.0 {
            let last = last_light(shown.place, shown.depth);
            entry.light = exposed(last.rgb);
            entry.known = last.w;
        }
    }
    return entry;
}

/// Mean of four texels: light times the weight with which it is known, depth, and that weight.
struct Mean {
    entry: vec4<f32>,
    known: f32,
}

/// Mean of the nearest surface among four texels.
fn joined(a: vec4<f32>, b: vec4<f32>, c: vec4<f32>, d: vec4<f32>, known: vec4<f32>, pixels: f32) -> Mean {
    let depths = vec4(a.w, b.w, c.w, d.w);
    let nearest = max(max(a.w, b.w), max(c.w, d.w));
    let least = max(nearest - edge_step(nearest, pixels), 1e-30);
    let weights = vec4<f32>(depths >= vec4(least));
    let sum = a * weights.x + b * weights.y + c * weights.z + d * weights.w;
    let count = max(dot(weights, vec4(1.0)), 1.0);
    return Mean(sum / count, dot(weights, known) / count);
}

fn pack(mean: Mean) -> vec4<u32> {
    return pack_entry(Entry(mean.entry.w, mean.entry.rgb / max(mean.known, 1e-6), mean.known, 0u));
}

/// 256 invocations make 16×16 texels and the coarser levels above them.
@compute @workgroup_size(256, 1, 1)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) i: u32) {
    let place = vec2(i % 16u, i / 16u);
    let texel = workgroup.xy * 16u + place;
    var entry: Entry;
    if all(texel < view.texture_size) {
        entry = entry_at(texel);
        textureStore(level_0, texel, pack_entry(entry));
    }
    entries_0[i] = vec4(entry.light * entry.known, entry.depth);
    known_0[i] = entry.known;
    workgroupBarrier();

    let pixels = f32(view.divisor);
    if i < 64u {
        let place = vec2(i % 8u, i / 8u);
        let first = 2u * (place.x + 16u * place.y);
        let mean = joined(
            entries_0[first], entries_0[first + 1u], entries_0[first + 16u], entries_0[first + 17u],
            vec4(known_0[first], known_0[first + 1u], known_0[first + 16u], known_0[first + 17u]),
            2.0 * pixels,
        );
        entries_1[i] = mean.entry;
        known_1[i] = mean.known;
        textureStore(level_1, workgroup.xy * 8u + place, pack(mean));
    }
    workgroupBarrier();
    if i < 16u {
        let place = vec2(i % 4u, i / 4u);
        let first = 2u * (place.x + 8u * place.y);
        let mean = joined(
            entries_1[first], entries_1[first + 1u], entries_1[first + 8u], entries_1[first + 9u],
            vec4(known_1[first], known_1[first + 1u], known_1[first + 8u], known_1[first + 9u]),
            4.0 * pixels,
        );
        entries_2[i] = mean.entry;
        known_2[i] = mean.known;
        textureStore(level_2, workgroup.xy * 4u + place, pack(mean));
    }
    workgroupBarrier();
    if i < 4u {
        let place = vec2(i % 2u, i / 2u);
        let first = 2u * (place.x + 4u * place.y);
        let mean = joined(
            entries_2[first], entries_2[first + 1u], entries_2[first + 4u], entries_2[first + 5u],
            vec4(known_2[first], known_2[first + 1u], known_2[first + 4u], known_2[first + 5u]),
            8.0 * pixels,
        );
        textureStore(level_3, workgroup.xy * 2u + place, pack(mean));
    }
}
