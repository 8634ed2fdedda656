// Squares of some levels' entries, in workgroup memory. All reads are issued before the first is used, to hide memory latency.
#define_import_path bevy_lean_deferred::effects::subsurface::entries

#import bevy_lean_deferred::gbuffer::layout::light::unpack_light
#import bevy_lean_deferred::lighting::subsurface_light::{MATERIALS, MOST_MATERIALS, scattering_distance}
#import bevy_lean_deferred::effects::subsurface::bindings::tiles

/// Stored entry: its first word, as `lighting/subsurface_light.wgsl` packs it, and its light.
struct Kept {
    word: u32,
    light: vec3<f32>,
}

// As many entries as the passes need. WebGPU guarantees 16 KiB. Where there is room (UNPACKED), light is unpacked, because it is
// read more often than written; so are the scattering distances of the frame's materials.
#ifdef UNPACKED
/// The word, and the bits of the light: one read of four words.
var<workgroup> entries: array<vec4<u32>, 244>;
var<workgroup> distances: array<vec3<f32>, MOST_MATERIALS + 1u>;
#else
var<workgroup> entries: array<vec2<u32>, 760>;
var<workgroup> materials: array<u32, MOST_MATERIALS + 1u>;
#endif

/// Must be called by 256 invocations, before a barrier.
fn read_materials(invocation: u32) {
    let known = tiles[MATERIALS + invocation];
#ifdef UNPACKED
    distances[invocation] = scattering_distance(known);
#else
    materials[invocation] = known;
#endif
}

/// Scattering distance per channel in the material with this number, in metres.
fn distance_in(material: u32) -> vec3<f32> {
#ifdef UNPACKED
    return distances[material];
#else
    return scattering_distance(materials[material]);
#endif
}

/// Texels of a level, stored row by row from `start` on.
struct Square {
    start: i32,
    side: i32,
    /// First texel.
    corner: vec2<i32>,
}

fn count_of(square: Square) -> i32 {
    return square.side * square.side;
}

/// Texel of the entry with this index in the square.
fn texel_of(square: Square, index: i32) -> vec2<i32> {
    return square.corner + vec2(index % square.side, index / square.side);
}

/// Index of the entry of a texel in the square.
fn place_of(square: Square, texel: vec2<i32>) -> i32 {
    let inside = texel - square.corner;
    return square.start + inside.y * square.side + inside.x;
}

#ifdef UNPACKED
/// Stores the words of the texel with this index, if the square has that many.
fn keep(square: Square, index: i32, words: vec2<u32>) {
    if index < count_of(square) {
        entries[square.start + index] = vec4(words.x, bitcast<vec3<u32>>(unpack_light(words.y)));
    }
}

/// Entry of a texel in the square.
fn kept_at(square: Square, texel: vec2<i32>) -> Kept {
    let words = entries[place_of(square, texel)];
    return Kept(words.x, bitcast<vec3<f32>>(words.yzw));
}
#else
/// Stores the words of the texel with this index, if the square has that many.
fn keep(square: Square, index: i32, words: vec2<u32>) {
    if index < count_of(square) {
        entries[square.start + index] = words;
    }
}

/// Stores the words of the texel with this index, if it is one of `count` from `first` on, without those before.
fn keep_part(first: i32, count: i32, index: i32, words: vec2<u32>) {
    let place = index - first;
    if place >= 0 && place < count {
        entries[place] = words;
    }
}

/// Words of a texel in the square.
fn words_kept_at(square: Square, texel: vec2<i32>) -> vec2<u32> {
    return entries[place_of(square, texel)];
}

/// Entry of a texel in the square.
fn kept_at(square: Square, texel: vec2<i32>) -> Kept {
    let words = words_kept_at(square, texel);
    return Kept(words.x, unpack_light(words.y));
}
#endif

/// True if `texel` is in the square, and not within `rim` of its border.
fn is_within(square: Square, rim: i32, texel: vec2<i32>) -> bool {
    let inside = texel - square.corner;
    return all(inside >= vec2(rim)) && all(inside < vec2(square.side - rim));
}
