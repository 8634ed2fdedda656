use bevy::{prelude::*, render::extract_component::ExtractComponent};

use crate::{
    screen_space::ScreenSpaceResolution,
    view::overrides::{CameraEffect, Need},
};

/// What surfaces mirror of the picture: rays through this frame's depth, into the light of the last frame.
///
/// For cameras with [`LeanDeferred`](crate::LeanDeferred). A smooth mirror shows one place, found for each pixel; a rough
/// one the mean of sixteen rays of its lobe (GGX), shared by neighbours. Nothing is random from frame to frame unless
/// the camera's projection is jittered, as TAA does. Lighting mixes it with environment maps, reflection probes and ambient
/// light, in the place of which it is seen: with the same Fresnel, roughness and energy terms, and with or without them.
///
/// What the picture does not show is not mirrored: what is beyond its rim, hidden, or turned away. There the
/// environment is seen, as without the component. Nor are meshes that Bevy's forward passes draw, unless the camera has
/// `DepthPrepass`; they mirror nothing. What they and transparent meshes add to the picture in front of what is mirrored is in
/// it. Without `MotionVectorPrepass` the light of what moves is a frame behind it. Anisotropic surfaces mirror as isotropic
/// ones.
///
/// Adding or removing it at run time switches the effect and frees what it held.
#[derive(Component, ExtractComponent, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct LeanScreenSpaceReflections {
    /// How far surfaces reach behind their front, in metres: what passes further behind is not mirrored. More than 0. Default
    /// 0.25.
    pub thickness: f32,
    /// Perceptual roughness, 0 to 1, of surfaces that mirror nothing of the picture. Those within a quarter of it fade.
    /// Default 0.8.
    pub max_roughness: f32,
    /// Share of the viewport's height, from its rim, over which reflections fade. 0 to 0.5. Default 0.05.
    pub edge_fade: f32,
    /// How much of it is shown in the place of the environment, 0 to 1. Default 1.
    pub intensity: f32,
    /// How far rays go. Default [`ScreenSpaceReflectionsQuality::Medium`].
    pub quality: ScreenSpaceReflectionsQuality,
    /// How many rays there are. Default [`ScreenSpaceResolution::Half`].
    pub resolution: ScreenSpaceResolution,
}

impl CameraEffect for LeanScreenSpaceReflections {
    const NEEDS: &'static [Need] = &[Need::WithoutMsaa, Need::Hdr];
}

impl Default for LeanScreenSpaceReflections {
    fn default() -> Self {
        Self {
            thickness: 0.25,
            max_roughness: 0.8,
            edge_fade: 0.05,
            intensity: 1.0,
            quality: default(),
            resolution: default(),
        }
    }
}

/// After how many steps a ray is given up: from cell to cell, of 4 to 64 pixels a side, the largest that it can pass at once, and
/// in them from pixel to pixel. Rays of surfaces smoother than a perceptual roughness of 0.2 look at each pixel, and get four
/// times as many.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum ScreenSpaceReflectionsQuality {
    /// 32.
    Low,
    /// 64.
    #[default]
    Medium,
    /// 128.
    High,
}

impl ScreenSpaceReflectionsQuality {
    /// All of them, cheapest first.
    pub const ALL: [Self; 3] = [Self::Low, Self::Medium, Self::High];

    /// Of rough surfaces.
    pub fn steps(self) -> u32 {
        match self {
            Self::Low => 32,
            Self::Medium => 64,
            Self::High => 128,
        }
    }
}
