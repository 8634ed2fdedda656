// Reflection of a rough surface: interpolates the lobes of the texels around it.
#define_import_path bevy_lean_deferred::effects::reflections::rough_light

#import bevy_lean_deferred::gbuffer::layout::light::{pack_halves, unpack_halves}
#import bevy_lean_deferred::effects::reflections::bindings::filtered_texture
#import bevy_lean_deferred::effects::reflections::receiver::{Receiver, texel_beside}
#import bevy_lean_deferred::effects::reflections::texels::{CACHE_SIDE, nearest_inside}

/// Light times confidence, and confidence, of the lobes of texels.
var<workgroup> filtered: array<vec2<u32>, CACHE_SIDE * CACHE_SIDE>;

fn lobe_at(texel: vec2<i32>) -> vec4<f32> {
    return textureLoad(filtered_texture, nearest_inside(texel), 0);
}

/// Without `counts`, the texel of the texture is undefined.
fn keep_lobe(read: i32, lobe: vec4<f32>, counts: bool) {
    filtered[read] = select(vec2(0u), pack_halves(lobe), counts);
}

/// Light times confidence, and confidence. The directions of each lobe weigh alike, and so do those of their mean.
fn rough_light(receiver: Receiver, first: i32) -> vec4<f32> {
    var sum = vec4(0.0);
    var weights = 1e-12;
    for (var i = 0; i < 4; i++) {
        let weight = receiver.weights[i];
        sum += weight * unpack_halves(filtered[texel_beside(first, i)]);
        weights += weight;
    }
    return sum / weights;
}
