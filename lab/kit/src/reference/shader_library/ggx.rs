//! GGX lobe of a rough mirror. `ggx.wgsl` has the documentation.

use core::f32::consts::PI;

use bevy::math::{Vec2, Vec3};

pub const LEAST_SPREAD: f32 = 1e-6;

/// Sampled direction of the lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LobeSample {
    /// Towards the light, unit length; below the surface if `weight` is 0.
    pub direction: Vec3,
    /// Share of the light from there that is seen, divided by the density: 0 to 1, without Fresnel.
    pub weight: f32,
    /// Probability density of the direction, per steradian.
    pub density: f32,
}

/// Microfacet that is visible from `v`, sampled with the random numbers `u` in 0 to 1.
pub fn visible_microfacet(v: Vec3, alpha: f32, u: Vec2) -> Vec3 {
    let stretched = Vec3::new(alpha * v.x, alpha * v.y, v.z).normalize();
    let z = (1.0 - u.y) * (1.0 + stretched.z) - stretched.z;
    let sine = (1.0 - z * z).clamp(0.0, 1.0).sqrt();
    let turn = 2.0 * PI * u.x;
    let half = Vec3::new(sine * turn.cos(), sine * turn.sin(), z) + stretched;
    Vec3::new(alpha * half.x, alpha * half.y, half.z.max(1e-7)).normalize()
}

/// Samples a direction from which light is reflected towards `v`.
pub fn sample_lobe(v: Vec3, alpha: f32, u: Vec2) -> LobeSample {
    let microfacet = visible_microfacet(v, alpha, u);
    let direction = 2.0 * v.dot(microfacet) * microfacet - v;
    if direction.z.is_nan() || direction.z <= 0.0 {
        return LobeSample {
            direction,
            weight: 0.0,
            density: 1.0,
        };
    }
    let a2 = alpha * alpha;
    let root = |z: f32| (a2 + (1.0 - a2) * z * z).sqrt();
    let (root_v, root_l) = (root(v.z), root(direction.z));
    let weight = direction.z * (v.z + root_v) / (direction.z * root_v + v.z * root_l);
    let wide = a2.max(LEAST_SPREAD);
    let spread = 1.0 - (1.0 - wide) * microfacet.z * microfacet.z;
    let distribution = wide / (PI * spread * spread);
    LobeSample {
        direction,
        weight,
        density: (distribution / (2.0 * (v.z + root_v))).max(1e-6),
    }
}
