// Cells of pixels: their layout, and the nearest and furthest depth of a cell in one word. Without bindings.
#define_import_path bevy_lean_deferred::cell

/// Cells of 4, 16 and 64 pixels a side are stored one below the other. These are the rows before the latter two sizes, per row of
/// the largest cells.
const ROWS_BEFORE_16: u32 = 16u;
const ROWS_BEFORE_64: u32 = 20u;

/// Rows of the largest cells in a picture of this height.
fn largest_rows(height: u32) -> u32 {
    return (height + 63u) / 64u;
}

/// First code of depths from 2⁻³² to 1, of whose bits 5 of the exponent and 11 of the mantissa are kept.
const FIRST: u32 = (0x3f800000u >> 12u) - 0xffffu;

/// Rounds down; adding `more` to the bits rounds up.
fn code_of(depth: f32, more: u32) -> u32 {
    let bits = bitcast<u32>(max(depth, 0.0)) + more;
    return clamp(bits >> 12u, FIRST, FIRST + 0xffffu) - FIRST;
}

/// `nearest` is rounded up and `furthest` down, so that the whole cell is between them.
fn pack_cell(nearest: f32, furthest: f32) -> u32 {
    return (code_of(nearest, 0xfffu) << 16u) | code_of(furthest, 0u);
}

/// Nearest and furthest depth.
fn unpack_cell(word: u32) -> vec2<f32> {
    return vec2(bitcast<f32>(((word >> 16u) + FIRST) << 12u), bitcast<f32>(((word & 0xffffu) + FIRST) << 12u));
}
