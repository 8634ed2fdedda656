// The light that enters surfaces, twice as coarse: means by the weights 1, 3, 3, 1 each way (Burt and Adelson 1983, "The
// Laplacian Pyramid as a Compact Image Code", have five such), of the nearest surface of its own 2×2 texels and its material.
#import bevy_lean_deferred::lighting::subsurface_light::{Entry, pack_entry, unpack_entry}
#import bevy_lean_deferred::screen_space::subsurface::bindings::{level_output, light_texture, view}
#import bevy_lean_deferred::screen_space::subsurface::texel::{pixels_per_metre_at, texel_of}

/// The step between surfaces, in texels of this level.
const STEP: f32 = 0.75;

fn mean_at(place: vec2<i32>) -> vec2<u32> {
    let first = 2 * place - 1;
    var words: array<vec2<u32>, 16>;
    var nearest = Entry(3e38, 0u, vec3(0.0));
    for (var i = 0; i < 16; i++) {
        let offset = vec2(i & 3, i >> 2u);
        words[i] = textureLoad(light_texture, first + offset, 0).rg;
        let entry = unpack_entry(words[i]);
        let is_inside = all(offset > vec2(0)) && all(offset < vec2(3));
        if is_inside && entry.material != 0u && entry.metres < nearest.metres {
            nearest = entry;
        }
    }
    if nearest.material == 0u {
        return vec2(0u);
    }
    let step = STEP * f32(1u << view.level) / pixels_per_metre_at(nearest.metres);
    var metres = 0.0;
    var light = vec3(0.0);
    var weights = 0.0;
    for (var i = 0; i < 16; i++) {
        let entry = unpack_entry(words[i]);
        let near = vec2(select(1.0, 3.0, (i & 3) == 1 || (i & 3) == 2), select(1.0, 3.0, i >= 4 && i < 12));
        let is_beside = entry.material == nearest.material && abs(entry.metres - nearest.metres) < step;
        let weight = select(0.0, near.x * near.y, is_beside);
        // From the nearest: the sum of large distances would be rounded.
        metres += weight * (entry.metres - nearest.metres);
        light += weight * entry.light;
        weights += weight;
    }
    return pack_entry(Entry(nearest.metres + metres / weights, nearest.material, light / weights));
}

@compute @workgroup_size(64, 1, 1)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) invocation: u32) {
    let texel = texel_of(workgroup.xy, invocation);
    if texel.exists {
        textureStore(level_output, texel.place, vec4(mean_at(texel.place), 0u, 0u));
    }
}
