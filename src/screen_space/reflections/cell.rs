//! The nearest and the furthest depth of a cell, in a word. The documentation is in `cell.wgsl`.

/// The bits that are kept of the least depth.
pub const FIRST: u32 = (0x3f80_0000 >> 12) - 0xffff;

fn code_of(depth: f32, more: u32) -> u32 {
    let bits = depth.max(0.0).to_bits() + more;
    (bits >> 12).clamp(FIRST, FIRST + 0xffff) - FIRST
}

/// A word of both.
pub fn pack_cell(nearest: f32, furthest: f32) -> u32 {
    (code_of(nearest, 0xfff) << 16) | code_of(furthest, 0)
}

/// The nearest and the furthest depth.
pub fn unpack_cell(word: u32) -> [f32; 2] {
    [word >> 16, word & 0xffff].map(|code| f32::from_bits((code + FIRST) << 12))
}
