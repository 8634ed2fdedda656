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

/// By how much `ray_at` changes over so many pixels.
fn ray_step(view_from: mat4x4<f32>, pixels: vec2<f32>) -> vec2<f32> {
#ifdef PROJECTION_PERSPECTIVE
    return pixels * vec2(view_from[0][0], view_from[1][1]);
#else ifdef PROJECTION_ORTHOGRAPHIC
    return pixels * vec2(view_from[0][0], view_from[1][1]);
#else
    return pixels;
#endif
}

/// What all positions that are seen at a place have in common. It is linear in the place.
fn ray_at(view_from: mat4x4<f32>, place: vec2<f32>) -> vec2<f32> {
#ifdef PROJECTION_PERSPECTIVE
    return ray_step(view_from, place) + view_from[3].xy;
#else ifdef PROJECTION_ORTHOGRAPHIC
    return ray_step(view_from, place) + view_from[3].xy;
#else
    return place;
#endif
}

/// The view-space position of this depth on `ray_at`.
fn position_on(view_from: mat4x4<f32>, ray: vec2<f32>, depth: f32) -> vec3<f32> {
    let m = view_from;
#ifdef PROJECTION_PERSPECTIVE
    return vec3(ray, m[3].z) / (m[2].w * depth + m[3].w);
#else ifdef PROJECTION_ORTHOGRAPHIC
    // Temporal jitter shears.
    return vec3(ray, m[3].z) + depth * m[2].xyz;
#else
    let position = homogeneous_position(m, vec3(ray, depth));
    return position.xyz / position.w;
#endif
}

/// What the position on `ray_at` of this depth is divided by.
fn w_at(view_from: mat4x4<f32>, ray: vec2<f32>, depth: f32) -> f32 {
    let m = view_from;
#ifdef PROJECTION_PERSPECTIVE
    return m[2].w * depth + m[3].w;
#else ifdef PROJECTION_ORTHOGRAPHIC
    return 1.0;
#else
    return homogeneous_position(m, vec3(ray, depth)).w;
#endif
}

/// Of steps of a pixel to the right, of a pixel downwards, and of a depth of 1: how far they lead from `position`, times the w of where
/// they lead; and by how much they raise w. All four are linear in them.
fn homogeneous_steps(view_from: mat4x4<f32>, position: vec3<f32>) -> mat3x4<f32> {
    let m = view_from;
#ifdef PROJECTION_PERSPECTIVE
    return mat3x4(vec4(m[0].x, 0.0, 0.0, 0.0), vec4(0.0, m[1].y, 0.0, 0.0), m[2].w * vec4(-position, 1.0));
#else ifdef PROJECTION_ORTHOGRAPHIC
    return mat3x4(vec4(m[0].x, 0.0, 0.0, 0.0), vec4(0.0, m[1].y, 0.0, 0.0), vec4(m[2].xyz, 0.0));
#else
    return mat3x4(
        vec4(m[0].xyz - m[0].w * position, m[0].w),
        vec4(m[1].xyz - m[1].w * position, m[1].w),
        vec4(m[2].xyz - m[2].w * position, m[2].w),
    );
#endif
}

/// x and y of a view-space position, which is on `ray_at`, for each metre of its z; 0 where all rays run alike.
fn ray_slope(view_from: mat4x4<f32>, ray: vec2<f32>, position: vec3<f32>) -> vec2<f32> {
#ifdef PROJECTION_PERSPECTIVE
    // Rays end at z = -1.
    return -ray;
#else ifdef PROJECTION_ORTHOGRAPHIC
    return vec2(0.0);
#else
    return position.xy / position.z;
#endif
}

/// As `homogeneous_position`, divided by w. Cheaper where the projection is known to be of a common kind, and `view_from`
/// normalised by `reconstruction::position::normalized`: what is left out then is 0 in such matrices, or 1 where they divide.
fn view_position(view_from: mat4x4<f32>, p: vec3<f32>) -> vec3<f32> {
    return position_on(view_from, ray_at(view_from, p.xy), p.z);
}

#ifdef PROJECTION_PERSPECTIVE
/// z of `view_position`, of four depths.
fn view_z(view_from: mat4x4<f32>, depths: vec4<f32>) -> vec4<f32> {
    return view_from[3].z / (view_from[2].w * depths + view_from[3].w);
}
#endif
