// Values of the four texels around a point, as `textureGather` returns them. Without bindings.
#define_import_path bevy_lean_deferred::gathered

/// Value of the texel nearest to the point, which is `along` of the way from the centre of the first to that of the last.
fn nearest_of(around: vec4<f32>, along: vec2<f32>) -> f32 {
    let is_second = along >= vec2(0.5);
    return select(select(around.w, around.z, is_second.x), select(around.x, around.y, is_second.x), is_second.y);
}

/// Value at the point, between those of the texels.
fn interpolated(around: vec4<f32>, along: vec2<f32>) -> f32 {
    return mix(mix(around.w, around.z, along.x), mix(around.x, around.y, along.x), along.y);
}

/// Largest difference of a texel from `value`.
fn largest_difference(around: vec4<f32>, value: f32) -> f32 {
    let off = abs(around - value);
    return max(max(off.x, off.y), max(off.z, off.w));
}
