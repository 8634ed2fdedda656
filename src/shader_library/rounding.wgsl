// Rounding without conversions, which take four times as long as additions. Without bindings.
#define_import_path bevy_lean_deferred::rounding

/// Its sum with an integer near 0 has the integer in its lowest bits.
const ROUNDER: f32 = 12582912.0;

/// Integer start of steps, up to 2²¹ from 0: `ROUNDER` plus it, twice. Compilers do not know that both are equal, and so do not
/// simplify sums with them.
struct Start {
    added: vec2<f32>,
    taken_off: vec2<f32>,
    /// Origin of places, minus the bits of `ROUNDER`.
    origin: vec2<i32>,
}

/// `place` is relative to `origin`.
fn start_at(place: vec2<i32>, origin: vec2<i32>) -> Start {
    let bits = bitcast<i32>(ROUNDER);
    return Start(bitcast<vec2<f32>>(place + bits), vec2<f32>(place) + ROUNDER, origin - bits);
}

/// Integer place.
struct Rounded {
    /// Including the origin.
    place: vec2<i32>,
    /// Offset from the start.
    step: vec2<f32>,
}

/// Integer place nearest to `distance` times `direction` from `start`.
fn rounded(start: Start, direction: vec2<f32>, distance: f32) -> Rounded {
    let sum = fma(direction, vec2(distance), start.added);
    return Rounded(bitcast<vec2<i32>>(sum) + start.origin, sum - start.taken_off);
}

/// Place after this integer step from `start`.
fn place_after(start: Start, step: vec2<f32>) -> vec2<i32> {
    return bitcast<vec2<i32>>(start.added + step) + start.origin;
}

/// Place of the start itself.
fn start_of(start: Start) -> vec2<i32> {
    return bitcast<vec2<i32>>(start.taken_off) + start.origin;
}

/// Its sum with a number near 0 is a multiple of four.
const ROUNDER_TO_FOURS: f32 = 4.0 * ROUNDER;

/// `ROUNDER_TO_FOURS`, made of a `zero` that compilers do not know. Those that may reorder sums would otherwise see that
/// `rounded_to_fours` takes off again what it has added, and not round.
fn rounder_to_fours(zero: i32) -> f32 {
    return bitcast<f32>(bitcast<i32>(ROUNDER_TO_FOURS) + zero);
}

/// Multiple of four nearest to `distance` times `direction` from `start`: its place in fours, and its offset from the start in units.
/// `rounder`: from `rounder_to_fours`.
fn rounded_to_fours(start: vec2<f32>, direction: vec2<f32>, distance: f32, rounder: f32) -> Rounded {
    let sum = fma(direction, vec2(distance), start) + rounder;
    // The constant, not `rounder`, for the same reason.
    return Rounded(bitcast<vec2<i32>>(sum) - bitcast<i32>(ROUNDER_TO_FOURS), (sum - ROUNDER_TO_FOURS) - start);
}
