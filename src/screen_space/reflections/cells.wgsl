// The nearest and the furthest depth of cells of 4, 16 and 64 pixels a side, through which rays pass at once: the three
// sizes one below the other in one texture.
#import bevy_lean_deferred::screen_space::reflections::bindings::{cells_output, depth_texture, view}

var<workgroup> cells_4: array<vec2<f32>, 256>;
var<workgroup> cells_16: array<vec2<f32>, 16>;

fn joined(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    return vec2(max(a.x, b.x), min(a.y, b.y));
}

/// Each workgroup makes the cells of 64×64 pixels.
@compute @workgroup_size(256, 1, 1)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) i: u32,
) {
    let place = vec2(i % 16u, i / 16u);
    let first = workgroup.xy * 64u + place * 4u;
    // Beyond the viewport nothing is.
    var cell = vec2(0.0, 1.0);
    for (var n = 0u; n < 16u; n++) {
        let pixel = first + vec2(n % 4u, n / 4u);
        if all(pixel < view.viewport_size) {
            let depth = textureLoad(depth_texture, vec2<i32>(view.viewport_origin + pixel), 0);
            cell = joined(cell, vec2(depth));
        }
    }
    cells_4[i] = cell;
    textureStore(cells_output, workgroup.xy * 16u + place, vec4(cell, 0.0, 0.0));
    workgroupBarrier();
    if i < 16u {
        let place = vec2(i % 4u, i / 4u);
        let first = 4u * (place.x + 16u * place.y);
        var cell = vec2(0.0, 1.0);
        for (var n = 0u; n < 16u; n++) {
            cell = joined(cell, cells_4[first + n % 4u + 16u * (n / 4u)]);
        }
        cells_16[i] = cell;
        let row = workgroups.y * 16u;
        textureStore(cells_output, vec2(0u, row) + workgroup.xy * 4u + place, vec4(cell, 0.0, 0.0));
    }
    workgroupBarrier();
    if i == 0u {
        var cell = vec2(0.0, 1.0);
        for (var n = 0u; n < 16u; n++) {
            cell = joined(cell, cells_16[n]);
        }
        let row = workgroups.y * 20u;
        textureStore(cells_output, vec2(0u, row) + workgroup.xy, vec4(cell, 0.0, 0.0));
    }
}
