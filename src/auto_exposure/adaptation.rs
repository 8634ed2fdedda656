//! How exposure follows the metered luminance; twin of `adaptation.wgsl`, under the same names.

/// What is left of a distance of `stops` to the target after `seconds`: constant `speed` (stops a second) down to
/// `transition` stops, exponential from there. Solved exactly, so that neither the frame rate nor a long frame matters.
pub fn remaining(stops: f32, seconds: f32, speed: f32, transition: f32) -> f32 {
    let linear_part = (stops - transition).max(0.0);
    let linear_travel = speed * seconds;
    if linear_travel <= linear_part {
        return stops - linear_travel;
    }
    if transition <= 0.0 {
        return 0.0;
    }
    let start = stops - linear_part;
    start * (-(linear_travel - linear_part) / transition).exp()
}

/// The exposure after `seconds` on the way from `current` to `target_exposure`, in stops.
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
    let speed = if distance > 0.0 {
        speed_brighten
    } else {
        speed_darken
    };
    let rest = remaining(distance.abs(), seconds, speed, transition);
    target_exposure - distance.signum() * rest
}
