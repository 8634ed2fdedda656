use bevy::{prelude::*, render::extract_component::ExtractComponent};

use crate::view::overrides::{CameraEffect, Need};

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
///         LeanAmbientOcclusion {
///             radius: 1.0,
///             quality: OcclusionQuality::High,
///             ..default()
///         },
///     ));
/// }
/// ```
///
/// The texture stores occlusion (0 = none) in one channel of 8 bits, so that rounding errs towards none and open surfaces stay
/// exactly unchanged.
#[derive(Component, ExtractComponent, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(crate::view::LeanStatus)]
pub struct LeanAmbientOcclusion {
    /// Distance in metres beyond which nothing occludes. More than 0. Clamped on screen to a quarter of the viewport's height.
    /// Default 0.5.
    pub radius: f32,
    /// Factor on the occlusion, at least 0. Default 1, the physical amount.
    pub intensity: f32,
    /// Angle above the surface, in radians, below which samples are ignored: suppresses noise from depth and normals on flat
    /// surfaces. 0 to π/2; more than 0.5 is rarely useful. Default 0.02.
    pub bias: f32,
    /// Share of the squared radius over which occluders fade out, 0 (hard edge) to 1. Default 0.1.
    pub falloff: f32,
    /// Assumed thickness of occluders, 0 to 1. At 1 (the default) they are infinitely thick, as in a height field. Below 1, horizons
    /// decay by `1 - thickness` per step behind thin occluders (Jimenez et al. 2016).
    pub thickness: f32,
    /// Kernel that computes the occlusion. Default [`OcclusionKernel::Hbao`].
    pub kernel: OcclusionKernel,
    /// Number of samples, for [`OcclusionKernel::Hbao`] only. Default [`OcclusionQuality::Medium`].
    pub quality: OcclusionQuality,
    /// Normals that occlusion is weighted about. Default [`OcclusionNormals::Shading`], which needs a G-buffer.
    pub normals: OcclusionNormals,
    /// Resolution of the occlusion. Default [`OcclusionResolution::Full`].
    pub resolution: OcclusionResolution,
    /// Filter that removes the sample pattern. Default [`OcclusionFilter::BinomialEdgeAware`].
    pub filter: OcclusionFilter,
    /// Application of the occlusion to the image. Default [`OcclusionApplication::Auto`].
    pub application: OcclusionApplication,
    /// Approximates light that bounces between bright walls: brightens and tints their occlusion (Jimenez et al. 2016). For
    /// [`OcclusionApplication::Indirect`] only. Default true.
    pub multibounce: bool,
    /// Share of the occlusion that darkens direct light too, 0 (physical) to 1. For [`OcclusionApplication::Indirect`] only. Default 0.
    pub direct_light_affect: f32,
    /// Shows the filtered occlusion alone, white where unoccluded. With [`OcclusionApplication::Indirect`] it covers only meshes in
    /// the G-buffer. Later passes draw over it. Default false.
    pub debug_view: bool,
}

impl LeanAmbientOcclusion {
    /// True if directions are spread over 4×4 pixels, for a wide filter. Half resolution has a single filter.
    #[doc(hidden)]
    pub fn has_wide_pattern(&self) -> bool {
        self.filter.is_wide() && self.resolution == OcclusionResolution::Full
    }
}

impl CameraEffect for LeanAmbientOcclusion {
    const NAME: &'static str = "LeanAmbientOcclusion";
    const NEEDS: &'static [Need] = &[Need::WithoutMsaa];
}

impl Default for LeanAmbientOcclusion {
    fn default() -> Self {
        Self {
            radius: 0.5,
            intensity: 1.0,
            bias: 0.02,
            falloff: 0.1,
            thickness: 1.0,
            kernel: default(),
            quality: default(),
            normals: default(),
            resolution: default(),
            filter: default(),
            application: default(),
            multibounce: true,
            direct_light_affect: 0.0,
            debug_view: false,
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

/// Samples per pixel of [`OcclusionKernel::Hbao`]. Each slice has two sides. The pixels of a 2×2 or 4×4 block take different slices,
/// which the filter averages. The numbers are compiled into the shader.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum OcclusionQuality {
    /// 1 slice, 3 steps per side.
    Low,
    /// 1 slice, 6 steps per side.
    #[default]
    Medium,
    /// 2 slices, 8 steps per side.
    High,
    /// 4 slices, 12 steps per side.
    Ultra,
}

impl OcclusionQuality {
    /// All presets, cheapest first.
    pub const PRESETS: [Self; 4] = [Self::Low, Self::Medium, Self::High, Self::Ultra];

    /// Slices, and steps per side.
    pub fn samples(self) -> (u32, u32) {
        match self {
            Self::Low => (1, 3),
            Self::Medium => (1, 6),
            Self::High => (2, 8),
            Self::Ultra => (4, 12),
        }
    }
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

/// Resolution of the occlusion.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum OcclusionResolution {
    /// One value per pixel.
    #[default]
    Full,
    /// One value per 2×2 pixels; the filter upsamples along depth edges.
    Half,
}

impl OcclusionResolution {
    /// Pixels per side that share a value.
    pub(super) fn divisor(self) -> u32 {
        match self {
            Self::Full => 1,
            Self::Half => 2,
        }
    }
}

/// Weights of the filter that removes the sample pattern, in which pixels sample different directions.
/// [Half resolution](OcclusionResolution::Half) has a single set of weights for all of them.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum OcclusionFilter {
    /// 1 2 1 / 2 4 2 / 1 2 1: removes any 2×2 pattern exactly.
    Binomial,
    /// 1 2 2 2 1 along each axis: removes any 4×4 pattern exactly, so samples use one, with four times as many directions. For
    /// surfaces so close to the camera that the other filters leave their few directions and steps visible. Slower.
    Wide,
    /// As `Binomial`, ignoring neighbours across a depth step.
    #[default]
    BinomialEdgeAware,
    /// As `Wide`, ignoring neighbours across a depth step.
    WideEdgeAware,
}

impl OcclusionFilter {
    /// All variants.
    pub const ALL: [Self; 4] = [
        Self::Binomial,
        Self::Wide,
        Self::BinomialEdgeAware,
        Self::WideEdgeAware,
    ];

    /// True if 5×5 pixels are averaged.
    pub fn is_wide(self) -> bool {
        matches!(self, Self::Wide | Self::WideEdgeAware)
    }

    /// True if neighbours across a depth step are ignored.
    pub fn is_edge_aware(self) -> bool {
        matches!(self, Self::BinomialEdgeAware | Self::WideEdgeAware)
    }
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
    /// The lighting pass darkens ambient light, environment maps, probes and irradiance volumes. Meshes in Bevy's forward passes
    /// neither receive nor cast occlusion. Falls back to [`MultiplicativeBlend`](Self::MultiplicativeBlend) where the camera is not
    /// rendered lean.
    Indirect,
}
