// Adaptation of exposure to the metered luminance. Without bindings.
#define_import_path bevy_lean_deferred::effects::auto_exposure::adaptation

/// Part of a distance of `stops` covered after `seconds`: at constant `speed` (stops per second) down to `transition` stops,
/// exponentially from there. Solved exactly, so neither the frame rate nor a long frame matters.
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
    // 1 - exp(-x), which would lose precision for small x.
    let share = select(1.0 - exp(-x), x - 0.5 * x * x, x < 0.01);
    return linear_part + (stops - linear_part) * share;
}

/// Exposure in stops after `seconds` on the way from `current` to `target_exposure`.
fn adapted(
    current: f32,
    target_exposure: f32,
    seconds: f32,
    speed_brighten: f32,
    speed_darken: f32,
    transition: f32,
) -> f32 {
    let distance = target_exposure - current;
    // Exposure rises where the scene has darkened, and falls where it has brightened.
    let speed = select(speed_brighten, speed_darken, distance > 0.0);
    let exposure = current + sign(distance) * covered(abs(distance), seconds, speed, transition);
    return clamp(exposure, min(current, target_exposure), max(current, target_exposure));
}
