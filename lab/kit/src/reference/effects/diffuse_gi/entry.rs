//! Twin of `effects/diffuse_gi/entry.wgsl`.

pub const SURFACE: u32 = 0x2000_0000;
pub const WEIGHT_SHIFT: u32 = 29;
pub const LARGEST_WEIGHT: f32 = 7.0;
pub const PIXEL: u32 = 3;
pub const FURTHEST: u32 = 0x2000_0004;
pub const NEAREST: u32 = 0x3f80_0000;

/// Packs a depth, the weight with which the light of its surface is known, and the number of the pixel that
/// the texel shows.
pub fn pack_depth(depth: f32, known: f32, pixel: u32) -> u32 {
    // Also of NaN.
    if depth.is_nan() || depth <= 0.0 {
        return 0;
    }
    let bits = depth.to_bits().clamp(FURTHEST, NEAREST) ^ SURFACE;
    let weight = (known.clamp(0.0, 1.0) * LARGEST_WEIGHT + 0.5) as u32;
    (bits & !PIXEL) | (weight << WEIGHT_SHIFT) | pixel
}

pub fn unpack_depth(word: u32) -> f32 {
    if word == 0 {
        return 0.0;
    }
    f32::from_bits((word & (SURFACE - 1)) | SURFACE)
}

pub fn unpack_pixel(word: u32) -> u32 {
    word & PIXEL
}

pub fn unpack_known(word: u32) -> f32 {
    (word >> WEIGHT_SHIFT) as f32 / LARGEST_WEIGHT
}
