// Metering weight of a pixel. Without bindings.
#define_import_path bevy_lean_deferred::effects::auto_exposure::pattern

/// Weight, 0 to 1, at `position` in pixels from the corner of a viewport of `size`.
fn pattern_weight(position: vec2<f32>, size: vec2<f32>, spot_radius: f32) -> f32 {
    let offset = (position - 0.5 * size) / size.y;
    let distance_squared = dot(offset, offset);
#ifdef CENTER_WEIGHTED
    return exp(-8.0 * distance_squared);
#else ifdef SPOT
    return f32(distance_squared < spot_radius * spot_radius);
#else
    return 1.0;
#endif
}
