//! Distance fog along the ways of light. `distance_fog.wgsl` has the documentation.

use bevy::math::{Vec3, Vec4Swizzles};
pub use bevy_lean_deferred::shader_library::distance_fog::{
    CLEAR, EXPONENTIAL, FogUniform, LINEAR,
};

pub const LEAST_TRANSMITTANCE: f32 = 1.0 / 64.0;

fn density_of(fog: &FogUniform, strength: Vec3, metres: f32) -> Vec3 {
    let share = match fog.mode {
        LINEAR => {
            let [start, end, _] = strength.to_array();
            Vec3::splat(1.0 - ((end - metres) / (end - start)).clamp(0.0, 1.0))
        }
        mode => {
            let depth = strength * metres;
            let depth = if mode == EXPONENTIAL {
                depth
            } else {
                depth * depth
            };
            1.0 - (-depth).exp()
        }
    };
    share * fog.color.w
}

pub fn transmittance(fog: &FogUniform, metres: f32) -> Vec3 {
    1.0 - density_of(fog, fog.extinction, metres)
}

pub fn fog_light(fog: &FogUniform, metres: f32) -> Vec3 {
    fog.color.xyz() * density_of(fog, fog.inscattering, metres)
}

pub fn without_fog(fog: &FogUniform, seen: Vec3, metres: f32, exposure_ratio: f32) -> Vec3 {
    let transmitted = (seen - exposure_ratio * fog_light(fog, metres)).max(Vec3::ZERO);
    transmitted / transmittance(fog, metres).max(Vec3::splat(LEAST_TRANSMITTANCE))
}

pub fn fogged_in_mirror(fog: &FogUniform, light: Vec3, to_mirror: f32, path: f32) -> Vec3 {
    let along_path =
        light * transmittance(fog, path) + fog_light(fog, path) - fog_light(fog, to_mirror);
    along_path.max(Vec3::ZERO) / transmittance(fog, to_mirror).max(Vec3::splat(LEAST_TRANSMITTANCE))
}
