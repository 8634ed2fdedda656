// The 8×8 tiles in which compute passes cover a view: one workgroup of 64 invocations each.
#define_import_path bevy_lean_deferred::tiles

const SIDE: u32 = 8u;

/// Where invocation `i` of 64 lies in its tile: along a Z-order curve, so that the pixels of a subgroup of any size lie
/// close together (8 make 4×2, 32 make 8×4) and see the same lights.
fn place_in_tile(i: u32) -> vec2<u32> {
    let x = (i & 1u) | ((i >> 1u) & 2u) | ((i >> 2u) & 4u);
    let y = ((i >> 1u) & 1u) | ((i >> 2u) & 2u) | ((i >> 3u) & 4u);
    return vec2(x, y);
}

/// The pixel of an invocation, from the viewport's corner. `row_stride` is that of `tiles.rs`.
fn pixel_in_view(tile: vec2<u32>, tiles: vec2<u32>, row_stride: u32, invocation: u32) -> vec2<u32> {
    let row = (tile.y * row_stride) % tiles.y;
    return vec2(tile.x, row) * SIDE + place_in_tile(invocation);
}
