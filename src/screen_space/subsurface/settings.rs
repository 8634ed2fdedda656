use bevy::{prelude::*, render::extract_component::ExtractComponent};

use super::active::ActiveScattering;

/// How light scatters beneath surfaces with [`ShadingExtension::Subsurface`](crate::shading_extension::ShadingExtension).
///
/// For cameras with [`LeanDeferred`](crate::LeanDeferred), which scatter it also without this component, as its defaults say.
/// What enters is the diffuse light of the lighting pass, ambient light included; emission, reflections and the light of
/// lightmaps stay where they are. It leaves up to ten mean free paths away: in metres, so that the picture is the same at any
/// distance, resolution and projection. Nothing goes to another material, across a step in depth, or beyond the picture, where
/// the rest is made up for by what is there; so thin parts do not let light through.
///
/// Without TAA each frame is the same; with TAA the places that are looked at turn from frame to frame.
#[derive(Component, ExtractComponent, Reflect, Clone, Copy, Debug, PartialEq)]
#[extract_component_sync_target((Self, ActiveScattering))]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct LeanSubsurfaceScattering {
    /// Default [`SubsurfaceScatteringQuality::Medium`].
    pub quality: SubsurfaceScatteringQuality,
    /// From how far light comes at most, in pixels: nearer to the camera the profile shrinks to that. More than 0. Default
    /// 256.
    pub largest_radius: f32,
}

impl Default for LeanSubsurfaceScattering {
    fn default() -> Self {
        Self {
            quality: default(),
            largest_radius: 256.0,
        }
    }
}

/// How light that scatters is found.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum SubsurfaceScatteringQuality {
    /// Light leaves where it enters.
    Off,
    /// 17 samples across, then 17 down (Jimenez et al. 2015, "Separable Subsurface Scattering"), each of the profile's share
    /// along a line: exact beside straight edges, a little square around spots.
    Separable,
    /// 9 samples of the profile by its inverse (Golubev 2018, "Efficient Screen-Space Subsurface Scattering Using Burley's
    /// Normalized Diffusion in Real-Time"), each of the mean light around it.
    Low,
    /// 15 samples.
    #[default]
    Medium,
    /// 30 samples.
    High,
}

impl SubsurfaceScatteringQuality {
    /// All of them, cheapest first.
    pub const ALL: [Self; 5] = [
        Self::Off,
        Self::Separable,
        Self::Low,
        Self::Medium,
        Self::High,
    ];
}
