// How exposure follows the metered luminance. Without bindings.
#define_import_path bevy_lean_deferred::auto_exposure::adaptation

/// What of a distance of `stops` to the target is covered after `seconds`: constant `speed` (stops a second) down to
/// `transition` stops, exponential from there. Solved exactly, so that neither the frame rate nor a long frame matters.
fn covered(stops: f32, seconds: f32, speed: f32, transition: f32) -> f32 {
    let linear_part = max(stops - transition, 0.0);
    let linear_travel = speed * seconds;
    if linear_travel <= linear_part {
        return linear_travel;
    }
    if transition <= 0.0 {
        return stops;
    }
    let x = (linear_travel - linear_part) / transition;
    // 1 - exp(-x); of a small x, the difference would keep few digits.
    let share = select(1.0 - exp(-x), x - 0.5 * x * x, x < 0.01);
    return linear_part + (stops - linear_part) * share;
}

/// The exposure after `seconds` on the way from `current` to `target_exposure`, in stops.
fn adapted(
    current: f32,
    target_exposure: f32,
    seconds: f32,
    speed_brighten: f32,
    speed_darken: f32,
    transition: f32,
) -> f32 {
    let distance = target_exposure - current;
    // The scene is darker than it was, or brighter.
    let speed = select(speed_brighten, speed_darken, distance > 0.0);
    let exposure = current + sign(distance) * covered(abs(distance), seconds, speed, transition);
    return clamp(exposure, min(current, target_exposure), max(current, target_exposure));
}
