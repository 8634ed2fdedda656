// Makes and scatters the two coarsest levels, and scatters them into the finest level that is read here. Each workgroup makes the
// part of the coarsest levels that reaches its own texels.
#import bevy_lean_deferred::effects::subsurface::{
    bindings::{light_texture, scattered_output},
    entries::{Square, keep, read_materials, texel_of, words_kept_at},
    mean::{INVOCATIONS, make_level, mean_of},
    scattered::{scattered, shown_at},
}
#import bevy_lean_deferred::workgroup::is_any

/// Side of a workgroup's output in texels.
const MADE: i32 = 8;

fn words_at(texel: vec2<i32>) -> vec2<u32> {
    let last = vec2<i32>(textureDimensions(light_texture)) - 1;
    let inside = clamp(texel, vec2(0), last);
    return select(vec2(0u), textureLoad(light_texture, inside, 0).rg, all(inside == texel));
}

/// The picture may have fewer texels than the workgroups.
fn store(texel: vec2<i32>, words: vec2<u32>) {
    if all(texel < vec2<i32>(textureDimensions(scattered_output))) {
        textureStore(scattered_output, texel, vec4(words, 0u, 0u));
    }
}

@compute @workgroup_size(INVOCATIONS, 1, 1)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let invocation = i32(index);
    let is_maker = invocation < MADE * MADE;
    // The output, and beneath it, with a border of two texels, the next coarser level as it scatters and the coarsest as it is.
    let made = Square(0, MADE, vec2<i32>(workgroup.xy) * MADE);
    let coarser = Square(324, 8, made.corner / 2 - 2);
    let coarsest = Square(388, 8, coarser.corner / 2 - 2);
    // Sources of these.
    let next = Square(0, 18, 2 * coarsest.corner - 1);
    let read = Square(0, 38, 2 * next.corner - 1);

    let texel = texel_of(made, invocation);
    let beneath = texel_of(coarser, invocation);
    read_materials(index);
    var words: array<vec2<u32>, 6>;
    for (var i = 0; i < 6; i++) {
        words[i] = words_at(texel_of(read, invocation + i * INVOCATIONS));
    }
    let own = words_at(texel);
    let shown = shown_at(texel, 5u);
    let shown_beneath = shown_at(beneath, 6u);
    if !is_any(is_maker && own.x != 0u, index) {
        if is_maker {
            store(texel, vec2(0u));
        }
        return;
    }
    make_level(read, &words, next, 6u, invocation);
    if is_maker {
        keep(coarsest, invocation, mean_of(next, texel_of(coarsest, invocation), 7u));
    }
    workgroupBarrier();
    if is_maker {
        let words = words_kept_at(next, beneath);
        keep(coarser, invocation, scattered(beneath, words, shown_beneath, 6u, coarsest));
    }
    workgroupBarrier();
    if is_maker {
        store(texel, scattered(texel, own, shown, 5u, coarser));
    }
}
