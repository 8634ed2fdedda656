// Resolves the reflection of each pixel from the rays around it. A rough mirror interpolates the lobes around it. A smooth one
// has the light of one point: the end of its own ray, which is as long as those beside it.
#import bevy_lean_deferred::effects::reflections::bindings::{depth_texture, output_texture, view, view_position}
#import bevy_lean_deferred::effects::reflections::receiver::{rays_beside, receiver_at}
#import bevy_lean_deferred::effects::reflections::rough_light::{keep_lobe, lobe_at, rough_light}
#import bevy_lean_deferred::effects::reflections::smooth_light::smooth_light
#import bevy_lean_deferred::effects::reflections::surface::{ROUGH, mirror_of, normal_word_at, smoothness}
#import bevy_lean_deferred::effects::reflections::texels::{
    CACHE_SIDE, DIVISOR, FIRST_MADE, INVOCATIONS, WORKGROUP_SIDE, keep, texel_at,
}
#import bevy_lean_deferred::tiles::{TILE_SIDE as TILE, place_in_tile}
#import bevy_lean_deferred::workgroup::is_any

/// Radius of a lobe at its hit, in texels: up to the first it counts as a single point, from the second on as the mean of rays.
const SMOOTH_UP_TO: f32 = 1.0;
const ROUGH_FROM: f32 = 2.0;
/// The same where that point is uncertain: a single ray would show as a speck.
const UNCERTAIN_UP_TO: f32 = 0.125;
const UNCERTAIN_FROM: f32 = 0.5;

/// Side of a workgroup's output in tiles.
const TILES_SIDE: u32 = u32(WORKGROUP_SIDE) / TILE;

/// Light and confidence at a pixel, whose centre is `at`. `first` is the first of the four texels around it, which is `along` of the way to
/// the others.
fn light_at(at: vec2<f32>, first: i32, along: vec2<f32>) -> vec4<f32> {
    let pixel = vec2<i32>(at);
    let depth = textureLoad(depth_texture, vec2<i32>(view.viewport_origin) + pixel, 0);
    let mirror = mirror_of(pixel, normal_word_at(pixel));
    // Without a surface, or with a fade of 0.
    if !(min(depth, (view.max_roughness - mirror.roughness) * view.intensity) > 0.0) {
        return vec4(0.0);
    }
    let receiver = receiver_at(at, depth, mirror, first, along);
    let alpha = mirror.roughness * mirror.roughness;
    // Rays that change from frame to frame are shown only as a mean.
    var radius = 2.0 * ROUGH_FROM;
    var changes = true;
    if mirror.roughness <= ROUGH {
        let beside = rays_beside(receiver, first, view_position(receiver.at, depth));
        changes = beside.changes;
        radius = select(alpha * beside.width / f32(DIVISOR), radius, changes && !beside.has_hit);
    }
    var light = vec4(0.0);
    // Share of the mean of rays.
    var roughness = 1.0;
    if radius < ROUGH_FROM {
        let found = smooth_light(receiver, first);
        let up_to = select(UNCERTAIN_UP_TO, SMOOTH_UP_TO, found.is_certain);
        let inverse_range = select(1.0 / (UNCERTAIN_FROM - UNCERTAIN_UP_TO), 1.0 / (ROUGH_FROM - SMOOTH_UP_TO), found.is_certain);
        roughness = select(smoothstep(0.0, 1.0, (radius - up_to) * inverse_range), 1.0, changes && !found.is_met);
        // Rays around the pixel stand for light that the last frame did not show at its hit.
        roughness = max(roughness, 1.0 - found.known);
        light = (1.0 - roughness) * found.light;
    }
    if roughness > 0.0 {
        light += roughness * rough_light(receiver, first);
    }
    let fade = smoothness(mirror.roughness) * view.intensity;
    return vec4(light.rgb / max(light.a, 1e-6), light.a * fade);
}

/// Corner of a tile among those of the workgroup, in pixels.
fn tile_place(tile: u32) -> vec2<u32> {
    return vec2(tile % TILES_SIDE, tile / TILES_SIDE) * TILE;
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
    // By tiles of 8×8, so that a subgroup's pixels form a square. An invocation has the same place in all of its tiles, in one register.
    let first_tile = tile_place(invocation / 64u);
    let place = place_in_tile(invocation % 64u) + first_tile;
    let packed = place.x | (place.y << 8u);
    for (var tile = 0u; tile < TILES_SIDE * TILES_SIDE; tile += u32(INVOCATIONS) / 64u) {
        let in_tile = vec2(packed & 0xffu, packed >> 8u);
        let beside = tile_place(tile);
        let pixel = corner + vec2<i32>(beside + in_tile);
        if all(pixel < vec2<i32>(view.viewport_size)) {
            let at = vec2<f32>(pixel) + 0.5;
            var light = vec4(0.0);
            if !is_empty {
                let along = vec2<f32>(in_tile % u32(DIVISOR)) / f32(DIVISOR);
                let texel = vec2<i32>(in_tile / u32(DIVISOR)) + vec2<i32>(beside / u32(DIVISOR));
                light = light_at(at, texel.x + CACHE_SIDE * texel.y + FIRST_MADE, along);
            }
            // Not `pixel`, which would keep registers in use until here.
            textureStore(output_texture, vec2<i32>(at), light);
        }
    }
}
