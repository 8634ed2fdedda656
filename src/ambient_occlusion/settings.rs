use bevy::{
    prelude::*,
    render::{extract_component::ExtractComponent, render_resource::TextureFormat},
};

use crate::view::overrides::{CameraEffect, Need};

/// Darkens what neighbouring surfaces hide from the light that comes from everywhere.
///
/// Works on any `Camera3d`, with or without [`LeanDeferred`](crate::LeanDeferred): it reads the depth that the opaque
/// meshes leave, and needs no prepass. No MSAA (switched off when the component is added, given back when it is removed); the schedule is
/// `Core3d`, and the viewport has all of depth.
/// Adding or removing it at run time switches the effect and frees what it held.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_lean_deferred::prelude::*;
/// fn spawn_camera(mut commands: Commands) {
///     commands.spawn((
///         Camera3d::default(),
///         // With it, occlusion darkens indirect light alone; without it, the whole picture.
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
/// Occlusion is stored as occlusion (0 = none) in one channel, so that rounding errs towards none and open surfaces
/// stay exactly as they were.
#[derive(Component, ExtractComponent, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct LeanAmbientOcclusion {
    /// Distance past which nothing occludes, in metres. More than 0. On screen it is at most a quarter of the
    /// viewport's height; nearer to the camera it shrinks to that. Default 0.5.
    pub radius: f32,
    /// Factor on the occlusion, from 0. 1 (the default) is the physical amount.
    pub intensity: f32,
    /// Angle above the surface, in radians, below which nothing counts: keeps noise of depth and normals out of flat
    /// regions. 0 to π/2; more than 0.5 is hardly of use. Default 0.02.
    pub bias: f32,
    /// Share of the squared radius over which occluders fade out, 0 (hard edge) to 1. Default 0.1.
    pub falloff: f32,
    /// How far back what is in front of a surface reaches, 0 to 1. 1 (the default): without end, as a height field does. Below that,
    /// horizons sink again behind thin parts, by `1 - thickness` a step (Jimenez et al. 2016).
    pub thickness: f32,
    /// How occlusion is found. Default [`OcclusionKernel::Hbao`].
    pub kernel: OcclusionKernel,
    /// How many samples are taken. Only of [`OcclusionKernel::Hbao`]. Default [`OcclusionQuality::Medium`].
    pub quality: OcclusionQuality,
    /// About which normal occlusion is weighted. Default [`OcclusionNormals::Shading`], where there is a G-buffer.
    pub normals: OcclusionNormals,
    /// How many pixels share an occlusion value. Default [`OcclusionResolution::Full`].
    pub resolution: OcclusionResolution,
    /// What removes the samples' pattern. Default [`OcclusionFilter::BinomialEdgeAware`].
    pub filter: OcclusionFilter,
    /// How occlusion is stored. Default [`OcclusionFormat::Unorm8`].
    pub format: OcclusionFormat,
    /// How occlusion reaches the picture. Default [`OcclusionApplication::Auto`].
    pub application: OcclusionApplication,
    /// Light that bounces between bright walls lifts their occlusion and tints it (Jimenez et al. 2016). Only of
    /// [`OcclusionApplication::Indirect`]. Default true.
    pub multibounce: bool,
    /// How far direct light is darkened too, 0 (not; physical) to 1. Only of [`OcclusionApplication::Indirect`]; more
    /// than 0 lights each pixel twice. Default 0.
    pub direct_light_affect: f32,
    /// Shows the filtered occlusion alone, white where there is none; with [`OcclusionApplication::Indirect`] on what the
    /// G-buffer holds. What is drawn later lies over it. Default false.
    pub debug_view: bool,
}

impl LeanAmbientOcclusion {
    /// Whether directions are spread over 4×4 pixels, for a wide filter of them: from half resolution there is one filter.
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
            format: default(),
            application: default(),
            multibounce: true,
            direct_light_affect: 0.0,
            debug_view: false,
        }
    }
}

/// Ways to find the occlusion of a pixel.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum OcclusionKernel {
    /// Horizon-based (Bavoil and Sainz 2008, "Image-space horizon-based ambient occlusion"): directions × steps, the
    /// highest sample of each direction. What the horizons hide is weighted by the **cosine** to the normal, in closed
    /// form (Jimenez et al. 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion").
    #[default]
    Hbao,
    /// The small, gather-based one (after AMD's HDAO, 2009, "High Definition Ambient Occlusion"): opposite pairs of
    /// depths that form a valley, 4 at a time, without normals. Cheap; finds creases, underestimates walls.
    Hdao,
}

/// How many samples [`OcclusionKernel::Hbao`] takes a pixel. Each slice has two sides, and a block of pixels takes
/// different slices, 2×2 of them or 4×4, which the filter brings together.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum OcclusionQuality {
    /// 1 slice, 3 steps a side.
    Low,
    /// 1 slice, 6 steps a side.
    #[default]
    Medium,
    /// 2 slices, 8 steps a side.
    High,
    /// 4 slices, 12 steps a side.
    Ultra,
    /// Any number: slices 1 to 16, steps 1 to 64. They may change from frame to frame: one shader runs them all. Those of
    /// the presets are compiled for their numbers.
    Custom {
        /// Directions through the pixel, 1 to 16.
        slices: u32,
        /// Samples on each of the two sides of a slice, 1 to 64.
        steps: u32,
    },
}

