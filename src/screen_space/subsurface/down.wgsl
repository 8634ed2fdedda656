// The light that enters surfaces, twice as coarse: means by the weights 1, 3, 3, 1 each way (Burt and Adelson 1983, "The
// Laplacian Pyramid as a Compact Image Code", have five such), of the nearest surface of its own 2×2 texels and its material.
// Either of the listed tiles, or of the whole level, and then of the next one too.
#import bevy_lean_deferred::gbuffer::layout::light::unpack_light
#import bevy_lean_deferred::lighting::subsurface_light::{
    Entry, MATERIALS, pack_entry, scattering_distance, unpack_material, unpack_metres,
}
#import bevy_lean_deferred::screen_space::subsurface::bindings::{level_output, light_texture, tiles, view}
#import bevy_lean_deferred::screen_space::subsurface::texel::pixels_per_metre_at
#ifdef LISTED
#import bevy_lean_deferred::screen_space::subsurface::texel::{count_of_groups, listed_texel}
#else
#import bevy_lean_deferred::screen_space::subsurface::bindings::next_output
#import bevy_lean_deferred::screen_space::subsurface::texel::is_any
#endif

/// The step between surfaces: in texels of the coarser level, as much as one has that is turned away by 60 degrees, and in mean
/// free paths.
const STEP: vec2<f32> = vec2(2.0, 10.0);
/// Further than the word of any entry.
const NOTHING: u32 = 0xffffffffu;

/// Of the finer level; nothing is beyond its rim.
fn words_at(place: vec2<i32>) -> vec2<u32> {
    let last = vec2<i32>(textureDimensions(light_texture)) - 1;
    let inside = clamp(place, vec2(0), last);
    return select(vec2(0u), textureLoad(light_texture, inside, 0).rg, all(inside == place));
}

#ifndef LISTED
/// Texels a side that a workgroup reads, and makes of the first level: a rim of them is for the second one.
const READ: i32 = 22;
const MADE: i32 = 10;
/// As many as that needs.
const INVOCATIONS: i32 = 128;

var<workgroup> read: array<vec2<u32>, 484>;
var<workgroup> made: array<vec2<u32>, 100>;
/// Whether the second level is made, of the first one.
var<private> is_second: bool;
#endif

/// The words of an entry of the finer level.
fn finer(place: vec2<i32>) -> vec2<u32> {
#ifdef LISTED
    return words_at(place);
#else
    if is_second {
        return made[place.y * MADE + place.x];
    }
    return read[place.y * READ + place.x];
#endif
}

/// The mean of 4×4 entries from `first` on, as a texel of `level`.
fn mean_of(first: vec2<i32>, level: u32) -> vec2<u32> {
    // Words have the order of distances.
    var nearest = NOTHING;
    for (var i = 0; i < 4; i++) {
        let word = finer(first + 1 + vec2(i & 1, i >> 1u)).x;
        nearest = min(nearest, select(word, NOTHING, unpack_material(word) == 0u));
    }
    if nearest == NOTHING {
        return vec2(0u);
    }
    let material = unpack_material(nearest);
    let nearest_metres = unpack_metres(nearest);
    let texel = f32(1u << level) / pixels_per_metre_at(nearest_metres);
    let paths = scattering_distance(tiles[MATERIALS + material]);
    let longest = max(paths.r, max(paths.g, paths.b));
    let step = min(STEP.x * texel, STEP.y * longest);
    var metres = 0.0;
    var light = vec3(0.0);
    var weights = 0.0;
    for (var y = 0; y < 4; y++) {
        for (var x = 0; x < 4; x++) {
            let words = finer(first + vec2(x, y));
            let near = select(1.0, 3.0, x % 3 != 0) * select(1.0, 3.0, y % 3 != 0);
            // From the nearest: the sum of large distances would be rounded.
            let behind = unpack_metres(words.x) - nearest_metres;
            let is_beside = unpack_material(words.x) == material && abs(behind) < step;
            let weight = select(0.0, near, is_beside);
            metres += weight * behind;
            light += weight * unpack_light(words.y);
            weights += weight;
        }
    }
    return pack_entry(Entry(nearest_metres + metres / weights, material, light / weights));
}

#ifdef LISTED
@compute @workgroup_size(64, 1, 1)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    let count = count_of_groups();
    for (var group = workgroup.x; group < count; group += workgroups.x) {
        let texel = listed_texel(group, invocation);
        if texel.exists {
            textureStore(level_output, texel.place, vec4(mean_of(2 * texel.place - 1, view.level), 0u, 0u));
        }
    }
}
#else
/// Levels may be smaller than what a workgroup makes.
fn store(place: vec2<i32>, words: vec2<u32>) {
    if all(place < vec2<i32>(textureDimensions(level_output))) {
        textureStore(level_output, place, vec4(words, 0u, 0u));
    }
}

fn store_next(place: vec2<i32>, words: vec2<u32>) {
    if all(place < vec2<i32>(textureDimensions(next_output))) {
        textureStore(next_output, place, vec4(words, 0u, 0u));
    }
}

@compute @workgroup_size(INVOCATIONS, 1, 1)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) invocation: u32) {
    let corner = vec2<i32>(workgroup.xy) * 8;
    let index = i32(invocation);
    var any_light = false;
    for (var i = index; i < READ * READ; i += INVOCATIONS) {
        read[i] = words_at(2 * corner - 3 + vec2(i % READ, i / READ));
        any_light |= read[i].x != 0u;
    }
    if !is_any(any_light, invocation) {
        if index < 64 {
            store(corner + vec2(index & 7, index >> 3u), vec2(0u));
        }
        if index < 16 {
            store_next(corner / 2 + vec2(index & 3, index >> 2u), vec2(0u));
        }
        return;
    }
    is_second = false;
    if index < MADE * MADE {
        let place = vec2(index % MADE, index / MADE);
        let words = mean_of(2 * place, view.level);
        made[index] = words;
        if all(place > vec2(0)) && all(place < vec2(MADE - 1)) {
            store(corner + place - 1, words);
        }
    }
    workgroupBarrier();
    is_second = true;
    if index < 16 {
        let place = vec2(index & 3, index >> 2u);
        store_next(corner / 2 + place, mean_of(2 * place, view.level + 1u));
    }
}
#endif
