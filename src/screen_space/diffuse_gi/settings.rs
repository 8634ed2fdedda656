use bevy::{prelude::*, render::extract_component::ExtractComponent};

use crate::screen_space::ScreenSpaceResolution;

/// Light that surfaces send to one another: what the picture shows of it, from the last frame (Mayaux 2018, "Horizon-based indirect
/// lighting").
///
/// For cameras with [`LeanDeferred`](crate::LeanDeferred). What a surface sends out in all directions (ambient and diffuse
/// light, transmitted light, emission) falls onto those around it in the next frame, and there is part of what it sends out
/// again: light bounces as often as it likes. The part of the hemisphere that those surfaces take is hidden from environment
/// maps, irradiance volumes and ambient light, so that light is never made: beside this component
/// [`LeanAmbientOcclusion`](crate::LeanAmbientOcclusion) has nothing to do in the lighting pass, and is off.
///
/// What the picture does not show sends nothing: what is beyond its rim, or hidden. Meshes that Bevy's forward passes draw shine
/// and hide where the camera has `DepthPrepass`, and get no light. A surface that faces away is taken to shine as its front
/// does. Without `MotionVectorPrepass` the light of what moves
/// is a frame behind it.
///
/// Adding or removing it at run time switches the effect and frees what it held.
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
pub struct LeanScreenSpaceGi {
    /// Distance past which surfaces neither shine on one another nor hide the sky, in metres. More than 0. On screen it is
    /// at most half of the viewport's height; nearer to the camera it shrinks to that. Default 4.
    pub radius: f32,
    /// Factor on the light, 0 to 1. 1 (the default) is the physical amount.
    pub intensity: f32,
    /// Angle above the surface, in radians, below which nothing counts: keeps noise of depth and normals out of flat
    /// regions. 0 to π/2; more than 0.5 is hardly of use. Default 0.02.
    pub bias: f32,
    /// Share of the squared radius over which surfaces fade out, 0 (hard edge) to 1. Default 0.5.
    pub falloff: f32,
    /// How many samples are taken. Default [`ScreenSpaceGiQuality::Medium`].
    pub quality: ScreenSpaceGiQuality,
    /// How many pixels share a texel, for which light is found. Default [`ScreenSpaceResolution::Half`].
    pub resolution: ScreenSpaceResolution,
    /// What is shown in place of the picture. Default `None`, the picture.
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

/// How many samples a texel takes. Its slices are those of sixteen texels, which a filter brings together.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum ScreenSpaceGiQuality {
    /// 1 slice, 8 steps a side.
    Low,
    /// 2 slices, 10 steps a side.
    #[default]
    Medium,
    /// 3 slices, 12 steps a side.
    High,
    /// 4 slices, 16 steps a side.
    Ultra,
}

impl ScreenSpaceGiQuality {
    /// All of them, cheapest first.
    pub const ALL: [Self; 4] = [Self::Low, Self::Medium, Self::High, Self::Ultra];

    /// Slices, and steps on each side of one.
    pub fn samples(self) -> (u32, u32) {
        match self {
            Self::Low => (1, 8),
            Self::Medium => (2, 10),
            Self::High => (3, 12),
            Self::Ultra => (4, 16),
        }
    }
}

/// What has been found, for [`LeanScreenSpaceGi::debug_view`].
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[reflect(Clone, PartialEq)]
pub enum ScreenSpaceGiDebugView {
    /// Light that other surfaces send, exposed: what a white surface would show of it.
    Light,
    /// What they leave of the environment, grey: white where nothing is hidden.
    Visibility,
}

impl ScreenSpaceGiDebugView {
    /// Both of them.
    pub const ALL: [Self; 2] = [Self::Light, Self::Visibility];
}
