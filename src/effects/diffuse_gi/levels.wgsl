// Depth, and the light that each surface sent out in the last frame, reprojected to this one. Four levels, each half as large
// as the one before.
#import bevy_lean_deferred::reconstruction::position::homogeneous_position
#import bevy_lean_deferred::gbuffer::layout::light::unpack_light
#import bevy_lean_deferred::effects::diffuse_gi::bindings::{
    Entry, depth_texture, diffuse_light_texture, edge_step, last_levels, level_0, level_1, level_2, level_3,
    motion_texture, pack_entry, shown_exposure, view,
}
#import bevy_lean_deferred::effects::shown_exposure::light_of_whites

/// Clamp of a texel's light, in multiples of what shows as white: brighter single texels would make neighbours flicker. The total
/// light of a source is not clamped, because it may cover more texels.
const MOST_WHITES: f32 = 256.0;

/// Depth steps within which a texel of the last frame shows the same surface, which may lie between two texels.
const SAME_SURFACE: f32 = 4.0;

var<workgroup> entries_0: array<vec4<f32>, 256>;
var<workgroup> entries_1: array<vec4<f32>, 64>;
var<workgroup> entries_2: array<vec4<f32>, 16>;

/// Mean light of a texel of the last frame, which covers a pixel or 2×2.
fn light_of(texel: vec2<i32>) -> vec3<f32> {
    if view.last_divisor == 1 {
        return unpack_light(textureLoad(diffuse_light_texture, texel, 0).r);
    }
    let last_pixel = vec2<i32>(view.viewport_size) - 1;
    var light = vec3(0.0);
    for (var i = 0; i < 4; i++) {
        let pixel = min(texel * 2 + vec2(i & 1, i >> 1u), last_pixel);
        light += unpack_light(textureLoad(diffuse_light_texture, pixel, 0).r);
    }
    return light / 4.0;
}

/// Light that the surface at `pixel` sent out in the last frame; 0 if that frame did not show it.
fn last_light(pixel: vec2<i32>, depth: f32) -> vec3<f32> {
    let here = vec3(vec2<f32>(pixel) + 0.5, depth);
    let last = view.last_pixel_from_view * homogeneous_position(view.view_from_pixel, here);
    // Behind the camera, or NaN.
    if !(last.w > 0.0) {
        return vec3(0.0);
    }
    var at = last.xy / last.w;
    let expected = last.z / last.w;
    if view.has_motion != 0u {
        let motion = textureLoad(motion_texture, vec2<i32>(view.viewport_origin) + pixel, 0).rg;
        at = here.xy - motion * vec2<f32>(view.viewport_size);
    }
    if !(all(at >= vec2(0.0)) && all(at < vec2<f32>(view.viewport_size))) {
        return vec3(0.0);
    }
    // Nearest of the four texels around that shows the surface.
    let texels = (at - 0.5) / f32(view.last_divisor);
    let first = vec2<i32>(floor(texels + 1e-3));
    let along = texels - vec2<f32>(first);
    let largest = SAME_SURFACE * edge_step(expected, f32(view.last_divisor));
    var best = vec2(-1);
    var weight = 0.0;
    for (var i = 0; i < 4; i++) {
        let corner = vec2(i & 1, i >> 1u);
        let texel = min(first + corner, vec2<i32>(view.last_texture_size) - 1);
        let depth = bitcast<f32>(textureLoad(last_levels, texel, 0).r);
        let near = select(1.0 - along, along, corner == vec2(1));
        let nearness = max(near.x, 0.0) * max(near.y, 0.0) + 1e-6;
        if depth > 0.0 && abs(depth - expected) < largest && nearness > weight {
            best = texel;
            weight = nearness;
        }
    }
    if weight == 0.0 {
        return vec3(0.0);
    }
    let light = light_of(best) * view.exposure_ratio;
    let brightest = max(light.r, max(light.g, light.b));
    let bound = light_of_whites(MOST_WHITES, shown_exposure.x);
    return light * min(bound / max(brightest, 1e-6), 1.0);
}

fn entry_at(texel: vec2<u32>) -> Entry {
    let pixel = vec2<i32>(texel) * view.divisor;
    let depth = textureLoad(depth_texture, vec2<i32>(view.viewport_origin) + pixel, 0);
    var entry: Entry;
    // Sky and NaN stay 0.
    if depth > 0.0 {
        entry.depth = depth;
        if view.exposure_ratio > 0.0 {
            entry.light = last_light(pixel, depth);
        }
    }
    return entry;
}

/// Mean of the nearest surface among four texels. xyz: light, w: depth.
fn joined(a: vec4<f32>, b: vec4<f32>, c: vec4<f32>, d: vec4<f32>, pixels: f32) -> vec4<f32> {
    let depths = vec4(a.w, b.w, c.w, d.w);
    let nearest = max(max(a.w, b.w), max(c.w, d.w));
    let least = max(nearest - edge_step(nearest, pixels), 1e-30);
    let weights = vec4<f32>(depths >= vec4(least));
    let sum = a * weights.x + b * weights.y + c * weights.z + d * weights.w;
    return sum / max(dot(weights, vec4(1.0)), 1.0);
}

fn pack(entry: vec4<f32>) -> vec4<u32> {
    return pack_entry(Entry(entry.w, entry.rgb));
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
    entries_0[i] = vec4(entry.light, entry.depth);
    workgroupBarrier();

    let pixels = f32(view.divisor);
    if i < 64u {
        let place = vec2(i % 8u, i / 8u);
        let first = 2u * (place.x + 16u * place.y);
        let mean = joined(
            entries_0[first], entries_0[first + 1u], entries_0[first + 16u], entries_0[first + 17u], 2.0 * pixels,
        );
        entries_1[i] = mean;
        textureStore(level_1, workgroup.xy * 8u + place, pack(mean));
    }
    workgroupBarrier();
    if i < 16u {
        let place = vec2(i % 4u, i / 4u);
        let first = 2u * (place.x + 8u * place.y);
        let mean = joined(
            entries_1[first], entries_1[first + 1u], entries_1[first + 8u], entries_1[first + 9u], 4.0 * pixels,
        );
        entries_2[i] = mean;
        textureStore(level_2, workgroup.xy * 4u + place, pack(mean));
    }
    workgroupBarrier();
    if i < 4u {
        let place = vec2(i % 2u, i / 2u);
        let first = 2u * (place.x + 4u * place.y);
        let mean = joined(
            entries_2[first], entries_2[first + 1u], entries_2[first + 4u], entries_2[first + 5u], 8.0 * pixels,
        );
        textureStore(level_3, workgroup.xy * 2u + place, pack(mean));
    }
}
