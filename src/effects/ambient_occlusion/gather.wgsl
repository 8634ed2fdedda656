// Computes the occlusion of each texel: in a compute pass, or in a fragment pass where the format has no storage support.
#import bevy_lean_deferred::effects::ambient_occlusion::bindings::{depth_at, depth_texture, is_in_view, view}
#import bevy_lean_deferred::gbuffer::layout::is_finite
#import bevy_lean_deferred::tiles::{pixel_of_texel, place_in_tile}

#ifdef HDAO
#import bevy_lean_deferred::effects::ambient_occlusion::hdao::hdao
#else
#import bevy_lean_deferred::effects::ambient_occlusion::hbao::hbao
#import bevy_lean_deferred::reconstruction::normal_from_depth::{
    DepthView, DepthsAround, OUTSIDE, depth_or_outside, depths_around,
}
#endif

/// Offset of a phase's pixel in a 2×2 block. The order gives neighbours along an axis clearly different directions.
fn place_of(phase: u32) -> vec2<u32> {
    return vec2(phase & 1u, u32(phase == 1u || phase == 2u));
}

fn phase_at(texel: vec2<u32>) -> u32 {
    let x = texel.x & 1u;
    return select(2u - x, 3u * x, (texel.y & 1u) == 0u);
}

#ifdef HDAO
fn occlusion_of(texel: vec2<u32>, phase: u32) -> f32 {
    let pixel = pixel_of_texel(vec2<i32>(texel), i32(view.divisor), vec2<i32>(view.viewport_size));
    let depth = depth_at(pixel);
    // Sky or NaN.
    if !(depth > 0.0) {
        return 0.0;
    }
    return hdao(pixel, depth);
}
#else ifdef SHARED_DEPTHS
/// Depths of the workgroup's pixels and a border of two; `OUTSIDE` where there is no surface.
const CACHE_SIDE: i32 = 20;
var<workgroup> depths: array<f32, 400>;

/// First pixel of the workgroup.
var<private> corner: vec2<i32>;

fn read_depth(in_depth: DepthView, place: vec2<i32>, is_inside: bool) {
    depths[place.x + CACHE_SIDE * place.y] = depth_or_outside(depth_texture, in_depth, corner - 2 + place, is_inside);
}

/// Loads three columns and rows of at most eight pixels, which needs no integer division.
fn read_depths(invocation: u32) {
    let in_depth = DepthView(vec2<i32>(view.viewport_origin), vec2<i32>(view.viewport_size));
    let is_inside = is_in_view(corner - 2) && is_in_view(corner + CACHE_SIDE - 3);
    let place = vec2<i32>(place_in_tile(invocation));
    let is_in_last = place < vec2(CACHE_SIDE - 16);
    read_depth(in_depth, place, is_inside);
    read_depth(in_depth, place + vec2(8, 0), is_inside);
    read_depth(in_depth, place + vec2(0, 8), is_inside);
    read_depth(in_depth, place + 8, is_inside);
    if is_in_last.x {
        read_depth(in_depth, place + vec2(16, 0), is_inside);
        read_depth(in_depth, place + vec2(16, 8), is_inside);
    }
    if is_in_last.y {
        read_depth(in_depth, place + vec2(0, 16), is_inside);
        read_depth(in_depth, place + vec2(8, 16), is_inside);
    }
    if all(is_in_last) {
        read_depth(in_depth, place + 16, is_inside);
    }
    workgroupBarrier();
}

fn occlusion_of(texel: vec2<u32>, phase: u32) -> f32 {
    let pixel = vec2<i32>(texel);
    let place = pixel - corner + 2;
    let i = place.x + CACHE_SIDE * place.y;
    let depth = depths[i];
    if depth == OUTSIDE {
        return 0.0;
    }
    let around = DepthsAround(
        vec2(depths[i - 1], depths[i - 2]),
        vec2(depths[i + 1], depths[i + 2]),
        vec2(depths[i - CACHE_SIDE], depths[i - 2 * CACHE_SIDE]),
        vec2(depths[i + CACHE_SIDE], depths[i + 2 * CACHE_SIDE]),
    );
    return hbao(phase, texel, pixel, vec2<i32>(place_of(phase)), depth, around);
}
#else
fn occlusion_of(texel: vec2<u32>, phase: u32) -> f32 {
    let pixel = pixel_of_texel(vec2<i32>(texel), i32(view.divisor), vec2<i32>(view.viewport_size));
    let depth = depth_at(pixel);
    // Sky or NaN.
    if !(depth > 0.0) {
        return 0.0;
    }
    let in_depth = DepthView(vec2<i32>(view.viewport_origin), vec2<i32>(view.viewport_size));
    let is_inside = is_in_view(pixel - 2) && is_in_view(pixel + 2);
    return hbao(phase, texel, pixel, pixel & vec2(1), depth, depths_around(depth_texture, in_depth, pixel, is_inside));
}
#endif

fn occlusion_at(texel: vec2<u32>, phase: u32) -> f32 {
    let occlusion = occlusion_of(texel, phase);
    return select(0.0, saturate(occlusion), is_finite(occlusion));
}

#ifdef COMPUTE
#import bevy_lean_deferred::effects::ambient_occlusion::bindings::output_texture
#import bevy_lean_deferred::tiles::pixel_in_view

/// Stores a texel. Those of the last column and row are repeated, if the texture has room: the filter reads two texels further.
fn store(texel: vec2<u32>, occlusion: f32) {
    let repeated = select(vec2(0u), vec2(2u), texel + 1u == view.texture_size);
    for (var y = 0u; y <= repeated.y; y++) {
        for (var x = 0u; x <= repeated.x; x++) {
            textureStore(output_texture, texel + vec2(x, y), vec4(occlusion, 0.0, 0.0, 0.0));
        }
    }
}

/// 64 invocations compute 16×16 texels, one phase after the other, so that a subgroup samples one direction at a time.
@compute @workgroup_size(64, 1, 1)
fn compute(
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    let block = 2u * pixel_in_view(tile.xy, invocation);
#ifdef SHARED_DEPTHS
    corner = vec2<i32>(2u * pixel_in_view(tile.xy, 0u));
    read_depths(invocation);
#endif
    for (var phase = 0u; phase < 4u; phase++) {
        let texel = block + place_of(phase);
        if all(texel < view.texture_size) {
            store(texel, occlusion_at(texel, phase));
        }
    }
}
#else
@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let texel = vec2<u32>(position.xy);
    let occlusion = occlusion_at(texel, phase_at(texel));
    // The target was cleared to 0.
    if occlusion == 0.0 {
        discard;
    }
    return vec4(occlusion, 0.0, 0.0, 0.0);
}
#endif
