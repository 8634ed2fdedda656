// Rounding without conversions, which take four times as long as additions. Without bindings.
#define_import_path bevy_lean_deferred::rounding

/// Whole numbers near 0 stand in the lowest bits of this plus them.
const ROUNDER: f32 = 12582912.0;

/// A whole place, up to 2²¹ from 0, that steps lead away from: `ROUNDER` plus it, twice. Compilers do not know that both are the same,
/// and so do not take sums with them apart.
struct Start {
    added: vec2<f32>,
    taken_off: vec2<f32>,
    /// Where places count from, less the bits of `ROUNDER`.
    origin: vec2<i32>,
}

/// `place` counts from `origin`.
fn start_at(place: vec2<i32>, origin: vec2<i32>) -> Start {
    let bits = bitcast<i32>(ROUNDER);
    return Start(bitcast<vec2<f32>>(place + bits), vec2<f32>(place) + ROUNDER, origin - bits);
}

/// Whole places.
struct Rounded {
    /// With the origin.
    place: vec2<i32>,
    /// From the start to there.
    step: vec2<f32>,
}

/// The place that is nearest to so many times `direction` from `start`.
fn rounded(start: Start, direction: vec2<f32>, distance: f32) -> Rounded {
    let sum = fma(direction, vec2(distance), start.added);
    return Rounded(bitcast<vec2<i32>>(sum) + start.origin, sum - start.taken_off);
}
