// What a pair of horizons hides of the hemisphere, weighted by the cosine. Without bindings.
#define_import_path bevy_lean_deferred::horizon

const HALF_PI: f32 = 1.57079633;
const PI: f32 = 3.14159265;

/// The area between an arc of the unit circle and its chord, which is `c` in -1..1 from the centre: `acos(c) - c * sqrt(1 - c * c)`.
/// Off by at most 6.3e-6: of the largest error, the least that a cubic can have.
fn segment(c: f32) -> f32 {
    let a = abs(c);
    let t = max(1.0 - a, 0.0);
    let polynomial = ((0.0114644 * a - 0.0521626) * a + 0.3559525) * a + HALF_PI;
    let area = polynomial * t * sqrt(t);
    return select(PI - area, area, c >= 0.0);
}

/// A normal within the plane of a slice.
struct SliceNormal {
    /// Length of the normal's projection into the plane.
    length: f32,
    /// Cosine and sine of its angle to the viewer.
    cosine: f32,
    sine: f32,
}

/// `to_viewer` and `tangent` are the plane's axes, of unit length.
fn slice_normal(normal: vec3<f32>, to_viewer: vec3<f32>, tangent: vec3<f32>) -> SliceNormal {
    let projected = vec2(dot(normal, to_viewer), dot(normal, tangent));
    let squared = dot(projected, projected);
    if !(squared > 1e-12) {
        return SliceNormal(0.0, 1.0, 0.0);
    }
    let inverse = inverseSqrt(squared);
    return SliceNormal(squared * inverse, projected.x * inverse, projected.y * inverse);
}

/// Cosine-weighted light of one side of a slice between the viewer's direction and the angle whose cosine is `c`, in
/// the closed form of Jimenez et al. 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion", freed of
/// double angles. `side` is 1 or -1.
fn arc(normal: SliceNormal, c: f32, side: f32) -> f32 {
    let s_squared = max(1.0 - c * c, 0.0);
    // The segment changes sign with the side, and so its product with the sine of the mirrored slice.
    return 0.5 * (s_squared * normal.cosine + side * segment(c) * normal.sine);
}

/// The part of the hemisphere about `normal` that lies on `side` between the horizon `c` and the surface: the tangent
/// plane `base`. Both are cosines of angles to the viewer. Exactly 0 where the horizon is the surface.
fn side_occlusion(normal: SliceNormal, base: f32, c: f32, side: f32) -> f32 {
    // Light from below the shading normal's own horizon does not count.
    let lowest = max(base, -side * normal.sine);
    if c <= lowest {
        return 0.0;
    }
    return normal.length * max(arc(normal, lowest, side) - arc(normal, c, side), 0.0);
}

/// Two unit vectors across `n`, which faces +Z at least a little, and across each other (Duff et al. 2017, "Building an
/// Orthonormal Basis, Revisited").
fn tangents(n: vec3<f32>) -> mat2x3<f32> {
    let a = 1.0 / (1.0 + n.z);
    let b = -n.x * n.y * a;
    return mat2x3(vec3(1.0 - n.x * n.x * a, b, -n.x), vec3(b, 1.0 - n.y * n.y * a, -n.y));
}
