//! Distance fog as the crate's own passes compute it.

use bevy::{
    pbr::{DistanceFog, FogFalloff},
    prelude::*,
    render::render_resource::ShaderType,
};

/// Modes of [`FogUniform`]; the one after them is exponential in the square of the distance.
pub const CLEAR: u32 = 0;
pub const LINEAR: u32 = 1;
pub const EXPONENTIAL: u32 = 2;
const EXPONENTIAL_SQUARED: u32 = 3;

/// Distance fog of a view. `distance_fog.wgsl` has the documentation.
#[derive(ShaderType, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(no_auto_register)]
pub struct FogUniform {
    pub color: Vec4,
    pub extinction: Vec3,
    pub mode: u32,
    pub inscattering: Vec3,
}

impl FogUniform {
    pub fn new(fog: Option<&DistanceFog>) -> Self {
        let Some(fog) = fog else {
            return Self::default();
        };
        let (mode, extinction, inscattering) = match fog.falloff {
            FogFalloff::Linear { start, end } => {
                let ends = Vec3::new(start, end, 0.0);
                (LINEAR, ends, ends)
            }
            FogFalloff::Exponential { density } => {
                (EXPONENTIAL, Vec3::splat(density), Vec3::splat(density))
            }
            FogFalloff::ExponentialSquared { density } => (
                EXPONENTIAL_SQUARED,
                Vec3::splat(density),
                Vec3::splat(density),
            ),
            FogFalloff::Atmospheric {
                extinction,
                inscattering,
            } => (EXPONENTIAL, extinction, inscattering),
        };
        Self {
            color: fog.color.to_linear().to_vec4(),
            extinction,
            mode,
            inscattering,
        }
    }
}
