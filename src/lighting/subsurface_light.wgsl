// Light that enters surfaces with subsurface scattering, as lighting writes it and the scattering passes read it.
#define_import_path bevy_lean_deferred::lighting::subsurface_light

#import bevy_lean_deferred::gbuffer::layout::light::{pack_halves, pack_light, unpack_halves, unpack_light}
#import bevy_lean_deferred::shading_models::subsurface::{
    unpack_subsurface_color, unpack_subsurface_path,
}

/// Lower bound of the base colour where it is applied after scattering.
const LEAST_ALBEDO: f32 = 0.04;

/// Layout of the buffer of tiles: the number of listed blocks; by material number, `arguments + 1` (0: unused); per block of the
/// textures, row by row, the mask of its tiles with such light; and the listed blocks, those with a mask, in any order.
const COUNT: u32 = 0u;
const MATERIALS: u32 = 1u;
const MASKS: u32 = MATERIALS + MOST_MATERIALS + 1u;
/// Number of materials that are distinguished in a frame.
const MOST_MATERIALS: u32 = 255u;

/// Low bits of the first word of an entry: its material. The rest is a distance, with a relative error of at most 2⁻¹⁶.
const MATERIAL_BITS: u32 = 0xffu;

/// Base-2 logarithm of a block's side in pixels. A block has 4×4 tiles.
const BLOCK_LOG: u32 = 5u;

/// Bit of the pixel's tile in the mask of its block.
fn tile_bit(pixel: vec2<u32>) -> u32 {
    let tile = (pixel >> vec2(3u)) & vec2(3u);
    return 1u << (4u * tile.y + tile.x);
}

/// Light of a pixel or texel, with its material and distance.
struct Entry {
    /// Distance along the view direction, in metres.
    metres: f32,
    /// Number of the material, 1 to `MOST_MATERIALS`; 0 without light to scatter.
    material: u32,
    light: vec3<f32>,
}

fn pack_entry(entry: Entry) -> vec2<u32> {
    let rounded = (bitcast<u32>(entry.metres) + 0x80u) & ~MATERIAL_BITS;
    return vec2(rounded | entry.material, pack_light(entry.light));
}

fn unpack_entry(words: vec2<u32>) -> Entry {
    return Entry(unpack_metres(words.x), unpack_material(words.x), unpack_light(words.y));
}

/// Distance in the first word of an entry. Words of one material sort by distance.
fn unpack_metres(word: u32) -> f32 {
    return bitcast<f32>(word & ~MATERIAL_BITS);
}

fn unpack_material(word: u32) -> u32 {
    return word & MATERIAL_BITS;
}

/// Pixel without scattering, and the terms that apply to its scattered light.
struct Receiver {
    color: vec4<f32>,
    /// Share of scattered light that fog and the base colour leave, 0 to 1.
    leaving: vec3<f32>,
    /// As in the G-buffer.
    normal_word: u32,
}

fn pack_receiver(receiver: Receiver) -> vec4<u32> {
    return vec4(pack_halves(receiver.color), pack_light(receiver.leaving), receiver.normal_word);
}

fn unpack_receiver(words: vec4<u32>) -> Receiver {
    return Receiver(unpack_halves(words.xy), unpack_light(words.z), words.w);
}

/// Scattering distance per channel, the `d` of the profile, in metres. `known` is the material's value in the buffer of tiles.
fn scattering_distance(known: u32) -> vec3<f32> {
    let arguments = known - 1u;
    return unpack_subsurface_color(arguments) * unpack_subsurface_path(arguments);
}
