//! The ways in which lighting is compiled for the surfaces of one view.

use bevy::shader::ShaderDefVal;
use bitflags::bitflags;

use crate::gbuffer::ShadingModel;

/// How one kind of surface is lit: all that this kind needs, and nothing else, is compiled in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct LightingVariant {
    shading_model: ShadingModel,
    lightmapped: bool,
}

bitflags! {
    /// A set of ways, by [`LightingVariant::index`]. The plain one is always there, and not in it.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub(crate) struct LightingVariants: u16 {
        const _ = !0;
    }
}

impl LightingVariant {
    /// Plain surfaces.
    pub(crate) const PLAIN: Self = Self {
        shading_model: ShadingModel::Plain,
        lightmapped: false,
    };

    /// How surfaces with `shading_model` are lit.
    pub(crate) fn new(shading_model: ShadingModel, lightmapped: bool) -> Self {
        match shading_model {
            // No light reaches it.
            ShadingModel::Unlit => Self::PLAIN,
            ShadingModel::Subsurface => Self {
                shading_model: ShadingModel::Plain,
                lightmapped,
            },
            _ => Self {
                shading_model,
                lightmapped,
            },
        }
    }

    /// The number by which shaders know it; that of the plain one is 0. Twin of `variant_of` in `tile_lists.wgsl`.
    pub(super) fn index(self) -> u32 {
        self.shading_model as u32 | (u32::from(self.lightmapped) << 3)
    }

    /// The set of just this one.
    pub(crate) fn as_set(self) -> LightingVariants {
        LightingVariants::from_bits_retain((1 << self.index()) & !1)
    }

    /// The definitions that compile lighting for it, in a view with those `listed`.
    pub(super) fn shader_defs(self, listed: LightingVariants) -> Vec<ShaderDefVal> {
        let mut defs: Vec<ShaderDefVal> = match self.shading_model {
            ShadingModel::Anisotropy => vec!["STANDARD_MATERIAL_ANISOTROPY".into()],
            ShadingModel::Clearcoat => vec!["STANDARD_MATERIAL_CLEARCOAT".into()],
            ShadingModel::Rim => vec!["SHADING_MODEL_RIM".into()],
            ShadingModel::Backlight => vec![
                "STANDARD_MATERIAL_DIFFUSE_TRANSMISSION".into(),
                "STANDARD_MATERIAL_DIFFUSE_OR_SPECULAR_TRANSMISSION".into(),
            ],
            _ => Vec::new(),
        };
        if self.lightmapped {
            defs.push("LIGHTMAP".into());
        }
        if self != Self::PLAIN {
            let smaller = LightingVariants::from_bits_retain((1 << self.index()) - 1);
            let rank = (listed & smaller).count();
            defs.push(ShaderDefVal::UInt("LIGHTING_VARIANT".into(), self.index()));
            defs.push(ShaderDefVal::UInt("LIST_RANK".into(), rank));
        } else if !listed.is_empty() {
            let bits = u32::from(listed.bits());
            defs.push(ShaderDefVal::UInt("LISTED_VARIANTS".into(), bits));
        }
        defs
    }
}

impl LightingVariants {
    /// The number of variants.
    pub(super) fn count(self) -> u32 {
        self.bits().count_ones()
    }

    /// Each variant in the set, in the order of their numbers.
    pub(super) fn each(self) -> impl Iterator<Item = LightingVariant> {
        use ShadingModel::{Anisotropy, Backlight, Clearcoat, Plain, Rim};
        [false, true].into_iter().flat_map(move |lightmapped| {
            [Plain, Anisotropy, Rim, Clearcoat, Backlight]
                .map(|model| LightingVariant::new(model, lightmapped))
                .into_iter()
                .filter(move |variant| {
                    *variant != LightingVariant::PLAIN && self.contains(variant.as_set())
                })
        })
    }
}
