// Pixel of 2×2 that a texel at half resolution shows: the first one, or the nearest of the others if that is of another surface in
// front of it that no texel would show otherwise. So things a pixel wide have texels wherever they are, and all others are neither
// larger nor closer to each other.
#define_import_path bevy_lean_deferred::effects::diffuse_gi::shown_pixel

#import bevy_lean_deferred::effects::diffuse_gi::bindings::{depth_texture, edge_step, view}
#import bevy_lean_deferred::tiles::{NearestPixel, depth_or_none, nearest_beside}

struct ShownPixel {
    place: vec2<i32>,
    /// 0 without a surface.
    depth: f32,
    /// False for the first one.
    is_other: bool,
}

fn depth_at(pixel: vec2<i32>) -> f32 {
    return depth_or_none(depth_texture, vec2<i32>(view.viewport_origin), vec2<i32>(view.viewport_size), pixel);
}

/// The nearest pixel of 2×2 beside the `first`.
fn other_pixel(first: vec2<i32>) -> NearestPixel {
    return nearest_beside(depth_texture, vec2<i32>(view.viewport_origin), vec2<i32>(view.viewport_size), first);
}

fn shown_pixel(texel: vec2<i32>) -> ShownPixel {
    let first = texel * view.divisor;
    let shown = ShownPixel(first, depth_at(first), false);
    if view.divisor == 1 {
        return shown;
    }
    let other = other_pixel(first);
    let step = edge_step(other.depth, 1.0);
    if other.depth > shown.depth + step {
        // The first pixel of the next texel shows what is wider.
        let beyond = 2 * other.place - first;
        if other.depth > depth_at(beyond) + step {
            return ShownPixel(other.place, other.depth, true);
        }
    }
    return shown;
}
