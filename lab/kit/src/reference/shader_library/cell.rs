//! Nearest and furthest depth of a cell, packed in a word. `cell.wgsl` has the documentation.

/// Offset of the codes: the upper 20 bits of the smallest depth that is stored.
pub const FIRST: u32 = (0x3f80_0000 >> 12) - 0xffff;

fn code_of(depth: f32, more: u32) -> u32 {
    let bits = depth.max(0.0).to_bits() + more;
    (bits >> 12).clamp(FIRST, FIRST + 0xffff) - FIRST
}

/// Packs the nearest and the furthest depth.
pub fn pack_cell(nearest: f32, furthest: f32) -> u32 {
    (code_of(nearest, 0xfff) << 16) | code_of(furthest, 0)
}

/// Unpacks the nearest and the furthest depth.
pub fn unpack_cell(word: u32) -> [f32; 2] {
    [word >> 16, word & 0xffff].map(|code| f32::from_bits((code + FIRST) << 12))
}
