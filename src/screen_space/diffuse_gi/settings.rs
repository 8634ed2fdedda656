use bevy::{prelude::*, render::extract_component::ExtractComponent};

use crate::screen_space::ScreenSpaceResolution;

/// Screen-space diffuse GI: gathers the last frame's diffuse light from surfaces on screen (Mayaux 2018, "Horizon-based indirect
/// lighting").
///
/// For cameras with [`LeanDeferred`](crate::LeanDeferred). The diffuse radiance of a surface (ambient and diffuse light, transmitted
/// light, emission) illuminates surfaces around it in the next frame, and becomes part of their radiance: light bounces any number
/// of times. Surfaces also occlude environment maps, irradiance volumes and ambient light over the part of the hemisphere that they
/// cover, so that no energy is added. This replaces [`LeanAmbientOcclusion`](crate::LeanAmbientOcclusion), which is off beside this
/// component.
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
///         LeanDeferred::default(),
///         LeanScreenSpaceGi {
///             radius: 6.0,
///             quality: ScreenSpaceGiQuality::High,
///             ..default()
///         },
///     ));
/// }
/// ```
#[derive(Component, ExtractComponent, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(crate::view::LeanStatus)]
pub struct LeanScreenSpaceGi {
    /// Distance in metres beyond which surfaces neither illuminate one another nor occlude. More than 0. Clamped on screen to half of
    /// the viewport's height. Default 4.
    pub radius: f32,
    /// Factor on the light, 0 to 1. Default 1, the physical amount.
    pub intensity: f32,
    /// Angle above the surface, in radians, below which samples are ignored: suppresses noise from depth and normals on flat
    /// surfaces. 0 to π/2; more than 0.5 is rarely useful. Default 0.02.
    pub bias: f32,
    /// Share of the squared radius over which surfaces fade out, 0 (hard edge) to 1. Default 0.5.
    pub falloff: f32,
    /// Number of samples. Default [`ScreenSpaceGiQuality::Medium`].
    pub quality: ScreenSpaceGiQuality,
    /// Resolution at which light is gathered. Default [`ScreenSpaceResolution::Half`].
    pub resolution: ScreenSpaceResolution,
    /// Output that is shown in place of the image. Default `None`, the image.
    pub debug_view: Option<ScreenSpaceGiDebugView>,
}

impl Default for LeanScreenSpaceGi {
    fn default() -> Self {
        Self {
            radius: 4.0,
            intensity: 1.0,
            bias: 0.02,
            falloff: 0.5,
            quality: default(),
            resolution: default(),
            debug_view: None,
        }
    }
}

/// Samples per texel. Sixteen texels take different slices, which a filter averages.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum ScreenSpaceGiQuality {
    /// 1 slice, 8 steps per side.
    Low,
    /// 2 slices, 10 steps per side.
    #[default]
    Medium,
    /// 3 slices, 12 steps per side.
    High,
    /// 4 slices, 16 steps per side.
    Ultra,
}

impl ScreenSpaceGiQuality {
    /// All variants, cheapest first.
    pub const ALL: [Self; 4] = [Self::Low, Self::Medium, Self::High, Self::Ultra];

    /// Slices, and steps per side.
    pub fn samples(self) -> (u32, u32) {
        match self {
            Self::Low => (1, 8),
            Self::Medium => (2, 10),
            Self::High => (3, 12),
            Self::Ultra => (4, 16),
        }
    }
}

/// Outputs for [`LeanScreenSpaceGi::debug_view`].
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[reflect(Clone, PartialEq)]
pub enum ScreenSpaceGiDebugView {
    /// Indirect diffuse light, exposed, as a white surface reflects it.
    Light,
    /// Visibility of the environment, in grey: white where unoccluded.
    Visibility,
}

impl ScreenSpaceGiDebugView {
    /// All variants.
    pub const ALL: [Self; 2] = [Self::Light, Self::Visibility];
}
