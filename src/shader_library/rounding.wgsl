// Rounding without conversions, which take four times as long as additions. Without bindings.
#define_import_path bevy_lean_deferred::rounding

/// Whole numbers near 0 stand in the lowest bits of this plus them.
const ROUNDER: f32 = 12582912.0;

/// Two whole numbers, as integers and as they are.
struct Rounded {
    /// More than they are by the bits of `ROUNDER`: who adds them to something can have that be as much less.
    bits: vec2<i32>,
    number: vec2<f32>,
}

/// The nearest whole numbers, up to 2²² from 0. The bits that are set are set already; compilers do not know, and so do not take the
/// sum apart.
fn rounded(x: vec2<f32>) -> Rounded {
    let bits = bitcast<vec2<u32>>(x + ROUNDER) | vec2(0x4b000000u);
    return Rounded(vec2<i32>(bits), bitcast<vec2<f32>>(bits) - ROUNDER);
}
