// Pixel of 2×2 that a texel at half resolution shows: the first one, or one of another surface in front of it that no texel would show
// otherwise. So things a pixel wide have texels wherever they are, and all others are neither larger nor closer to each other.
#define_import_path bevy_lean_deferred::shown_pixel

struct ShownPixel {
    place: vec2<i32>,
    /// 0 without a surface.
    depth: f32,
}

/// Pixel `i` of a texel, relative to its first one.
fn place_in_texel(i: i32) -> vec2<i32> {
    return vec2(i & 1, i >> 1u);
}

/// The view covers `size` pixels of the texture, from `origin` on. `block`: depths of the texel's pixels, row by row; 0 outside of the
/// view. `edge.x * depth + edge.y` is the depth step that separates surfaces one pixel apart.
fn shown_pixel(
    depths: texture_depth_2d,
    origin: vec2<i32>,
    size: vec2<i32>,
    edge: vec2<f32>,
    texel: vec2<i32>,
    block: vec4<f32>,
) -> ShownPixel {
    let first = 2 * texel;
    // The nearest of the others.
    let depth = max(block.y, max(block.z, block.w));
    let place = place_in_texel(select(select(3, 2, block.z == depth), 1, block.y == depth));
    let step = edge.x * depth + edge.y;
    if depth > block.x + step {
        // The first pixel of the next texel shows what is wider.
        let beyond = first + 2 * place;
        var depth_beyond = 0.0;
        if all(beyond < size) {
            depth_beyond = textureLoad(depths, origin + beyond, 0);
        }
        if depth > depth_beyond + step {
            return ShownPixel(first + place, depth);
        }
    }
    return ShownPixel(first, block.x);
}
