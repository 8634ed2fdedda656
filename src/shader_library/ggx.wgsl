// Lobe of a rough mirror, in tangent space: z is the normal. Without bindings.
#define_import_path bevy_lean_deferred::ggx

const PI: f32 = 3.14159265358979;

/// Least squared `alpha` of densities: above the rounding errors of squared cosines.
const LEAST_SPREAD: f32 = 1e-6;

/// Sampled direction of the lobe.
struct LobeSample {
    /// Unit vector to the light; below the surface if `weight` is 0.
    direction: vec3<f32>,
    /// Reflected share of light from there, divided by its density, without Fresnel: 0 to 1.
    weight: f32,
    /// Density of directions, per steradian.
    density: f32,
}

/// Microfacet visible from `V`, sampled by the random numbers `u`, 0 to 1 (Dupuy and Benyoub 2023, "Sampling Visible GGX Normals
/// with Spherical Caps"). `alpha` is the square of perceptual roughness; at 0, the microfacet is the normal.
fn visible_microfacet(V: vec3<f32>, alpha: f32, u: vec2<f32>) -> vec3<f32> {
    let stretched = normalize(vec3(alpha * V.xy, V.z));
    let z = (1.0 - u.y) * (1.0 + stretched.z) - stretched.z;
    let sine = sqrt(saturate(1.0 - z * z));
    let turn = 2.0 * PI * u.x;
    let half = vec3(sine * cos(turn), sine * sin(turn), z) + stretched;
    return normalize(vec3(alpha * half.xy, max(half.z, 1e-7)));
}

/// Samples a direction from which light is reflected to `V`, which is above the surface.
fn sample_lobe(V: vec3<f32>, alpha: f32, u: vec2<f32>) -> LobeSample {
    let microfacet = visible_microfacet(V, alpha, u);
    let L = reflect(-V, microfacet);
    if !(L.z > 0.0) {
        return LobeSample(L, 0.0, 1.0);
    }
    // Height-correlated Smith shadowing and masking (Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based
    // BRDFs").
    let a2 = alpha * alpha;
    let root_v = sqrt(a2 + (1.0 - a2) * V.z * V.z);
    let root_l = sqrt(a2 + (1.0 - a2) * L.z * L.z);
    let weight = L.z * (V.z + root_v) / (L.z * root_v + V.z * root_l);
    // A perfect mirror has a single direction, of infinite density. Its lobe is wider than rounding errors of `spread` here.
    let wide = max(a2, LEAST_SPREAD);
    let spread = 1.0 - (1.0 - wide) * microfacet.z * microfacet.z;
    let distribution = wide / (PI * spread * spread);
    return LobeSample(L, weight, max(distribution / (2.0 * (V.z + root_v)), 1e-6));
}
