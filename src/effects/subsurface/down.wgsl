// Downsamples the light that enters surfaces: the listed blocks of the picture to the first two levels (LISTED), or a whole level
// to three more.
#import bevy_lean_deferred::effects::subsurface::{
    bindings::{level_output, light_texture, next_output},
    entries::{Square, count_of, is_within, keep, read_materials, texel_of, words_kept_at},
    mean::{INVOCATIONS, make_level, mean_of},
}
#ifdef LISTED
#import bevy_lean_deferred::effects::subsurface::texel::{count_of_blocks, is_written, listed_block}
#else
#import bevy_lean_deferred::effects::subsurface::bindings::last_output
#import bevy_lean_deferred::effects::subsurface::texel::is_listed
#endif

// A workgroup's squares have a border that only its next level needs.
#ifdef LISTED
/// Light of a pixel; 0 where this frame has none.
fn words_at(pixel: vec2<i32>) -> vec2<u32> {
    return select(vec2(0u), textureLoad(light_texture, max(pixel, vec2(0)), 0).rg, is_written(pixel));
}

/// Makes the first two levels of a block.
fn make(block: vec2<i32>, invocation: i32) {
    let read = Square(0, 38, 32 * block - 3);
    let first = Square(0, 18, 16 * block - 1);
    var words: array<vec2<u32>, 6>;
    for (var i = 0; i < 6; i++) {
        words[i] = words_at(texel_of(read, invocation + i * INVOCATIONS));
    }
    make_level(read, &words, first, 1u, invocation);
    let texel = texel_of(Square(0, 16, 16 * block), invocation);
    textureStore(level_output, texel, vec4(words_kept_at(first, texel), 0u, 0u));
    if invocation < 64 {
        let next = texel_of(Square(0, 8, 8 * block), invocation);
        textureStore(next_output, next, vec4(mean_of(first, next, 2u), 0u, 0u));
    }
}

@compute @workgroup_size(INVOCATIONS, 1, 1)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    read_materials(invocation);
    let count = count_of_blocks();
    for (var i = workgroup.x; i < count; i += workgroups.x) {
        make(listed_block(i), i32(invocation));
    }
}
#else   // LISTED
/// Light of a texel of the second level; 0 in blocks without light, whose texels are of another frame.
fn words_at(texel: vec2<i32>) -> vec2<u32> {
    return select(vec2(0u), textureLoad(light_texture, max(texel, vec2(0)), 0).rg, is_listed(texel >> vec2(3u)));
}

@compute @workgroup_size(INVOCATIONS, 1, 1)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let invocation = i32(index);
    let corner = vec2<i32>(workgroup.xy) * 8;
    let read = Square(0, 30, 2 * corner - 7);
    let first = Square(0, 14, corner - 3);
    let second = Square(count_of(first), 6, corner / 2 - 1);
    let texel = texel_of(Square(0, 8, corner), invocation);
    let next = texel_of(second, invocation);
    let last = texel_of(Square(0, 2, corner / 4), invocation);
    // Without listed blocks, all texels are empty.
    let block = corner / 4;
    if !(is_listed(block) || is_listed(block + vec2(1, 0)) || is_listed(block + vec2(0, 1)) || is_listed(block + 1)) {
        if invocation < 64 {
            textureStore(level_output, texel, vec4(0u));
        }
        if is_within(second, 1, next) {
            textureStore(next_output, next, vec4(0u));
        }
        if invocation < 4 {
            textureStore(last_output, last, vec4(0u));
        }
        return;
    }
    read_materials(index);
    // The last two are beyond the square.
    var words: array<vec2<u32>, 6>;
    for (var i = 0; i < 4; i++) {
        words[i] = words_at(texel_of(read, invocation + i * INVOCATIONS));
    }
    make_level(read, &words, first, 3u, invocation);
    if invocation < 64 {
        textureStore(level_output, texel, vec4(words_kept_at(first, texel), 0u, 0u));
    }
    if invocation < count_of(second) {
        let made = mean_of(first, next, 4u);
        keep(second, invocation, made);
        if is_within(second, 1, next) {
            textureStore(next_output, next, vec4(made, 0u, 0u));
        }
    }
    workgroupBarrier();
    if invocation < 4 {
        textureStore(last_output, last, vec4(mean_of(second, last, 5u), 0u, 0u));
    }
}
#endif  // LISTED
