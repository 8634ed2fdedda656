//! Adaptation of the exposure to the metered luminance.

/// Part of a distance of `stops` to the target that is covered within `seconds`: constant `speed` (stops per second) down to
/// `transition` stops, exponential from there. In closed form, so that it does not depend on the frame rate.
pub fn covered(stops: f32, seconds: f32, speed: f32, transition: f32) -> f32 {
    let linear_part = (stops - transition).max(0.0);
    let linear_travel = speed * seconds;
    if linear_travel <= linear_part {
        return linear_travel;
    }
    if transition <= 0.0 {
        return stops;
    }
    let x = (linear_travel - linear_part) / transition;
    // 1 - exp(-x), which would cancel for small x.
    let share = if x < 0.01 {
        x - 0.5 * x * x
    } else {
        1.0 - (-x).exp()
    };
    linear_part + (stops - linear_part) * share
}

/// Exposure in stops, `seconds` later, on the way from `current` to `target_exposure`.
pub fn adapted(
    current: f32,
    target_exposure: f32,
    seconds: f32,
    speed_brighten: f32,
    speed_darken: f32,
    transition: f32,
) -> f32 {
    let distance = target_exposure - current;
    if distance == 0.0 {
        return target_exposure;
    }
    // A rising exposure follows a darker scene.
    let speed = if distance > 0.0 {
        speed_darken
    } else {
        speed_brighten
    };
    let exposure =
        current + distance.signum() * covered(distance.abs(), seconds, speed, transition);
    exposure.clamp(current.min(target_exposure), current.max(target_exposure))
}
