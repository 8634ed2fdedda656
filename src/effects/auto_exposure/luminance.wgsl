// Luminance of a colour, safe for any texel value. Without bindings.
#define_import_path bevy_lean_deferred::effects::auto_exposure::luminance

/// ITU-R BT.709-6, 3.2.
const WEIGHTS: vec3<f32> = vec3(0.2126, 0.7152, 0.0722);
const LARGEST: f32 = 65504.0;
/// Base-2 logarithms are clamped to this; black has this one.
const LOWEST_LOG: f32 = -14.0;
/// Luminance at `LOWEST_LOG`.
const SMALLEST: f32 = 6.103515625e-5;

/// Tests the bits, because comparisons with NaN may be optimised away.
fn is_nan(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7fffffffu) > 0x7f800000u;
}

/// Luminance, clamped to 0 to `LARGEST`; -1 for NaN.
fn luminance(color: vec3<f32>) -> f32 {
    let y = dot(color, WEIGHTS);
    return select(clamp(y, 0.0, LARGEST), -1.0, is_nan(y));
}

/// Base-2 logarithm, at least `LOWEST_LOG`.
fn log_luminance(y: f32) -> f32 {
    return max(log2(max(y, 1e-5)), LOWEST_LOG);
}
