// Pixel of 2×2 that a texel at half resolution shows: the first one, or the nearest of the others if that is of another surface in
// front of it that no texel would show otherwise. So things a pixel wide have texels wherever they are, and all others are neither
// larger nor closer to each other.
#define_import_path bevy_lean_deferred::effects::diffuse_gi::shown_pixel

#import bevy_lean_deferred::effects::diffuse_gi::bindings::{depth_texture, edge_step, view}
#import bevy_lean_deferred::tiles::pixel_of_square

struct ShownPixel {
    place: vec2<i32>,
    /// 0 without a surface.
    depth: f32,
    /// In its square, 0 to 3: x + 2 y.
    number: u32,
}

/// Depth at a pixel that is not before the viewport; 0 behind its end.
fn depth_at(pixel: vec2<i32>) -> f32 {
    if any(pixel >= vec2<i32>(view.viewport_size)) {
        return 0.0;
    }
    return textureLoad(depth_texture, vec2<i32>(view.viewport_origin) + pixel, 0);
}

fn shown_pixel(texel: vec2<i32>) -> ShownPixel {
    let first = texel * view.divisor;
    let shown = ShownPixel(first, depth_at(first), 0u);
    if view.divisor == 1 {
        return shown;
    }
    let depths = vec3(depth_at(first + vec2(1, 0)), depth_at(first + vec2(0, 1)), depth_at(first + 1));
    let nearest = max(max(depths.x, depths.y), depths.z);
    let step = edge_step(nearest, 1.0);
    if nearest > shown.depth + step {
        let number = select(select(3u, 2u, depths.y == nearest), 1u, depths.x == nearest);
        let place = first + pixel_of_square(number);
        // The first pixel of the next texel shows what is wider.
        if nearest > depth_at(2 * place - first) + step {
            return ShownPixel(place, nearest, number);
        }
    }
    return shown;
}
