// Makes cells of 4, 16 and 64 pixels a side: the nearest depth, and the depth of the back of the furthest surface. Rays skip cells
// that they pass in front of or behind. The three sizes are stored one below the other in one texture.
#import bevy_lean_deferred::effects::reflections::bindings::{
    behind, hi_z_output, depth_sampler, depth_texture, edge_step, view,
}
#import bevy_lean_deferred::cell::{ROWS_BEFORE_16, ROWS_BEFORE_64, pack_cell}

var<workgroup> hi_z_4: array<vec2<f32>, 256>;
var<workgroup> hi_z_16: array<vec2<f32>, 16>;

fn joined(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    return vec2(max(a.x, b.x), min(a.y, b.y));
}

/// Nearest and furthest depth of 4×4 pixels.
fn cell_at(first: vec2<u32>) -> vec2<f32> {
    // Pixels beyond the viewport do not count.
    var cell = vec2(0.0, 1.0);
    if all(first + 4u <= view.viewport_size) {
        let origin = vec2<f32>(view.viewport_origin + first);
        let texel = 1.0 / vec2<f32>(textureDimensions(depth_texture));
        for (var n = 0; n < 4; n++) {
            let middle = origin + vec2<f32>(vec2(1 + 2 * (n & 1), 1 + (n & 2)));
            let depths = textureGather(depth_texture, depth_sampler, middle * texel);
            let largest = max(depths.xy, depths.zw);
            let least = min(depths.xy, depths.zw);
            cell = joined(cell, vec2(max(largest.x, largest.y), min(least.x, least.y)));
        }
        return cell;
    }
    for (var n = 0u; n < 16u; n++) {
        let pixel = first + vec2(n % 4u, n / 4u);
        if all(pixel < view.viewport_size) {
            let depth = textureLoad(depth_texture, vec2<i32>(view.viewport_origin + pixel), 0);
            cell = joined(cell, vec2(depth));
        }
    }
    return cell;
}

fn store(place: vec2<u32>, cell: vec2<f32>) {
    // Nothing is behind the sky.
    let end = select(behind(cell.y) - edge_step(cell.y, 1.0), 0.0, cell.y == 0.0);
    textureStore(hi_z_output, place, vec4(pack_cell(cell.x, end)));
}

/// Each workgroup makes the cells of 64×64 pixels.
@compute @workgroup_size(256, 1, 1)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) i: u32,
) {
    let place = vec2(i % 16u, i / 16u);
    let cell = cell_at(workgroup.xy * 64u + place * 4u);
    hi_z_4[i] = cell;
    store(workgroup.xy * 16u + place, cell);
    workgroupBarrier();
    if i < 16u {
        let place = vec2(i % 4u, i / 4u);
        let first = 4u * (place.x + 16u * place.y);
        var cell = vec2(0.0, 1.0);
        for (var n = 0u; n < 16u; n++) {
            cell = joined(cell, hi_z_4[first + n % 4u + 16u * (n / 4u)]);
        }
        hi_z_16[i] = cell;
        store(vec2(0u, workgroups.y * ROWS_BEFORE_16) + workgroup.xy * 4u + place, cell);
    }
    workgroupBarrier();
    if i == 0u {
        var cell = vec2(0.0, 1.0);
        for (var n = 0u; n < 16u; n++) {
            cell = joined(cell, hi_z_16[n]);
        }
        store(vec2(0u, workgroups.y * ROWS_BEFORE_64) + workgroup.xy, cell);
    }
}
