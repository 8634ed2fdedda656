// History for the next frame: light and distance per pixel. Each coarser level is half as large as the one before. It holds the
// light of surfaces times their share, and that share, so that the sky does not enter their mean. Two dispatches: the first makes
// four levels from the picture, the second (OF_LEVEL) three more from the last of these.
#import bevy_lean_deferred::gbuffer::layout::is_nan
#import bevy_lean_deferred::gbuffer::layout::light::{pack_halves, unpack_halves}
#import bevy_lean_deferred::reconstruction::position::view_position
#import bevy_lean_deferred::effects::shown_exposure::light_of_whites
#import bevy_lean_deferred::tiles::{TILE_SIDE, place_in_tile}

/// Pixel coordinates are relative to the viewport's corner.
struct HistoryUniform {
    /// From (pixel x, pixel y, depth, 1) to view space, homogeneous.
    view_from_pixel: mat4x4<f32>,
    viewport_origin: vec2<u32>,
    viewport_size: vec2<u32>,
    /// Scale of the stored distances.
    units_per_metre: f32,
}

/// Picture after the main passes, or the last level of the first dispatch.
@group(0) @binding(0) var color_texture: texture_2d<f32>;
/// Levels to be made, largest first.
@group(0) @binding(1) var level_0: texture_storage_2d<rgba16float, write>;
@group(0) @binding(2) var level_1: texture_storage_2d<rgba16float, write>;
@group(0) @binding(3) var level_2: texture_storage_2d<rgba16float, write>;
#ifndef OF_LEVEL
@group(0) @binding(4) var level_3: texture_storage_2d<rgba16float, write>;
@group(0) @binding(5) var<uniform> view: HistoryUniform;
@group(0) @binding(6) var depth_texture: texture_depth_2d;
/// x: exposure with which the last frame was shown, in stops.
@group(0) @binding(7) var<uniform> shown_exposure: vec4<f32>;
#endif

/// Clamp of a pixel's light, in multiples of what shows as white: brighter single pixels would make rough mirrors flicker. The
/// total light of a source is not clamped, because it may cover more pixels.
const MOST_WHITES: f32 = 1024.0;

/// Stored distance of the sky, which is no surface, and of all that is beyond the range of stored distances.
const NO_SURFACE: f32 = 65504.0;

/// Shares of 16×16, 8×8 and 4×4 texels, in half floats like the textures.
var<workgroup> shares: array<vec2<u32>, 336>;

/// Contribution of a texel to coarser levels: light of surfaces, and their share.
fn share_of(texel: vec4<f32>) -> vec4<f32> {
#ifdef OF_LEVEL
    return texel;
#else
    let is_surface = texel.a != NO_SURFACE;
    return select(vec4(0.0), vec4(texel.rgb, 1.0), is_surface);
#endif
}

#ifdef OF_LEVEL
fn texel_at(place: vec2<u32>) -> vec4<f32> {
    let last = textureDimensions(color_texture) - 1u;
    return textureLoad(color_texture, vec2<i32>(min(place, last)), 0);
}
#else
/// Replaces NaN by 0, and clamps bright light without changing its hue.
fn bounded(light: vec3<f32>) -> vec3<f32> {
    let largest = light_of_whites(MOST_WHITES, shown_exposure.x);
    let number = select(light, vec3(0.0), is_nan(light.r + light.g + light.b));
    let finite = clamp(number, vec3(0.0), vec3(65504.0));
    let brightest = max(finite.r, max(finite.g, finite.b));
    return finite * min(largest / max(brightest, 1e-6), 1.0);
}

/// Light and distance at `place`; beyond the viewport, of its last pixels.
fn texel_at(place: vec2<u32>) -> vec4<f32> {
    let inside = min(place, view.viewport_size - 1u);
    let pixel = vec2<i32>(view.viewport_origin + inside);
    let light = bounded(textureLoad(color_texture, pixel, 0).rgb);
    let depth = textureLoad(depth_texture, pixel, 0);
    var distance = NO_SURFACE;
    if depth > 0.0 {
        distance = -view_position(view.view_from_pixel, vec3(vec2<f32>(inside) + 0.5, depth)).z * view.units_per_metre;
    }
    return vec4(light, clamp(distance, -NO_SURFACE, NO_SURFACE));
}
#endif

fn store(level: u32, place: vec2<u32>, texel: vec4<f32>) {
#ifdef OF_LEVEL
    switch level {
        case 1u: { textureStore(level_0, place, texel); }
        case 2u: { textureStore(level_1, place, texel); }
        case 3u: { textureStore(level_2, place, texel); }
        default: {}
    }
#else
    switch level {
        case 0u: { textureStore(level_0, place, texel); }
        case 1u: { textureStore(level_1, place, texel); }
        case 2u: { textureStore(level_2, place, texel); }
        default: { textureStore(level_3, place, texel); }
    }
#endif
}

/// Stores a texel, and keeps its share for coarser levels.
fn keep(corner: vec2<u32>, in_square: vec2<u32>, texel: vec4<f32>) {
    store(0u, corner + in_square, texel);
    shares[in_square.x + 16u * in_square.y] = pack_halves(share_of(texel));
}

/// Makes the means of 2×2 of the `side` × `side` shares from `first` on. Compilers optimise constant arguments better than a loop.
fn make_level(level: u32, first: u32, side: u32, workgroup: vec2<u32>, i: u32) {
    workgroupBarrier();
    let half_side = side / 2u;
    if i < half_side * half_side {
        let place = vec2(i % half_side, i / half_side);
        let corner = first + 2u * (place.x + side * place.y);
        let above = unpack_halves(shares[corner]) + unpack_halves(shares[corner + 1u]);
        let below = unpack_halves(shares[corner + side]) + unpack_halves(shares[corner + side + 1u]);
        let mean = 0.25 * (above + below);
        // The last shares, 2×2, are not read.
        if level < 3u {
            shares[first + side * side + i] = pack_halves(mean);
        }
        store(level, workgroup * half_side + place, mean);
    }
}

/// 64 invocations read 16×16 texels, level 0 here, and make the coarser levels above them.
@compute @workgroup_size(64, 1, 1)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) i: u32) {
    // A subgroup's texels form a square, which memory serves faster than rows.
    let in_tile = place_in_tile(i);
    let right = in_tile + vec2(TILE_SIDE, 0u);
    let below = in_tile + vec2(0u, TILE_SIDE);
    let corner = workgroup.xy * 16u;
    // All reads are issued before the first is used.
    let texel_0 = texel_at(corner + in_tile);
    let texel_1 = texel_at(corner + right);
    let texel_2 = texel_at(corner + below);
    let texel_3 = texel_at(corner + in_tile + TILE_SIDE);
    keep(corner, in_tile, texel_0);
    keep(corner, right, texel_1);
    keep(corner, below, texel_2);
    keep(corner, in_tile + TILE_SIDE, texel_3);
    make_level(1u, 0u, 16u, workgroup.xy, i);
    make_level(2u, 256u, 8u, workgroup.xy, i);
    make_level(3u, 320u, 4u, workgroup.xy, i);
}
