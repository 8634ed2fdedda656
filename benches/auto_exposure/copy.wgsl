// What the memory gives at best: a copy, a read, and a dispatch that does nothing.

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var target_picture: texture_storage_2d<rgba16float, write>;
@group(0) @binding(2) var<storage, read_write> total: f32;

@compute @workgroup_size(16, 16)
fn copy(@builtin(global_invocation_id) pixel: vec3<u32>) {
    if all(pixel.xy < textureDimensions(picture)) {
        textureStore(target_picture, pixel.xy, textureLoad(picture, pixel.xy, 0));
    }
}

const TILE: vec2<u32> = vec2(64u, 128u);

// In the order of `meter.wgsl`.
@compute @workgroup_size(256)
fn read(@builtin(workgroup_id) tile: vec3<u32>, @builtin(local_invocation_index) invocation: u32) {
    let quad = vec2(invocation & 1u, (invocation >> 1u) & 1u);
    let in_square = quad + 2u * vec2((invocation >> 2u) & 7u, invocation >> 5u);
    var sum = vec4(0.0);
    for (var y = 0u; y < 8u; y++) {
        for (var x = 0u; x < 4u; x++) {
            let pixel = tile.xy * TILE + 16u * vec2(x, y) + in_square;
            if all(pixel < textureDimensions(picture)) {
                sum += textureLoad(picture, pixel, 0);
            }
        }
    }
    // Never; but the compiler does not know, and so keeps the loads.
    if dot(sum, vec4(1.0)) < 0.0 {
        total = 1.0;
    }
}

@compute @workgroup_size(256)
fn nothing(@builtin(local_invocation_index) invocation: u32) {
    if invocation == 256u {
        total = 1.0;
    }
}
