// How exposure follows the metered luminance. Without bindings; twin of `adaptation.rs`, under the same names.
#define_import_path bevy_lean_deferred::auto_exposure::adaptation

/// What is left of a distance of `stops` to the target after `seconds`: constant `speed` (stops a second) down to
/// `transition` stops, exponential from there. Solved exactly, so that neither the frame rate nor a long frame matters.
fn remaining(stops: f32, seconds: f32, speed: f32, transition: f32) -> f32 {
    let linear_part = max(stops - transition, 0.0);
    let linear_travel = speed * seconds;
    if linear_travel <= linear_part {
        return stops - linear_travel;
    }
    if transition <= 0.0 {
        return 0.0;
    }
    let start = stops - linear_part;
    return start * exp(-(linear_travel - linear_part) / transition);
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
    let speed = select(speed_darken, speed_brighten, distance > 0.0);
    let rest = remaining(abs(distance), seconds, speed, transition);
    return target_exposure - sign(distance) * rest;
}
