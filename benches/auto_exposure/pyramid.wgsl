// The classic reduction in three passes. Passes hand on sums, and only the last one divides, so that sizes that are not
// multiples of 8 are metered exactly. `Invocation` and `workgroup_sum` are in `sum_shared.wgsl` or
// `sum_subgroups.wgsl`.

struct Metered {
    /// Number of pixels of the whole picture.
    pixels: f32,
    luminance: f32,
}

// The picture in the first pass, then the output of the pass before.
@group(0) @binding(0) var source: texture_2d<f32>;
@group(0) @binding(1) var reduced: texture_storage_2d<r32float, write>;
@group(0) @binding(2) var<storage, read_write> metered: Metered;

/// Pixel of an invocation, in squares of 8×8.
fn pixel_of(at: Invocation) -> vec2<u32> {
    return at.workgroup.xy * 8u + vec2(at.index % 8u, at.index / 8u);
}

@compute @workgroup_size(64)
fn reduce_picture(at: Invocation) {
    let pixel = pixel_of(at);
    var value = 0.0;
    if all(pixel < textureDimensions(source)) {
        let y = dot(textureLoad(source, pixel, 0).rgb, vec3(0.2126, 0.7152, 0.0722));
        value = log2(clamp(y, 0.00006103515625, 65504.0));
    }
    let sum = workgroup_sum(at, value, 64u);
    if at.index == 0u {
        textureStore(reduced, at.workgroup.xy, vec4(sum));
    }
}

@compute @workgroup_size(64)
fn reduce_sums(at: Invocation) {
    let pixel = pixel_of(at);
    var value = 0.0;
    if all(pixel < textureDimensions(source)) {
        value = textureLoad(source, pixel, 0).r;
    }
    let sum = workgroup_sum(at, value, 64u);
    if at.index == 0u {
        textureStore(reduced, at.workgroup.xy, vec4(sum));
    }
}

@compute @workgroup_size(256)
fn reduce_rest(at: Invocation) {
    let size = textureDimensions(source);
    var value = 0.0;
    for (var i = at.index; i < size.x * size.y; i += 256u) {
        value += textureLoad(source, vec2(i % size.x, i / size.x), 0).r;
    }
    let sum = workgroup_sum(at, value, 256u);
    if at.index == 0u {
        metered.luminance = exp2(sum / metered.pixels);
    }
}
