use bevy::{prelude::*, render::extract_component::ExtractComponent};

use crate::view::{
    LeanQuality, LeanResolution,
    overrides::{CameraEffect, Need},
};

/// Ambient occlusion from depth: darkens surfaces where nearby surfaces block ambient light.
///
/// Works on any `Camera3d`, with or without [`LeanDeferred`](crate::LeanDeferred). It reads the depth of the opaque meshes and needs
/// no prepass. MSAA is switched off when the component is added and restored when it is removed. The camera's schedule must be
/// `Core3d`, and its viewport must have the full depth range.
/// Can be added and removed at run time; removing it frees its GPU resources.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_lean_deferred::prelude::*;
/// fn spawn_camera(mut commands: Commands) {
///     commands.spawn((
///         Camera3d::default(),
///         // With it, occlusion darkens only indirect light; without it, the whole image.
///         LeanDeferred::default(),
///         LeanScreenSpaceAmbientOcclusion {
///             radius: 1.0,
///             quality: LeanQuality::High,
///             ..default()
///         },
///     ));
/// }
/// ```
///
/// | quality | slices | steps on either side of a slice |
/// |---|---|---|
/// | `Low` | 1 | 3 |
/// | `Medium` | 1 | 6 |
/// | `High` | 2 | 8 |
/// | `Ultra` | 4 | 12 |
///
/// The texture stores occlusion (0 = none) in one channel of 8 bits, so that rounding errs towards none and open surfaces stay
/// exactly unchanged.
#[doc(alias("ssao", "hbao", "gtao"))]
#[derive(Component, ExtractComponent, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(crate::view::LeanStatus)]
pub struct LeanScreenSpaceAmbientOcclusion {
    /// Distance in metres beyond which nothing occludes. More than 0. Clamped on screen to a quarter of the viewport's height.
    /// Default 0.5.
    pub radius: f32,
    /// Factor on the occlusion, at least 0. Default 1, the physical amount.
    pub intensity: f32,
    /// Samples per pixel, as in the table above, for [`OcclusionKernel::Hbao`] only. Default [`LeanQuality::Medium`].
    pub quality: LeanQuality,
    /// Resolution of the occlusion. Default [`LeanResolution::Full`].
    pub resolution: LeanResolution,
    /// Application of the occlusion to the image. Default [`OcclusionApplication::Auto`].
    pub application: OcclusionApplication,
    /// Share of the occlusion that darkens direct light too, 0 (physical) to 1. For [`OcclusionApplication::Indirect`] only. Default 0.
    pub direct_light: f32,
    /// Assumed thickness of occluders in metres, at least 0, for [`OcclusionKernel::Hbao`] only. Default `None`: infinite, as in a
    /// height field. Otherwise horizons decay behind an occluder, to 1/e over this distance (after Jimenez et al. 2016, whose decay is
    /// per step).
    pub thickness: Option<f32>,
    /// Settings that few games change.
    pub advanced: LeanScreenSpaceAmbientOcclusionAdvanced,
}

impl LeanScreenSpaceAmbientOcclusion {
    /// Slices of a pixel, and steps on either side of a slice, by `quality`.
    pub fn samples(&self) -> (u32, u32) {
        match self.quality {
            LeanQuality::Low => (1, 3),
            LeanQuality::Medium => (1, 6),
            LeanQuality::High => (2, 8),
            LeanQuality::Ultra => (4, 12),
        }
    }

    /// True if directions are spread over 4×4 pixels, for a wide filter. Half resolution has a single filter.
    #[doc(hidden)]
    pub fn has_wide_pattern(&self) -> bool {
        self.advanced.filter == OcclusionFilter::Wide && self.resolution == LeanResolution::Full
    }
}

impl CameraEffect for LeanScreenSpaceAmbientOcclusion {
    const NAME: &'static str = "LeanScreenSpaceAmbientOcclusion";
    const NEEDS: &'static [Need] = &[Need::WithoutMsaa];
}

impl Default for LeanScreenSpaceAmbientOcclusion {
    fn default() -> Self {
        Self {
            radius: 0.5,
            intensity: 1.0,
            quality: default(),
            resolution: LeanResolution::Full,
            application: default(),
            direct_light: 0.0,
            thickness: None,
            advanced: default(),
        }
    }
}

