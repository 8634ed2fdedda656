// Upper bounds of the memory's speed: a copy, a read, and an idle dispatch.

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

// Position of invocation `i` in a square of 16×16 pixels, along a Z-order curve.
fn place_in_square(i: u32) -> vec2<u32> {
    let x = (i & 1u) | ((i >> 1u) & 2u) | ((i >> 2u) & 4u);
    let y = ((i >> 1u) & 1u) | ((i >> 2u) & 2u) | ((i >> 3u) & 4u);
    return vec2(x, y) + 8u * vec2((i >> 6u) & 1u, i >> 7u);
}

fn color_at(pixel: vec2<u32>) -> vec4<f32> {
    return textureLoad(picture, min(pixel, textureDimensions(picture) - 1u), 0);
}

// Reads as `meter.wgsl` does: eight pixels at once.
@compute @workgroup_size(256)
fn read(@builtin(workgroup_id) tile: vec3<u32>, @builtin(local_invocation_index) invocation: u32) {
    let corner = tile.xy * TILE + place_in_square(invocation);
    var sum = vec4(0.0);
    for (var y = 0u; y < TILE.y; y += 32u) {
        let a = corner + vec2(0u, y);
        let b = corner + vec2(0u, y + 16u);
        let a0 = color_at(a);
        let a1 = color_at(a + vec2(16u, 0u));
        let a2 = color_at(a + vec2(32u, 0u));
        let a3 = color_at(a + vec2(48u, 0u));
        let b0 = color_at(b);
        let b1 = color_at(b + vec2(16u, 0u));
        let b2 = color_at(b + vec2(32u, 0u));
        let b3 = color_at(b + vec2(48u, 0u));
        sum += (a0 + a1 + a2 + a3) + (b0 + b1 + b2 + b3);
    }
    // Never true. The compiler cannot know that, and so keeps the loads.
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
