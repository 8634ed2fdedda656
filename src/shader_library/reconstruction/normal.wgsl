// Geometric normals from depth. Without bindings: taps are passed in by value.
//
// On a plane, depth is affine in screen space, in perspective (reversed, infinite) and orthographic projections. The differences
// and extrapolations below are therefore exact on planes without linearising first.
#define_import_path bevy_lean_deferred::reconstruction::normal

/// Side (-1 or 1) of the neighbour on an axis that lies on the surface of the centre: the one whose two depths extrapolate closest
/// to the centre (atyuwen 2021, "Accurate Normal Reconstruction from Depth Buffer"). `near_*` are the depths one pixel away, `far_*`
/// those two pixels away, towards -1 (`a`) and +1 (`b`).
fn straighter_side(center: f32, near_a: f32, far_a: f32, near_b: f32, far_b: f32) -> f32 {
    let error_a = abs(2.0 * near_a - far_a - center);
    let error_b = abs(2.0 * near_b - far_b - center);
    return select(1.0, -1.0, error_a < error_b);
}

/// Depth slope per pixel of three pixels, on the flatter side: the other one may be an edge. 0 for a centre in front of both
/// neighbours, whose slope neither side has.
fn flatter_slope(before: f32, center: f32, after: f32) -> f32 {
    let a = center - before;
    let b = after - center;
    return select(select(b, a, abs(a) < abs(b)), 0.0, a > 0.0 && b < 0.0);
}

/// Unit normal facing the viewer, from view-space positions of the pixel and of the chosen neighbours (`side` is 1 for the right
/// or lower one, -1 for the other). Falls back to +Z where the three are collinear.
fn normal_from_positions(
    center: vec3<f32>,
    horizontal: vec3<f32>,
    horizontal_side: f32,
    vertical: vec3<f32>,
    vertical_side: f32,
) -> vec3<f32> {
    let to_right = (horizontal - center) * horizontal_side;
    let to_bottom = (vertical - center) * vertical_side;
    // Right-handed view space, y up: bottom × right points at the viewer.
    let n = cross(to_bottom, to_right);
    // Scaled first: the squared length may be outside the range of f32.
    let largest = max(abs(n.x), max(abs(n.y), abs(n.z)));
    if !(largest > 0.0 && largest < 1e30) {
        return vec3(0.0, 0.0, 1.0);
    }
    return normalize(n / largest);
}

/// Unit normal facing the viewer at `ray` and `depth`, from the slope of depth along the axes of
/// `reconstruction::position::ray_at`. For the kinds of projection for which `view_position` is cheaper, with the same matrix. On a
/// plane the slope is constant. Falls back to +Z where the slope is not finite.
fn normal_from_slope(view_from: mat4x4<f32>, ray: vec2<f32>, depth: f32, slope: vec2<f32>) -> vec3<f32> {
    let m = view_from;
#ifdef PROJECTION_PERSPECTIVE
    // Points are rays divided by q, which is affine on screen. On a plane with n · point = 1, n · ray = q, so n follows from the
    // slope of q. It faces away from the viewer.
    let q = m[2].w * depth + m[3].w;
    // All divided by q: far away, the square of the undivided vector is outside the range of f32.
    let across = m[2].w / q * slope;
    let n = -m[3].z * vec3(across * m[3].z, 1.0 - dot(across, ray));
#else
    let n = vec3(-m[2].z * slope, 1.0 + dot(m[2].xy, slope));
#endif
    let squared = dot(n, n);
    if !(squared > 0.0 && squared < 1e30) {
        return vec3(0.0, 0.0, 1.0);
    }
    return n * inverseSqrt(squared);
}