/// Settings of [`LeanScreenSpaceAmbientOcclusion`] that few games change.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct LeanScreenSpaceAmbientOcclusionAdvanced {
    /// Kernel that computes the occlusion. Default [`OcclusionKernel::Hbao`].
    pub kernel: OcclusionKernel,
    /// Angle above the surface, in radians, below which samples are ignored: suppresses noise from depth and normals on flat
    /// surfaces. 0 to π/2; more than 0.5 is rarely useful. Default 0.02.
    pub bias: f32,
    /// Share of the squared radius over which occluders fade out, 0 (hard edge) to 1. Default 0.1.
    pub falloff: f32,
    /// Normals that occlusion is weighted about. Default [`OcclusionNormals::Shading`], which needs a G-buffer.
    pub normals: OcclusionNormals,
    /// Width of the filter that removes the sample pattern. Default [`OcclusionFilter::Narrow`].
    pub filter: OcclusionFilter,
    /// The filter ignores neighbours across a depth step. Default true.
    pub edge_aware: bool,
    /// Approximates light that bounces between bright walls: brightens and tints their occlusion (Jimenez et al. 2016). For
    /// [`OcclusionApplication::Indirect`] only. Default true.
    pub multibounce: bool,
    /// Share of the occlusion that darkens the light of lightmaps too, 0 to 1. A lightmap has the occlusion of the meshes that it was
    /// baked with: more than 0 darkens their corners twice, but lets meshes that move occlude baked light. Surfaces with emission
    /// keep their baked light. For [`OcclusionApplication::Indirect`] only. Default 0, as in Bevy.
    pub baked_light: f32,
}

impl Default for LeanScreenSpaceAmbientOcclusionAdvanced {
    fn default() -> Self {
        Self {
            kernel: default(),
            bias: 0.02,
            falloff: 0.1,
            normals: default(),
            filter: default(),
            edge_aware: true,
            multibounce: true,
            baked_light: 0.0,
        }
    }
}

/// Kernels that compute the occlusion of a pixel.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum OcclusionKernel {
    /// Horizon-based (Bavoil and Sainz 2008, "Image-space horizon-based ambient occlusion"): marches directions × steps and keeps
    /// the highest sample of each direction. The part below the horizons is weighted by the **cosine** to the normal, in closed form
    /// (Jimenez et al. 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion").
    #[default]
    Hbao,
    /// Small gather-based kernel (after AMD's HDAO, 2009, "High Definition Ambient Occlusion"): opposite pairs of depths that form a
    /// valley, 4 at a time, without normals. Cheap; detects creases, underestimates walls.
    Hdao,
}

/// Normals that occlusion is weighted about. With either, the surface known from depth does not occlude itself: flat surfaces stay
/// at 0, even with mapped or interpolated normals.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum OcclusionNormals {
    /// The G-buffer's if lighting applies the occlusion ([`OcclusionApplication::Indirect`]); otherwise the geometric ones.
    #[default]
    Shading,
    /// Reconstructed from depth with nine taps (atyuwen 2021, "Accurate Normal Reconstruction from Depth Buffer").
    Geometric,
}

/// Width of the filter that removes the sample pattern, in which pixels sample different directions.
/// [Half resolution](LeanResolution::Half) has a single filter of 4×4 texels.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum OcclusionFilter {
    /// 1 2 1 / 2 4 2 / 1 2 1: removes any 2×2 pattern exactly.
    #[default]
    Narrow,
    /// 1 2 2 2 1 along each axis: removes any 4×4 pattern exactly, so samples use one, with four times as many directions. For
    /// surfaces so close to the camera that the narrow filter leaves their few directions and steps visible. Slower.
    Wide,
}

impl OcclusionFilter {
    /// All variants.
    pub const ALL: [Self; 2] = [Self::Narrow, Self::Wide];
}

/// Application of the occlusion to the image.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum OcclusionApplication {
    /// [`Indirect`](Self::Indirect) on cameras with [`LeanDeferred`](crate::LeanDeferred): it is exact and needs no pass.
    /// [`MultiplicativeBlend`](Self::MultiplicativeBlend) on all others, since Bevy's own shaders cannot read the occlusion.
    #[default]
    Auto,
    /// Multiplies the image by `1 - occlusion`, after the opaque meshes and before transmissive and transparent ones. Darkens all
    /// light, including direct light, but not distance fog in front of a surface. Unoccluded pixels are bit-identical, as is alpha.
    MultiplicativeBlend,
    /// The lighting pass darkens ambient light, environment maps, probes and irradiance volumes, and lightmaps by
    /// [`baked_light`](LeanScreenSpaceAmbientOcclusionAdvanced::baked_light). Meshes in Bevy's forward passes neither receive nor
    /// cast occlusion. Falls back to [`MultiplicativeBlend`](Self::MultiplicativeBlend) where the camera is not rendered lean.
    Indirect,
}
