//! The optional targets of the G-buffer, and the needs of a material.

use bevy::render::render_resource::{ColorTargetState, ColorWrites, TextureFormat};

use crate::shader_library::layout::{
    EMISSIVE_FORMAT, MOTION_FORMAT, NORMAL_FORMAT, SPECIALIZATION_FORMAT, SURFACE_FORMAT,
    VALID_MASK_FORMAT, VISIBILITY_MASK_FORMAT,
};
use crate::view::{GBufferTargets, ShadingModel};

/// Properties of one target.
struct OptionalTarget {
    format: TextureFormat,
    name: &'static str,
    label: &'static str,
    shader_def: &'static str,
}

/// The optional targets in the order of their bits, which is that of the fragment shader's outputs.
const OPTIONAL_TARGETS: [OptionalTarget; GBufferTargets::all().bits().count_ones() as usize] = [
    OptionalTarget {
        format: EMISSIVE_FORMAT,
        name: "emissive",
        label: "lean_deferred/gbuffer/emissive",
        shader_def: "GBUFFER_EMISSIVE",
    },
    OptionalTarget {
        format: SPECIALIZATION_FORMAT,
        name: "specialization",
        label: "lean_deferred/gbuffer/specialization",
        shader_def: "GBUFFER_SPECIALIZATION",
    },
    OptionalTarget {
        format: MOTION_FORMAT,
        name: "motion",
        label: "lean_deferred/gbuffer/motion",
        shader_def: "GBUFFER_MOTION",
    },
    OptionalTarget {
        format: VISIBILITY_MASK_FORMAT,
        name: "visibility mask",
        label: "lean_deferred/gbuffer/visibility_mask",
        shader_def: "GBUFFER_VISIBILITY_MASK",
    },
];

impl GBufferTargets {
    /// The targets that lighting reads.
    pub(crate) const LIT: Self = Self::all().difference(Self::MOTION);

    /// Colour targets of a pipeline that writes `written` in a pass with the targets `self`, in the order of the
    /// fragment shader's outputs: the two of the base, the `valid_mask` target if the pass has it, and a slot for each
    /// optional target up to the last.
    pub(crate) fn color_targets(
        self,
        has_valid_mask: bool,
        written: Self,
    ) -> Vec<Option<ColorTargetState>> {
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
            .chain(has_valid_mask.then_some(VALID_MASK_FORMAT))
            .map(|format| target(format, ColorWrites::ALL))
            .chain(optional)
            .collect()
    }

    /// Attachment index of a single target.
    pub(crate) const fn slot(self) -> usize {
        3 + self.bits().trailing_zeros() as usize
    }

    fn described(self) -> &'static OptionalTarget {
        &OPTIONAL_TARGETS[self.bits().trailing_zeros() as usize]
    }

    /// The format of a single target.
    pub(crate) fn format(self) -> TextureFormat {
        self.described().format
    }

    /// The name of a single target.
    pub(crate) fn name(self) -> &'static str {
        self.described().name
    }

    /// The label of a single target in the graphics API.
    pub(crate) fn label(self) -> &'static str {
        self.described().label
    }

    /// The shader definition with which shaders write or read a single target.
    pub(crate) fn shader_def(self) -> &'static str {
        self.described().shader_def
    }

    /// Bytes per pixel of these targets and of the one that records which of them a surface has written, without the
    /// base targets.
    pub fn bytes_per_pixel(self) -> u32 {
        let written = (!self.is_empty()).then_some(VALID_MASK_FORMAT);
        (self.iter().map(Self::format))
            .chain(written)
            .filter_map(|format| format.block_copy_size(None))
            .sum()
    }
}

/// The needs of a material beyond the base targets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct GBufferNeeds {
    /// The optional targets that it writes.
    pub targets: GBufferTargets,
    /// The shading model of its pixels.
    pub shading_model: ShadingModel,
}

impl GBufferNeeds {
    /// Only the base targets.
    pub const BASE: Self = Self {
        targets: GBufferTargets::empty(),
        shading_model: ShadingModel::Plain,
    };

    /// The same with another shading model, which is stored in the specialization target.
    pub fn with_shading_model(self, shading_model: ShadingModel) -> Self {
        Self {
            targets: self.targets | GBufferTargets::SPECIALIZATION,
            shading_model,
        }
    }
}
