// Compares surfaces with those that the last frame showed in their place. Without bindings.
#define_import_path bevy_lean_deferred::effects::reprojection

/// Weight, 0 to 1, with which a surface that the last frame showed at depth `kept` is the expected one: 1 up to `tolerance`, and 0
/// from twice that on, so that no light appears or vanishes at once. `at_rest` is the depth of a surface at rest in the world,
/// `with_view` that of one that moved with the camera. Those between the two moved more slowly than the camera. The three are
/// depths of the last frame, or distances along its view direction.
fn weight_of_match(kept: f32, at_rest: f32, with_view: f32, tolerance: f32) -> f32 {
    let below = min(at_rest, with_view) - kept;
    let above = kept - max(at_rest, with_view);
    return saturate(2.0 - max(max(below, above), 0.0) / max(tolerance, 1e-30));
}

/// Pixels by which a surface that the last frame showed at `at` moved on its own: neither at rest in the world, nor with the camera.
fn own_motion(at: vec2<f32>, at_rest: vec2<f32>, with_view: vec2<f32>) -> f32 {
    return min(distance(at, at_rest), distance(at, with_view));
}

/// `light`, with that of `other` in the share that is unknown. w: the weight, 0 to 1, with which light is known.
fn filled_up(light: vec4<f32>, other: vec4<f32>) -> vec4<f32> {
    let share = (1.0 - light.w) * other.w;
    let known = light.w + share;
    return vec4((light.rgb * light.w + other.rgb * share) / max(known, 1e-6), known);
}
