// The light that enters surfaces beneath which it scatters, as lighting writes it and scattering reads it.
#define_import_path bevy_lean_deferred::lighting::subsurface_light

#import bevy_lean_deferred::gbuffer::layout::light::{pack_halves, pack_light, unpack_halves, unpack_light}
#import bevy_lean_deferred::shading_models::subsurface::{
    unpack_subsurface_color, unpack_subsurface_path,
}

/// Less of the base colour counts as that much where it is applied after scattering.
const LEAST_ALBEDO: f32 = 0.04;

/// Where the buffer of the tiles has how many blocks are listed; by the number of each material of the frame its arguments and 1 (0:
/// no material has the number); for each block of the textures, row by row, which of its tiles have such light; and the listed
/// blocks, in any order: those with any.
const COUNT: u32 = 0u;
const MATERIALS: u32 = 1u;
const MASKS: u32 = MATERIALS + MOST_MATERIALS + 1u;
/// Materials of a frame that are told apart.
const MOST_MATERIALS: u32 = 255u;

/// The low bits of the first word of an entry: which material it is. The rest is a distance, which thereby is off by at most
/// 2 to the power of -16 of itself.
const MATERIAL_BITS: u32 = 0xffu;

/// A block has 4×4 tiles: 2 to the power of this pixels a side.
const BLOCK_LOG: u32 = 5u;

/// The bit, in the mask of its block, of the tile that this pixel is in.
fn tile_bit(pixel: vec2<u32>) -> u32 {
    let tile = (pixel >> vec2(3u)) & vec2(3u);
    return 1u << (4u * tile.y + tile.x);
}

/// What the light of a pixel or texel is and where.
struct Entry {
    /// Along the view direction, in metres.
    metres: f32,
    /// Its number, 1 to `MOST_MATERIALS`. 0: there is no light to scatter.
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

/// Of the first word of an entry. Words of one material have the order of their distances.
fn unpack_metres(word: u32) -> f32 {
    return bitcast<f32>(word & ~MATERIAL_BITS);
}

fn unpack_material(word: u32) -> u32 {
    return word & MATERIAL_BITS;
}

/// What a pixel shows without scattering, and what becomes of light that has scattered.
struct Receiver {
    color: vec4<f32>,
    /// What fog and the base colour leave of that light, 0 to 1.
    leaving: vec3<f32>,
    /// As the G-buffer has it.
    normal_word: u32,
}

fn pack_receiver(receiver: Receiver) -> vec4<u32> {
    return vec4(pack_halves(receiver.color), pack_light(receiver.leaving), receiver.normal_word);
}

fn unpack_receiver(words: vec4<u32>) -> Receiver {
    return Receiver(unpack_halves(words.xy), unpack_light(words.z), words.w);
}

/// How far light of each channel scatters in a material that is `known` as the buffer of the tiles has it: the `d` of its
/// profile, in metres.
fn scattering_distance(known: u32) -> vec3<f32> {
    let arguments = known - 1u;
    return unpack_subsurface_color(arguments) * unpack_subsurface_path(arguments);
}
