// Makes a texel of the next coarser level.
#define_import_path bevy_lean_deferred::effects::subsurface::mean

#import bevy_lean_deferred::gbuffer::layout::light::{unpack_mantissas, unpack_scale}
#import bevy_lean_deferred::lighting::subsurface_light::{
    Entry, pack_entry, unpack_material, unpack_metres,
}
#import bevy_lean_deferred::effects::subsurface::{
    entries::{Square, count_of, distance_in, keep, keep_part, texel_of, words_kept_at},
    texel::pixels_per_metre_at,
}

/// Distance that separates surfaces: in texels of the coarser level, as much as on a surface turned away by 60 degrees, and in
/// mean free paths.
const STEP: vec2<f32> = vec2(2.0, 10.0);
/// Above the word of any entry.
const NOTHING: u32 = 0xffffffffu;

/// Texel of `level`: the mean of 4×4 entries of the next finer level with weights 1, 3, 3, 1 along each axis (Burt and Adelson
/// 1983, "The Laplacian Pyramid as a Compact Image Code", have five). Only entries of the nearest surface of its own 2×2 count,
/// and of that surface's material.
fn mean_of(finer: Square, texel: vec2<i32>, level: u32) -> vec2<u32> {
    let first = 2 * texel - 1;
    // Words sort by distance.
    var nearest = NOTHING;
    for (var i = 0; i < 4; i++) {
        let word = words_kept_at(finer, first + 1 + vec2(i & 1, i >> 1u)).x;
        nearest = min(nearest, select(word, NOTHING, unpack_material(word) == 0u));
    }
    if nearest == NOTHING {
        return vec2(0u);
    }
    let material = unpack_material(nearest);
    let nearest_metres = unpack_metres(nearest);
    let width = f32(1u << level) / pixels_per_metre_at(nearest_metres);
    let paths = distance_in(material);
    let longest = max(paths.r, max(paths.g, paths.b));
    let step = min(STEP.x * width, STEP.y * longest);
    var metres = 0.0;
    var light = vec3(0.0);
    var weights = 0.0;
    for (var y = 0; y < 4; y++) {
        for (var x = 0; x < 4; x++) {
            let words = words_kept_at(finer, first + vec2(x, y));
            let near = select(1.0, 3.0, x % 3 != 0) * select(1.0, 3.0, y % 3 != 0);
            // Relative to the nearest: a sum of large distances would lose precision.
            let behind = unpack_metres(words.x) - nearest_metres;
            let is_beside = unpack_material(words.x) == material && abs(behind) < step;
            let weight = select(0.0, near, is_beside);
            metres += weight * behind;
            // Products with the scale are exact.
            light += weight * unpack_scale(words.y) * unpack_mantissas(words.y);
            weights += weight;
        }
    }
    return pack_entry(Entry(nearest_metres + metres / weights, material, light / weights));
}

/// Number of invocations of a workgroup.
const INVOCATIONS: i32 = 256;

/// Makes the texels of `made` in `level` from those of the next finer level, `finer`, and stores them. `words` are those of every
/// `INVOCATIONS`-th texel of `finer`, from that of the invocation on. A half of the rows at a time is stored, because workgroups
/// with less memory are more at a time. Must be called by all invocations.
fn make_level(finer: Square, words: ptr<function, array<vec2<u32>, 6>>, made: Square, level: u32, invocation: i32) {
    let half = count_of(made) / 2;
    // The halves of `finer` have two rows in common.
    let rows = finer.side / 2 + 1;
    var upper: vec2<u32>;
    var lower: vec2<u32>;
    for (var part = 0; part < 2; part++) {
        let first_row = part * (rows - 2);
        // Waits until the previous entries are read.
        workgroupBarrier();
        for (var i = 0; i < 6; i++) {
            keep_part(first_row * finer.side, rows * finer.side, invocation + i * INVOCATIONS, (*words)[i]);
        }
        workgroupBarrier();
        upper = lower;
        if invocation < half {
            let square = Square(0, finer.side, finer.corner + vec2(0, first_row));
            lower = mean_of(square, texel_of(made, part * half + invocation), level);
        }
    }
    workgroupBarrier();
    if invocation < half {
        keep(made, invocation, upper);
        keep(made, half + invocation, lower);
    }
    workgroupBarrier();
}
