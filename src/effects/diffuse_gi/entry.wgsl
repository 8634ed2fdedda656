// Words of the levels: depth, the weight of what is known of a surface's light, the pixel that shows it, and that light. Without
// bindings.
#define_import_path bevy_lean_deferred::effects::diffuse_gi::entry

#import bevy_lean_deferred::gbuffer::layout::light::{pack_light, unpack_light}

/// Texel of a level.
struct Entry {
    /// 0 without a surface.
    depth: f32,
    /// Light that the surface sent out in the last frame, at this frame's exposure.
    light: vec3<f32>,
    /// Weight, 0 to 1, with which it is known.
    known: f32,
    /// Pixel of 2×2 that the texel shows, 0 to 3: x + 2 y.
    pixel: u32,
}

/// The upper three bits of depths from `FURTHEST` to 1 are 001. Words hold a weight in their place.
const SURFACE: u32 = 0x20000000u;
const WEIGHT_SHIFT: u32 = 29u;
const LARGEST_WEIGHT: f32 = 7.0;
/// Bits for the pixel, in place of the last ones of the depth.
const PIXEL: u32 = 3u;
/// Bits of the least depth: 2⁻⁶³, plus four steps, so that no surface has the word 0.
const FURTHEST: u32 = 0x20000004u;
/// Bits of depth 1.
const NEAREST: u32 = 0x3f800000u;

/// Packs a depth, of which all bits but the last two are kept, a weight in steps of 1/7, and the number of a pixel. Depths that are
/// not above 0 become 0.
fn pack_depth(depth: f32, known: f32, pixel: u32) -> u32 {
    let bits = ((clamp(bitcast<u32>(depth), FURTHEST, NEAREST) ^ SURFACE) & ~PIXEL) | pixel;
    let weight = u32(saturate(known) * LARGEST_WEIGHT + 0.5);
    return select(0u, bits | (weight << WEIGHT_SHIFT), depth > 0.0);
}

fn unpack_depth(word: u32) -> f32 {
    let bits = word & (SURFACE - 1u);
    return select(0.0, bitcast<f32>(bits | SURFACE), word != 0u);
}

fn unpack_pixel(word: u32) -> u32 {
    return word & PIXEL;
}

fn unpack_known(word: u32) -> f32 {
    return f32(word >> WEIGHT_SHIFT) / LARGEST_WEIGHT;
}

fn pack_entry(entry: Entry) -> vec4<u32> {
    return vec4(pack_depth(entry.depth, entry.known, entry.pixel), pack_light(entry.light), 0u, 0u);
}

fn unpack_entry(words: vec2<u32>) -> Entry {
    return Entry(unpack_depth(words.x), unpack_light(words.y), unpack_known(words.x), unpack_pixel(words.x));
}
