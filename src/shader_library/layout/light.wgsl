// Light packed with a shared exponent, and in half floats.
//
// Mantissas R 9, G 9, B 9, exponent 5, low to high, as in the graphics APIs' RGB9E5.
#define_import_path bevy_lean_deferred::gbuffer::layout::light

#import bevy_lean_deferred::gbuffer::layout::is_nan

/// Largest value of a channel. Brighter ones are clamped.
const LARGEST_LIGHT: f32 = 65408.0;
/// Largest half float.
const LARGEST_HALF: f32 = 65504.0;

/// 2 to the power of `n`, exactly, for -126 to 127.
fn power_of_two(n: i32) -> f32 {
    return bitcast<f32>(u32(n + 127) << 23u);
}

/// Integer part of the binary logarithm of a normal, positive number: its exponent bits.
fn integer_logarithm(x: f32) -> i32 {
    return i32(bitcast<u32>(x) >> 23u) - 127;
}

/// Packs linear, exposed light. Negative values and colours with a NaN become 0.
fn pack_light(color: vec3<f32>) -> u32 {
    let number = select(color, vec3(0.0), is_nan(color.r + color.g + color.b));
    let valid = clamp(number, vec3(0.0), vec3(LARGEST_LIGHT));
    let largest = max(valid.r, max(valid.g, valid.b));
    var exponent = max(integer_logarithm(largest), -16) + 16;
    // The mantissa would be rounded up to ten bits.
    if largest * power_of_two(24 - exponent) + 0.5 >= 512.0 {
        exponent += 1;
    }
    let mantissas = vec3<u32>(valid * power_of_two(24 - exponent) + 0.5);
    return mantissas.r | (mantissas.g << 9u) | (mantissas.b << 18u) | (u32(exponent) << 27u);
}

/// Unpacks light from `pack_light`.
fn unpack_light(word: u32) -> vec3<f32> {
    return unpack_mantissas(word) * unpack_scale(word);
}

/// Light in units of `unpack_scale`.
fn unpack_mantissas(word: u32) -> vec3<f32> {
    let mantissas = vec3(word & 0x1ffu, (word >> 9u) & 0x1ffu, (word >> 18u) & 0x1ffu);
    // As the lowest bits of 2²³: GPUs convert integers at a fraction of the rate at which they add.
    return bitcast<vec3<f32>>(mantissas | vec3(0x4b000000u)) - 8388608.0;
}

/// A power of two.
fn unpack_scale(word: u32) -> f32 {
    return power_of_two(i32(word >> 27u) - 24);
}

/// Packs four half floats.
fn pack_halves(x: vec4<f32>) -> vec2<u32> {
    return vec2(pack2x16float(x.xy), pack2x16float(x.zw));
}

fn unpack_halves(words: vec2<u32>) -> vec4<f32> {
    return vec4(unpack2x16float(words.x), unpack2x16float(words.y));
}

/// Clamps light, infinite light too, to the range of half floats. Otherwise drivers may store infinity, of which bloom makes NaN.
/// NaN is kept.
fn within_halves(color: vec3<f32>) -> vec3<f32> {
    return select(color, sign(color) * LARGEST_HALF, abs(color) > vec3(LARGEST_HALF));
}
