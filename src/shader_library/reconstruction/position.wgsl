// From depth to positions. Without bindings: matrices are passed in by value.
#define_import_path bevy_lean_deferred::reconstruction::position

/// Keeps positions finite for geometry so far away that its reversed depth is 0, and the squares of their differences
/// within f32.
const SMALLEST_DEPTH: f32 = 1e-14;

/// Normalised device coordinates of a fragment, which counts from the corner of the target. `viewport` is a corner and a
/// size in pixels, as in Bevy's `View`.
fn ndc_of_fragment(frag_coord: vec2<f32>, viewport: vec4<f32>) -> vec2<f32> {
    let uv = (frag_coord - viewport.xy) / viewport.zw;
    return uv * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
}

/// View-space position of `p`, homogeneous: `view_from` leads there from the space of `p`, whose z is depth. Into the
/// world it goes through view space, not by `world_from_clip`: that matrix loses digits far from the origin.
fn homogeneous_position(view_from: mat4x4<f32>, p: vec3<f32>) -> vec4<f32> {
    return view_from * vec4(p, 1.0);
}

/// As `homogeneous_position`, divided by w. Cheaper where the projection is known to be of a common kind, and `view_from`
/// normalised by `reconstruction::position::normalized`: what is left out then is 0 in such matrices, or 1 where they divide.
fn view_position(view_from: mat4x4<f32>, p: vec3<f32>) -> vec3<f32> {
    let m = view_from;
#ifdef PROJECTION_PERSPECTIVE
    let ray = vec3(p.xy * vec2(m[0][0], m[1][1]) + m[3].xy, m[3].z);
    return ray / (m[2].w * p.z + m[3].w);
#else ifdef PROJECTION_ORTHOGRAPHIC
    // Temporal jitter shears.
    return vec3(p.xy * vec2(m[0][0], m[1][1]), 0.0) + p.z * m[2].xyz + m[3].xyz;
#else
    let position = homogeneous_position(m, p);
    return position.xyz / position.w;
#endif
}

#ifdef PROJECTION_PERSPECTIVE
/// z of `view_position`, of four depths.
fn view_z(view_from: mat4x4<f32>, depths: vec4<f32>) -> vec4<f32> {
    return view_from[3].z / (view_from[2].w * depths + view_from[3].w);
}
#endif
