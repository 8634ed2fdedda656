// Cosine-weighted occlusion of the hemisphere by a pair of horizons. Without bindings.
#define_import_path bevy_lean_deferred::horizon

const HALF_PI: f32 = 1.57079633;
const PI: f32 = 3.14159265;

/// Area between an arc of the unit circle and its chord at distance `c` (-1 to 1) from the centre: `acos(c) - c * sqrt(1 - c * c)`.
/// A minimax cubic: off by at most 6.3e-6.
fn segment(c: f32) -> f32 {
    let a = abs(c);
    let t = max(1.0 - a, 0.0);
    let polynomial = ((0.0114644 * a - 0.0521626) * a + 0.3559525) * a + HALF_PI;
    let area = polynomial * t * sqrt(t);
    return select(PI - area, area, c >= 0.0);
}

/// Normal projected into the plane of a slice.
struct SliceNormal {
    /// Length of the normal's projection into the plane.
    length: f32,
    /// Cosine and sine of its angle to the viewer.
    cosine: f32,
    sine: f32,
}

/// Projects a normal into a slice. `projected`: its components along the slice's unit axes, to the viewer and along the tangent.
fn slice_normal(projected: vec2<f32>) -> SliceNormal {
    let squared = dot(projected, projected);
    if !(squared > 1e-12) {
        return SliceNormal(0.0, 1.0, 0.0);
    }
    let inverse = inverseSqrt(squared);
    return SliceNormal(squared * inverse, projected.x * inverse, projected.y * inverse);
}

/// Tangents of the angles between a normal's projections into two slices and the viewer, from the normal along both axes and
/// `to_viewer`. Those along axes between are linear in these.
fn lean_of(along_axes: vec2<f32>, to_viewer: f32) -> vec2<f32> {
    // Not infinite: 0 times infinity is NaN.
    return along_axes / max(abs(to_viewer), 1e-6);
}

/// Sine of the angle whose tangent is `lean`.
fn sine_of_lean(lean: f32) -> f32 {
    return lean * inverseSqrt(1.0 + lean * lean);
}

/// Cosine-weighted light of one side of a slice between the viewer's direction and the angle whose cosine is `c`: the closed form
/// of Jimenez et al. 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion", without double angles. `side` is 1
/// or -1.
fn arc(normal: SliceNormal, c: f32, side: f32) -> f32 {
    let s_squared = max(1.0 - c * c, 0.0);
    // The other side is the mirrored slice, where the sine is negated.
    return 0.5 * (s_squared * normal.cosine + side * segment(c) * normal.sine);
}

/// Part of the hemisphere about `normal` on `side` between the horizon `c` and the tangent plane `base` of the surface. Both are
/// cosines of angles to the viewer. Exactly 0 where the horizon is the surface.
fn side_occlusion(normal: SliceNormal, base: f32, c: f32, side: f32) -> f32 {
    // Light from below the shading normal's own horizon does not count.
    let lowest = max(base, -side * normal.sine);
    if c <= lowest {
        return 0.0;
    }
    return normal.length * max(arc(normal, lowest, side) - arc(normal, c, side), 0.0);
}

/// Two unit vectors perpendicular to `n` and to each other (Duff et al. 2017, "Building an Orthonormal Basis, Revisited"). `n`
/// must face +Z at least a little.
fn tangents(n: vec3<f32>) -> mat2x3<f32> {
    let a = 1.0 / (1.0 + n.z);
    let b = -n.x * n.y * a;
    return mat2x3(vec3(1.0 - n.x * n.x * a, b, -n.x), vec3(b, 1.0 - n.y * n.y * a, -n.y));
}
