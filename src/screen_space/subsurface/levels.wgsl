// Means of the light that enters surfaces: of 2×2, 4×4 and 8×8 pixels of each tile. Each is of one surface and one material: the
// nearest.
#import bevy_lean_deferred::lighting::subsurface_light::{Entry, pack_entry, unpack_entry}
#import bevy_lean_deferred::screen_space::subsurface::bindings::{level_1, level_2, level_3, light_texture}
#import bevy_lean_deferred::screen_space::subsurface::surface::pixels_per_metre_at
#import bevy_lean_deferred::screen_space::subsurface::tile::tile_of

var<workgroup> entries: array<vec2<u32>, 64>;

/// The mean of four entries of texels that are `side` pixels wide together.
fn mean_of(words: array<vec2<u32>, 4>, side: f32) -> vec2<u32> {
    var each = words;
    var nearest = Entry(3e38, 0u, vec3(0.0));
    for (var i = 0; i < 4; i++) {
        let entry = unpack_entry(each[i]);
        if entry.material != 0u && entry.metres < nearest.metres {
            nearest = entry;
        }
    }
    if nearest.material == 0u {
        return vec2(0u);
    }
    // A surface that is 56 degrees away from facing the viewer is so much further on its other side.
    let step = 1.5 * side / pixels_per_metre_at(nearest.metres);
    var metres = 0.0;
    var light = vec3(0.0);
    var count = 0.0;
    for (var i = 0; i < 4; i++) {
        let entry = unpack_entry(each[i]);
        let is_beside = entry.material == nearest.material && entry.metres - nearest.metres < step;
        let weight = select(0.0, 1.0, is_beside);
        // From the nearest: the sum of large distances would be rounded.
        metres += weight * (entry.metres - nearest.metres);
        light += weight * entry.light;
        count += weight;
    }
    return pack_entry(Entry(nearest.metres + metres / count, nearest.material, light / count));
}

/// Of four entries of a square of 8, 4 or 2 of them, whose rows lie 8 apart.
fn mean_at(place: vec2<u32>, apart: u32, side: f32) -> vec2<u32> {
    let first = (place.y * 8u + place.x) * 2u * apart;
    let words = array(
        entries[first], entries[first + apart], entries[first + 8u * apart], entries[first + 9u * apart],
    );
    return mean_of(words, side);
}

@compute @workgroup_size(64, 1, 1)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) invocation: u32) {
    let tile = tile_of(workgroup.xy);
    if !tile.is_listed {
        return;
    }
    let pixel = tile.origin + vec2(invocation & 7u, invocation >> 3u);
    entries[invocation] = textureLoad(light_texture, pixel, 0).rg;
    workgroupBarrier();
    var mean = vec2(0u);
    let by_4 = vec2(invocation & 3u, invocation >> 2u);
    if invocation < 16u {
        mean = mean_at(by_4, 1u, 2.0);
        textureStore(level_1, tile.origin / 2u + by_4, vec4(mean, 0u, 0u));
    }
    workgroupBarrier();
    if invocation < 16u {
        entries[(by_4.y * 8u + by_4.x) * 2u] = mean;
    }
    workgroupBarrier();
    let by_2 = vec2(invocation & 1u, invocation >> 1u);
    if invocation < 4u {
        mean = mean_at(by_2, 2u, 4.0);
        textureStore(level_2, tile.origin / 4u + by_2, vec4(mean, 0u, 0u));
    }
    workgroupBarrier();
    if invocation < 4u {
        entries[(by_2.y * 8u + by_2.x) * 4u] = mean;
    }
    workgroupBarrier();
    if invocation == 0u {
        textureStore(level_3, tile.origin / 8u, vec4(mean_at(vec2(0u), 4u, 8.0), 0u, 0u));
    }
}
