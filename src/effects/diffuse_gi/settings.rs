use bevy::{prelude::*, render::extract_component::ExtractComponent};

use crate::view::{LeanQuality, LeanResolution, LeanStatus};

/// Screen-space diffuse GI: gathers the last frame's diffuse light from surfaces on screen (Mayaux 2018, "Horizon-based indirect
/// lighting").
///
/// For cameras with [`LeanDeferred`](crate::LeanDeferred), which is added with it. The diffuse radiance of a surface (ambient and
/// diffuse light, transmitted light, emission) illuminates surfaces around it in the next frame, and becomes part of their radiance:
/// light bounces any number of times. Surfaces also occlude environment maps, irradiance volumes and ambient light over the part of the
/// hemisphere that they cover, so that no energy is added. This replaces
/// [`LeanScreenSpaceAmbientOcclusion`](crate::LeanScreenSpaceAmbientOcclusion), which is off beside this component.
///
/// Off-screen and hidden surfaces emit nothing. Meshes in Bevy's forward passes emit and occlude if the camera has `DepthPrepass`,
/// but receive no light. A surface that faces away is assumed to emit as its front does. Without `MotionVectorPrepass`, the light of
/// moving surfaces lags one frame behind.
///
/// Can be added and removed at run time; removing it frees its GPU resources.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_lean_deferred::prelude::*;
/// fn spawn_camera(mut commands: Commands) {
///     commands.spawn((
///         Camera3d::default(),
///         LeanScreenSpaceGi {
///             radius: 6.0,
///             quality: LeanQuality::High,
///             ..default()
///         },
///     ));
/// }
/// ```
///
/// | quality | slices | steps on either side of a slice |
/// |---|---|---|
/// | `Low` | 1 | 8 |
/// | `Medium` | 2 | 10 |
/// | `High` | 3 | 12 |
/// | `Ultra` | 4 | 16 |
#[doc(alias("ssgi", "ssil"))]
#[derive(Component, ExtractComponent, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(LeanStatus)]
pub struct LeanScreenSpaceGi {
    /// Distance in metres beyond which surfaces neither illuminate one another nor occlude. More than 0. Clamped on screen to half of
    /// the viewport's height. Default 4.
    pub radius: f32,
    /// Factor on the light, 0 to 1. Default 1, the physical amount.
    pub intensity: f32,
    /// Samples per texel, as in the table above. The texels of 8×8 take different slices, which a filter averages. Default
    /// [`LeanQuality::Medium`].
    pub quality: LeanQuality,
    /// Resolution at which light is gathered. Default [`LeanResolution::Half`].
    pub resolution: LeanResolution,
    /// Settings that few games change.
    pub advanced: LeanScreenSpaceGiAdvanced,
}

impl Default for LeanScreenSpaceGi {
    fn default() -> Self {
        Self {
            radius: 4.0,
            intensity: 1.0,
            quality: default(),
            resolution: default(),
            advanced: default(),
        }
    }
}

impl LeanScreenSpaceGi {
    /// Slices of a texel, and steps on either side of a slice, by `quality`.
    pub fn samples(&self) -> (u32, u32) {
        match self.quality {
            LeanQuality::Low => (1, 8),
            LeanQuality::Medium => (2, 10),
            LeanQuality::High => (3, 12),
            LeanQuality::Ultra => (4, 16),
        }
    }
}

/// Settings of [`LeanScreenSpaceGi`] that few games change.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct LeanScreenSpaceGiAdvanced {
    /// Angle above the surface, in radians, below which samples are ignored: suppresses noise from depth and normals on flat
    /// surfaces. 0 to π/2; more than 0.5 is rarely useful. Default 0.02.
    pub bias: f32,
    /// Share of the squared radius over which surfaces fade out, 0 (hard edge) to 1. Default 0.5.
    pub falloff: f32,
}

impl Default for LeanScreenSpaceGiAdvanced {
    fn default() -> Self {
        Self {
            bias: 0.02,
            falloff: 0.5,
        }
    }
}
