// Filters gathered light: the mean of 4×4 texels, whose slices cover all directions of the pattern, without texels of other
// surfaces.
#import bevy_lean_deferred::reconstruction::normal::flatter_slope
#import bevy_lean_deferred::effects::diffuse_gi::bindings::{
    edge_step, gathered_texture, levels, output_texture, view,
}
#import bevy_lean_deferred::effects::diffuse_gi::entry::unpack_depth

/// Side of the texels that a workgroup reads: its 8×8, one before and two after.
const CACHE_SIDE: u32 = 11u;

var<workgroup> light: array<vec4<f32>, 121>;
var<workgroup> depths: array<f32, 121>;

@compute @workgroup_size(64, 1, 1)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) i: u32) {
    let corner = vec2<i32>(workgroup.xy) * 8 - 1;
    let last = vec2<i32>(view.texture_size) - 1;
    for (var read = i; read < CACHE_SIDE * CACHE_SIDE; read += 64u) {
        let texel = corner + vec2<i32>(vec2(read % CACHE_SIDE, read / CACHE_SIDE));
        let inside = clamp(texel, vec2(0), last);
        light[read] = textureLoad(gathered_texture, inside, 0);
        let depth = unpack_depth(textureLoad(levels, inside, 0).r);
        // Texels beyond the border have no weight.
        depths[read] = select(0.0, depth, all(texel == inside));
    }
    workgroupBarrier();

    let place = vec2(i % 8u, i / 8u);
    let texel = workgroup.xy * 8u + place;
    if any(texel >= view.texture_size) {
        return;
    }
    let center = (place.x + 1u) + CACHE_SIDE * (place.y + 1u);
    let depth = depths[center];
    var sum = vec4(0.0);
    var weights = 0.0;
    if depth > 0.0 {
        let slope = vec2(
            flatter_slope(depths[center - 1u], depth, depths[center + 1u]),
            flatter_slope(depths[center - CACHE_SIDE], depth, depths[center + CACHE_SIDE]),
        );
        let inverse_step = 1.0 / edge_step(depth, f32(view.divisor));
        for (var y = 0u; y < 4u; y++) {
            for (var x = 0u; x < 4u; x++) {
                let other = center + x + CACHE_SIDE * y - 1u - CACHE_SIDE;
                let expected = depth + dot(slope, vec2(f32(x) - 1.0, f32(y) - 1.0));
                let is_surface = depths[other] > 0.0;
                let weight = saturate(2.0 - abs(depths[other] - expected) * inverse_step) * f32(is_surface);
                let clipped = min(weight, 1.0);
                sum += light[other] * clipped;
                weights += clipped;
            }
        }
    }
    let mean = sum / max(weights, 1e-6);
    // Clamp to the whole hemisphere.
    textureStore(output_texture, texel, mean / max(mean.a, 1.0));
}
