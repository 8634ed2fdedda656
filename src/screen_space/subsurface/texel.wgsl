// The texels that a pass goes over, and where they are.
#define_import_path bevy_lean_deferred::screen_space::subsurface::texel

#import bevy_lean_deferred::lighting::subsurface_light::{COUNT, TILES}
#import bevy_lean_deferred::screen_space::subsurface::bindings::{tiles, view}

/// Workgroups a row of an indirect dispatch: the list may be longer than a dispatch may be wide.
const COLUMNS: u32 = 32768u;

struct Texel {
    exists: bool,
    place: vec2<i32>,
}

/// Of the level that this pass writes: those of the listed tiles, where these are as large as some texels, or all of them.
fn texel_of(workgroup: vec2<u32>, invocation: u32) -> Texel {
#ifdef LISTED
    // 8, 4, 2 or 1 texels a side of a tile.
    let side_log = 3u - view.level;
    let all = workgroup.y * COLUMNS + workgroup.x;
    let index = (all << (2u * view.level)) + (invocation >> (2u * side_log));
    if index >= tiles[COUNT] {
        return Texel(false, vec2(0));
    }
    let tile = tiles[TILES + index];
    let corner = vec2(tile & 0xffffu, tile >> 16u) >> vec2(view.level);
    let place = vec2(invocation & ((1u << side_log) - 1u), (invocation >> side_log) & ((1u << side_log) - 1u));
    return Texel(true, vec2<i32>(corner + place));
#else
    let place = workgroup * 8u + vec2(invocation & 7u, invocation >> 3u);
    return Texel(all(place < view.level_size), vec2<i32>(place));
#endif
}

/// Along the vertical axis, at so many metres.
fn pixels_per_metre_at(metres: f32) -> f32 {
#ifdef PROJECTION_ORTHOGRAPHIC
    return abs(view.pixels_per_metre.y);
#else
    return abs(view.pixels_per_metre.y) / max(metres, 1e-6);
#endif
}

/// In view space, towards the viewer, from a pixel.
fn to_viewer(pixel: vec2<f32>) -> vec3<f32> {
#ifdef PROJECTION_ORTHOGRAPHIC
    return vec3(0.0, 0.0, 1.0);
#else
    return normalize(vec3((view.center - pixel) / view.pixels_per_metre, 1.0));
#endif
}