impl OcclusionQuality {
    /// All presets, cheapest first.
    pub const PRESETS: [Self; 4] = [Self::Low, Self::Medium, Self::High, Self::Ultra];

    /// Whether shaders are compiled for the numbers.
    pub(super) fn is_preset(self) -> bool {
        !matches!(self, Self::Custom { .. })
    }

    /// Slices, and steps on each side of one.
    pub fn samples(self) -> (u32, u32) {
        match self {
            Self::Low => (1, 3),
            Self::Medium => (1, 6),
            Self::High => (2, 8),
            Self::Ultra => (4, 12),
            Self::Custom { slices, steps } => (slices.clamp(1, 16), steps.clamp(1, 64)),
        }
    }
}

/// About which normal occlusion is weighted. The surface itself, as depth tells it, never occludes itself with
/// either: flat regions are 0 however their normals are mapped or interpolated.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum OcclusionNormals {
    /// The G-buffer's where lighting applies the occlusion ([`OcclusionApplication::Indirect`]); else the geometric one.
    #[default]
    Shading,
    /// Reconstructed from depth, nine taps (atyuwen 2021, "Accurate Normal Reconstruction from Depth Buffer").
    Geometric,
}

/// How many pixels share an occlusion value.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum OcclusionResolution {
    /// One value a pixel.
    #[default]
    Full,
    /// One for each 2×2; the filter scales up along the edges that depth shows.
    Half,
}

impl OcclusionResolution {
    /// Pixels a side that share a value.
    pub(super) fn divisor(self) -> u32 {
        match self {
            Self::Full => 1,
            Self::Half => 2,
        }
    }
}

/// The weights of the filter that removes the samples' pattern, in which pixels look in different directions. From
/// [half resolution](OcclusionResolution::Half) there is one set of weights for all of them.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum OcclusionFilter {
    /// 1 2 1 / 2 4 2 / 1 2 1: removes any 2×2 pattern exactly.
    Binomial,
    /// √2 2 √2 / 2 2.34 2 / √2 2 √2: flatter.
    Flat,
    /// 1 2 2 2 1 along each axis: removes any 4×4 pattern exactly, so samples are laid out in one, with four times as many
    /// directions. For surfaces so near to the camera that the others show their few directions and steps. Takes longer.
    Wide,
    /// As `Binomial`, without neighbours from across a step in depth.
    #[default]
    BinomialEdgeAware,
    /// As `Flat`, without neighbours from across a step in depth.
    FlatEdgeAware,
    /// As `Wide`, without neighbours from across a step in depth.
    WideEdgeAware,
}

impl OcclusionFilter {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Binomial,
        Self::Flat,
        Self::Wide,
        Self::BinomialEdgeAware,
        Self::FlatEdgeAware,
        Self::WideEdgeAware,
    ];

    pub(super) fn is_flat(self) -> bool {
        matches!(self, Self::Flat | Self::FlatEdgeAware)
    }

    /// Whether 5×5 pixels are brought together.
    pub fn is_wide(self) -> bool {
        matches!(self, Self::Wide | Self::WideEdgeAware)
    }

    /// Whether neighbours from across a step in depth are left out.
    pub fn is_edge_aware(self) -> bool {
        matches!(
            self,
            Self::BinomialEdgeAware | Self::FlatEdgeAware | Self::WideEdgeAware
        )
    }
}

/// How occlusion is stored.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum OcclusionFormat {
    /// R8Unorm: 1 byte a pixel, steps of 1/255 before the filter.
    #[default]
    Unorm8,
    /// R16Float: 2 bytes.
    Float16,
}

impl OcclusionFormat {
    /// The texture's format.
    pub fn texture_format(self) -> TextureFormat {
        match self {
            Self::Unorm8 => TextureFormat::R8Unorm,
            Self::Float16 => TextureFormat::R16Float,
        }
    }
}

/// How occlusion reaches the picture.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum OcclusionApplication {
    /// [`Indirect`](Self::Indirect) on cameras with [`LeanDeferred`](crate::LeanDeferred), because it is the exact one
    /// and costs no pass; [`MultiplicativeBlend`](Self::MultiplicativeBlend) on all others, because Bevy's own shaders
    /// cannot read it.
    #[default]
    Auto,
    /// After the opaque meshes and before transmissive and transparent ones, the picture is multiplied by
    /// `1 - occlusion`: all of its light, direct too. Distance fog in front of a surface is spared. Pixels without
    /// occlusion keep every bit, alpha too.
    MultiplicativeBlend,
    /// The lighting pass darkens ambient light, environment maps, probes and irradiance volumes by it. Meshes that
    /// Bevy's forward passes draw are neither darkened nor do they occlude. Where the camera is not rendered lean, as
    /// [`MultiplicativeBlend`](Self::MultiplicativeBlend).
    Indirect,
}
