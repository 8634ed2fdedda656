// Pixel of 2×2 that a texel at half resolution shows: the first one, or the nearest of the others if that is of another surface in
// front of it that no texel would show otherwise. So things a pixel wide have texels wherever they are, and all others are neither
// larger nor closer to each other.
#define_import_path bevy_lean_deferred::effects::diffuse_gi::shown_pixel

#import bevy_lean_deferred::effects::diffuse_gi::bindings::{depth_texture, edge_step, view}

struct ShownPixel {
    place: vec2<i32>,
    /// 0 without a surface.
    depth: f32,
    /// False for the first one.
    is_other: bool,
}

/// 0 outside of the viewport.
fn depth_at(pixel: vec2<i32>) -> f32 {
    if any(pixel >= vec2<i32>(view.viewport_size)) {
        return 0.0;
    }
    return textureLoad(depth_texture, vec2<i32>(view.viewport_origin) + pixel, 0);
}

/// The nearest pixel of 2×2 beside the `first`. Lighting has the same (`screen_space_light.wgsl`).
fn nearest_other(first: vec2<i32>) -> ShownPixel {
    let right = depth_at(first + vec2(1, 0));
    let below = depth_at(first + vec2(0, 1));
    let depth = max(max(right, below), depth_at(first + 1));
    let step = select(select(vec2(1), vec2(0, 1), below == depth), vec2(1, 0), right == depth);
    return ShownPixel(first + step, depth, true);
}

fn shown_pixel(texel: vec2<i32>) -> ShownPixel {
    let first = texel * view.divisor;
    let shown = ShownPixel(first, depth_at(first), false);
    if view.divisor == 1 {
        return shown;
    }
    let other = nearest_other(first);
    let step = edge_step(other.depth, 1.0);
    if other.depth > shown.depth + step {
        // The first pixel of the next texel shows what is wider.
        let beyond = 2 * other.place - first;
        if other.depth > depth_at(beyond) + step {
            return other;
        }
    }
    return shown;
}
