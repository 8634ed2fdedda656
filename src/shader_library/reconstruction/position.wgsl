// Positions from depth. Without bindings: matrices are passed in by value.
#define_import_path bevy_lean_deferred::reconstruction::position

/// Keeps positions finite for geometry so far away that its reversed depth is 0, and the squares of their differences within the
/// range of f32.
const SMALLEST_DEPTH: f32 = 1e-14;

/// NDC of a fragment, whose coordinates are relative to the target's corner. `viewport` is a corner and a size in pixels, as in
/// Bevy's `View`.
fn ndc_of_fragment(frag_coord: vec2<f32>, viewport: vec4<f32>) -> vec2<f32> {
    let uv = (frag_coord - viewport.xy) / viewport.zw;
    return uv * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
}

/// Homogeneous view-space position of `p`, whose z is depth. `view_from` transforms from the space of `p`. World positions go
/// through view space, because `world_from_clip` loses precision far from the origin.
fn homogeneous_position(view_from: mat4x4<f32>, p: vec3<f32>) -> vec4<f32> {
    return view_from * vec4(p, 1.0);
}

/// Change of `ray_at` over this many pixels.
fn ray_step(view_from: mat4x4<f32>, pixels: vec2<f32>) -> vec2<f32> {
#ifdef PROJECTION_PERSPECTIVE
    return pixels * vec2(view_from[0][0], view_from[1][1]);
#else ifdef PROJECTION_ORTHOGRAPHIC
    return pixels * vec2(view_from[0][0], view_from[1][1]);
#else
    return pixels;
#endif
}

/// Ray through `place`: the coordinates that all positions seen there share. Linear in `place`.
fn ray_at(view_from: mat4x4<f32>, place: vec2<f32>) -> vec2<f32> {
#ifdef PROJECTION_PERSPECTIVE
    return ray_step(view_from, place) + view_from[3].xy;
#else ifdef PROJECTION_ORTHOGRAPHIC
    return ray_step(view_from, place) + view_from[3].xy;
#else
    return place;
#endif
}

/// View-space position at this depth on a ray of `ray_at`.
fn position_on(view_from: mat4x4<f32>, ray: vec2<f32>, depth: f32) -> vec3<f32> {
    let m = view_from;
#ifdef PROJECTION_PERSPECTIVE
    return vec3(ray, m[3].z) / (m[2].w * depth + m[3].w);
#else ifdef PROJECTION_ORTHOGRAPHIC
    // Temporal jitter shears the matrix.
    return vec3(ray, m[3].z) + depth * m[2].xyz;
#else
    let position = homogeneous_position(m, vec3(ray, depth));
    return position.xyz / position.w;
#endif
}

/// Homogeneous w at this depth on a ray of `ray_at`.
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

/// Change per pixel to the right, per pixel downwards and per unit of depth. xyz: offset from `position`, times w at its end; w:
/// change of w. All are linear in the steps.
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

/// View-space x and y per metre of z on a ray of `ray_at`; 0 where all rays are parallel.
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

/// Screen direction, y downwards, of a view-space `direction` at a position with this `ray_slope`. Without the scale of either axis.
fn direction_on_screen(slope: vec2<f32>, direction: vec3<f32>) -> vec2<f32> {
    let across = direction.xy - direction.z * slope;
    return vec2(across.x, -across.y);
}

/// Like `homogeneous_position`, divided by w. Cheaper where the projection is of a common kind and `view_from` is normalised by
/// `reconstruction::position::normalized`: the omitted elements of such matrices are 0, or 1 where they divide.
fn view_position(view_from: mat4x4<f32>, p: vec3<f32>) -> vec3<f32> {
    return position_on(view_from, ray_at(view_from, p.xy), p.z);
}

#ifdef PROJECTION_PERSPECTIVE
/// z of `view_position`, for four depths.
fn view_z(view_from: mat4x4<f32>, depths: vec4<f32>) -> vec4<f32> {
    return view_from[3].z / (view_from[2].w * depths + view_from[3].w);
}
#endif
