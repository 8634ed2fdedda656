// 8×8 tiles in which compute passes cover a view: one workgroup of 64 invocations per tile. Pixels of half-resolution texels.
#define_import_path bevy_lean_deferred::tiles

const TILE_SIDE: u32 = 8u;

/// Position of invocation `i` of 64 in its tile, in Z-order: the pixels of a subgroup of any size are close together (8 cover
/// 4×2, 32 cover 8×4) and see the same lights.
fn place_in_tile(i: u32) -> vec2<u32> {
    let x = (i & 1u) | ((i >> 1u) & 2u) | ((i >> 2u) & 4u);
    let y = ((i >> 1u) & 1u) | ((i >> 2u) & 2u) | ((i >> 3u) & 4u);
    return vec2(x, y);
}

/// Pixel of an invocation, relative to the viewport's corner.
fn pixel_in_view(tile: vec2<u32>, invocation: u32) -> vec2<u32> {
    return tile * TILE_SIDE + place_in_tile(invocation);
}

/// Pixel of a square of `side` (1 or 2) pixels that a texel shows. It changes from texel to texel: of four neighbouring texels, one shows
/// each row and each column of their pixels, so that what is a pixel wide is seen wherever it is.
fn pixel_of_texel(texel: vec2<i32>, side: i32, view_size: vec2<i32>) -> vec2<i32> {
    return min(texel * side + (~texel.yx & vec2(side - 1)), view_size - 1);
}

/// Pixel of a square of 2×2 that has this number, 0 to 3: x + 2 y.
fn pixel_of_square(number: u32) -> vec2<i32> {
    return vec2<i32>(vec2(number & 1u, number >> 1u));
}
