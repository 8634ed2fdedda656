//! The optional targets of the G-buffer, and what a material needs of it.

use bevy::{
    prelude::*,
    render::render_resource::{ColorTargetState, ColorWrites, TextureFormat},
};
use bitflags::bitflags;

use super::layout::{
    EMISSIVE_FORMAT, MOTION_FORMAT, NORMAL_FORMAT, SPECIALIZATION_FORMAT, SURFACE_FORMAT,
    VISIBILITY_MASK_FORMAT, WRITTEN_FORMAT,
};

bitflags! {
    /// Targets beside the base ones. Each exists only while a visible mesh writes it (and a little longer, so that what
    /// comes and goes does not make textures and pipelines anew).
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Reflect)]
    #[reflect(opaque, Default, Clone, PartialEq, Hash)]
    pub struct GBufferTargets: u8 {
        /// Light that a surface emits, or that a lightmap holds for it.
        const EMISSIVE = 1 << 0;
        /// Specular constant, shading model with its arguments, and flags that are not at their defaults.
        const SPECIALIZATION = 1 << 1;
        /// Where a surface was in the last frame. Meshes that move, are skinned or have morph targets write it without
        /// being told; a material whose vertex shader animates names it. Only on views with `MotionVectorPrepass`.
        const MOTION = 1 << 2;
        /// Which [`RenderLayers`](bevy::camera::visibility::RenderLayers) a mesh is on. Meshes on other layers than
        /// layer 0 alone write it without being told, on views with a light, decal or light probe that its own layers
        /// keep from some meshes.
        const VISIBILITY_MASK = 1 << 3;
    }
}

impl GBufferTargets {
    /// Those that lighting reads.
    pub(crate) const LIT: Self = Self::all().difference(Self::MOTION);

    /// The colour targets of a pipeline that writes `written` of these, in a pass that has all of these: two of the
    /// base, and in a pass with optional targets the one that says which are written, and one for each up to the last, in
    /// the order of the fragment shader's outputs.
    pub(crate) fn color_targets(self, written: Self) -> Vec<Option<ColorTargetState>> {
        let target = |format, write_mask| {
            Some(ColorTargetState {
                format,
                blend: None,
                write_mask,
            })
        };
        let optional = Self::all()
            .iter()
            .take_while(|target| target.bits() <= self.bits())
            .map(
                |other| match (self.contains(other), written.contains(other)) {
                    (false, _) => None,
                    (true, false) => target(other.format(), ColorWrites::empty()),
                    (true, true) => target(other.format(), ColorWrites::ALL),
                },
            );
        [SURFACE_FORMAT, NORMAL_FORMAT]
            .into_iter()
            .chain((!self.is_empty()).then_some(WRITTEN_FORMAT))
            .map(|format| target(format, ColorWrites::ALL))
            .chain(optional)
            .collect()
    }

    /// The attachment of a single target.
    pub(crate) const fn slot(self) -> usize {
        3 + self.bits().trailing_zeros() as usize
    }

    /// The format of a single target.
    pub(crate) fn format(self) -> TextureFormat {
        match self {
            Self::EMISSIVE => EMISSIVE_FORMAT,
            Self::MOTION => MOTION_FORMAT,
            Self::VISIBILITY_MASK => VISIBILITY_MASK_FORMAT,
            _ => SPECIALIZATION_FORMAT,
        }
    }

    /// The name of a single target.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::EMISSIVE => "emissive",
            Self::MOTION => "motion",
            Self::VISIBILITY_MASK => "visibility mask",
            _ => "specialization",
        }
    }

    /// The name of a single target, in labels of the graphics API.
    pub(crate) fn label(self) -> &'static str {
        match self {
            Self::EMISSIVE => "lean_deferred/gbuffer/emissive",
            Self::MOTION => "lean_deferred/gbuffer/motion",
            Self::VISIBILITY_MASK => "lean_deferred/gbuffer/visibility_mask",
            _ => "lean_deferred/gbuffer/specialization",
        }
    }

    /// The shader definition that makes shaders write or read a single target.
    pub(crate) fn shader_def(self) -> &'static str {
        match self {
            Self::EMISSIVE => "GBUFFER_EMISSIVE",
            Self::MOTION => "GBUFFER_MOTION",
            Self::VISIBILITY_MASK => "GBUFFER_VISIBILITY_MASK",
            _ => "GBUFFER_SPECIALIZATION",
        }
    }

    /// Bytes a pixel of these targets, and of the one that says which of them a surface has written; the base targets
    /// not counted.
    pub fn bytes_per_pixel(self) -> u32 {
        let written = (!self.is_empty()).then_some(WRITTEN_FORMAT);
        (self.iter().map(Self::format))
            .chain(written)
            .filter_map(|format| format.block_copy_size(None))
            .sum()
    }
}

/// How a surface reflects light. A pixel has one of these; a material that asks for two at once is drawn forward.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq, Hash)]
#[repr(u8)]
pub enum ShadingModel {
    /// Base colour, metallic, roughness.
    #[default]
    Plain = 0,
    /// Light that enters scatters and leaves elsewhere. Stored; lit as [`Plain`](Self::Plain).
    Subsurface = 1,
    /// Highlights stretched along a tangent.
    Anisotropy = 2,
    /// Light caught along the silhouette.
    Rim = 3,
    /// A second, clear layer.
    Clearcoat = 4,
    /// Light that falls on the back shines through.
    Backlight = 5,
    /// The base colour, whatever the light.
    Unlit = 6,
}

/// What a material needs of the G-buffer beside the base targets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct GBufferNeeds {
    /// The optional targets that it writes.
    pub targets: GBufferTargets,
    /// How its pixels are lit.
    pub shading_model: ShadingModel,
}

impl GBufferNeeds {
    /// Only the base targets.
    pub const BASE: Self = Self {
        targets: GBufferTargets::empty(),
        shading_model: ShadingModel::Plain,
    };

    /// The same with another shading model, which the specialization target names.
    pub fn with_shading_model(self, shading_model: ShadingModel) -> Self {
        Self {
            targets: self.targets | GBufferTargets::SPECIALIZATION,
            shading_model,
        }
    }
}
