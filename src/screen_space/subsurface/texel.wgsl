// The texels of listed tiles, and where texels are.
#define_import_path bevy_lean_deferred::screen_space::subsurface::texel

#import bevy_lean_deferred::lighting::subsurface_light::{COUNT, TILES}
#import bevy_lean_deferred::screen_space::subsurface::bindings::{tiles, view}

struct Texel {
    exists: bool,
    place: vec2<i32>,
}

/// How many groups of 64 texels of this level the listed tiles have. The workgroups of a pass share them.
fn count_of_groups() -> u32 {
    let each = 1u << (2u * view.level);
    return (tiles[COUNT] + each - 1u) / each;
}

/// One of the level that this pass writes, of a listed tile, which has 8, 4, 2 or 1 of them a side.
fn listed_texel(group: u32, invocation: u32) -> Texel {
    let side_log = 3u - view.level;
    let index = (group << (2u * view.level)) + (invocation >> (2u * side_log));
    if index >= tiles[COUNT] {
        return Texel(false, vec2(0));
    }
    let tile = tiles[TILES + index];
    let corner = vec2(tile & 0xffffu, tile >> 16u) >> vec2(view.level);
    let last = (1u << side_log) - 1u;
    return Texel(true, vec2<i32>(corner + vec2(invocation & last, (invocation >> side_log) & last)));
}

/// All that set it write the same.
var<workgroup> any_flag: u32;

/// Whether `condition` holds for any invocation of the workgroup. A barrier, also for its other memory.
fn is_any(condition: bool, invocation: u32) -> bool {
    if invocation == 0u {
        any_flag = 0u;
    }
    workgroupBarrier();
    if condition {
        any_flag = 1u;
    }
    return workgroupUniformLoad(&any_flag) != 0u;
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
