// Resolves the reflection of each pixel from the rays around it. A rough mirror interpolates the lobes around it. A smooth one
// has the light of one point: the end of its own ray, which is as long as those beside it.
#import bevy_lean_deferred::effects::reflections::bindings::{depth_texture, output_texture, view, view_position}
#import bevy_lean_deferred::effects::reflections::receiver::{Receiver, likeness_beside, rays_beside}
#import bevy_lean_deferred::effects::reflections::rough_light::{keep_lobe, lobe_at, rough_light}
#import bevy_lean_deferred::effects::reflections::smooth_light::smooth_light
#import bevy_lean_deferred::effects::reflections::surface::{ROUGH, mirror_of, normal_word_at, smoothness}
#import bevy_lean_deferred::effects::reflections::texels::{
    CACHE_SIDE, DIVISOR, FIRST_MADE, INVOCATIONS, WORKGROUP_SIDE, inverse_step_at, keep, slope_at, texel_at,
}
#import bevy_lean_deferred::tiles::{TILE_SIDE as TILE, place_in_tile}
#import bevy_lean_deferred::workgroup::is_any

/// Radius of a lobe at its hit, in texels: up to the first it counts as a single point, from the second on as the mean of rays.
const SMOOTH_UP_TO: f32 = 1.0;
const ROUGH_FROM: f32 = 2.0;
/// The same where that point is uncertain: a single ray would show as a speck.
const UNCERTAIN_UP_TO: f32 = 0.125;
const UNCERTAIN_FROM: f32 = 0.5;

/// Side of a tile in pixels, and of a workgroup's output in tiles.
const TILE_SIDE: i32 = i32(TILE);
const TILES_SIDE: u32 = u32(WORKGROUP_SIDE / TILE_SIDE);

/// Light and confidence. `first` is the first of the four texels around the pixel, which is `along` of the way to the others.
fn light_at(pixel: vec2<i32>, first: i32, along: vec2<f32>) -> vec4<f32> {
    let depth = textureLoad(depth_texture, vec2<i32>(view.viewport_origin) + pixel, 0);
    let mirror = mirror_of(pixel, normal_word_at(pixel));
    let fade = smoothness(mirror.roughness) * view.intensity;
    if !(depth > 0.0) || fade == 0.0 {
        return vec4(0.0);
    }
    var receiver: Receiver;
    receiver.at = vec2<f32>(pixel) + 0.5;
    receiver.depth = depth;
    receiver.normal = mirror.normal;
    receiver.roughness = mirror.roughness;
    receiver.slope = slope_at(first);
    receiver.inverse_step = inverse_step_at(depth);
    // Used by smooth and rough light.
    for (var i = 0; i < 4; i++) {
        receiver.alike[i] = likeness_beside(receiver, first, i, along);
    }
    let alpha = mirror.roughness * mirror.roughness;
    // Rays that change from frame to frame are shown only as a mean.
    var radius = 2.0 * ROUGH_FROM;
    var changes = true;
    if mirror.roughness <= ROUGH {
        let beside = rays_beside(receiver, first, view_position(receiver.at, depth));
        changes = beside.changes;
        radius = select(alpha * beside.width / f32(DIVISOR), radius, changes && !beside.has_hit);
    }
    var roughness = smoothstep(SMOOTH_UP_TO, ROUGH_FROM, radius);
    var light = vec4(0.0);
    if roughness < 1.0 {
        let found = smooth_light(receiver, first, along);
        if !found.is_certain {
            roughness = max(roughness, smoothstep(UNCERTAIN_UP_TO, UNCERTAIN_FROM, radius));
            roughness = select(roughness, 1.0, changes && !found.is_met);
        }
        light += (1.0 - roughness) * found.light;
    }
    if roughness > 0.0 {
        light += roughness * rough_light(receiver, first, along);
    }
    return vec4(light.rgb / max(light.a, 1e-6), light.a * fade);
}

@compute @workgroup_size(INVOCATIONS, 1, 1)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) invocation: u32) {
    let i = i32(invocation);
    let corner = vec2<i32>(workgroup.xy) * WORKGROUP_SIDE;
    var mirrors = false;
    for (var read = i; read < CACHE_SIDE * CACHE_SIDE; read += INVOCATIONS) {
        let texel = texel_at(corner / DIVISOR, read);
        let lobe = lobe_at(texel.place);
        let counts = keep(read, texel);
        keep_lobe(read, lobe, counts);
        mirrors |= counts;
    }
    let is_empty = !is_any(mirrors, invocation);
    // By tiles of 8×8, so that a subgroup's pixels form a square. An invocation has the same place in all of its tiles.
    let in_tile = place_in_tile(invocation % 64u);
    let along = vec2<f32>(in_tile % u32(DIVISOR)) / f32(DIVISOR);
    let texel = vec2<i32>(in_tile / u32(DIVISOR));
    let first = texel.x + CACHE_SIDE * texel.y + FIRST_MADE;
    for (var tile = invocation / 64u; tile < TILES_SIDE * TILES_SIDE; tile += u32(INVOCATIONS) / 64u) {
        let beside = vec2<i32>(vec2(tile % TILES_SIDE, tile / TILES_SIDE));
        let pixel = corner + vec2<i32>(in_tile) + TILE_SIDE * beside;
        if all(pixel < vec2<i32>(view.viewport_size)) {
            var light = vec4(0.0);
            if !is_empty {
                light = light_at(pixel, first + TILE_SIDE / DIVISOR * (beside.x + CACHE_SIDE * beside.y), along);
            }
            textureStore(output_texture, pixel, light);
        }
    }
}
