// What a workgroup knows of some levels: squares of entries, in shared memory. All that it reads is asked for before any of it is
// looked at: memory is slow to answer, but answers many at once.
#define_import_path bevy_lean_deferred::screen_space::subsurface::entries

#import bevy_lean_deferred::lighting::subsurface_light::{MATERIALS, MOST_MATERIALS, scattering_distance}
#import bevy_lean_deferred::screen_space::subsurface::bindings::tiles

// As many as the pass needs. WebGPU promises 16 KiB.
#ifdef PICTURE
const MOST_ENTRIES: u32 = 100u;
#else ifdef UP
const MOST_ENTRIES: u32 = 244u;
#else
const MOST_ENTRIES: u32 = 1768u;
#endif

/// The words of entries, as `lighting/subsurface_light.wgsl` packs them.
var<workgroup> entries: array<vec2<u32>, MOST_ENTRIES>;

/// The materials of the frame, as the buffer of the tiles has them.
var<workgroup> materials: array<u32, MOST_MATERIALS + 1u>;

/// To be called by 256 invocations, before a barrier.
fn read_materials(invocation: u32) {
    materials[invocation] = tiles[MATERIALS + invocation];
}

/// How far light of each channel scatters in the material with this number, in metres.
fn distance_in(material: u32) -> vec3<f32> {
    return scattering_distance(materials[material]);
}

/// Texels of a level, row by row from `start` on.
struct Square {
    start: i32,
    side: i32,
    /// The texel that comes first.
    corner: vec2<i32>,
}

fn count_of(square: Square) -> i32 {
    return square.side * square.side;
}

/// The texel of the entry with this number.
fn texel_of(square: Square, index: i32) -> vec2<i32> {
    return square.corner + vec2(index % square.side, index / square.side);
}

/// Keeps what has been read of the texel with this number, if the square has so many.
fn keep(square: Square, index: i32, words: vec2<u32>) {
    if index < count_of(square) {
        entries[square.start + index] = words;
    }
}

/// Of a texel in the square.
fn entry_at(square: Square, texel: vec2<i32>) -> vec2<u32> {
    let inside = texel - square.corner;
    return entries[square.start + inside.y * square.side + inside.x];
}

/// Whether it is in the square, and not within `rim` of its outline.
fn is_within(square: Square, rim: i32, texel: vec2<i32>) -> bool {
    let inside = texel - square.corner;
    return all(inside >= vec2(rim)) && all(inside < vec2(square.side - rim));
}
