//! The ways in which lighting is compiled for the surfaces of one view.

use bevy::shader::ShaderDefVal;

use crate::view::{LightingVariant, LightingVariants, ShadingModel};

impl LightingVariant {
    /// The definitions that compile lighting for it, in a view with those `listed`.
    pub(super) fn shader_defs(self, listed: LightingVariants) -> Vec<ShaderDefVal> {
        let mut defs: Vec<ShaderDefVal> = match self.shading_model() {
            ShadingModel::Anisotropy => vec!["STANDARD_MATERIAL_ANISOTROPY".into()],
            ShadingModel::Clearcoat => vec!["STANDARD_MATERIAL_CLEARCOAT".into()],
            ShadingModel::Rim => vec!["SHADING_MODEL_RIM".into()],
            ShadingModel::Backlight => vec![
                "STANDARD_MATERIAL_DIFFUSE_TRANSMISSION".into(),
                "STANDARD_MATERIAL_DIFFUSE_OR_SPECULAR_TRANSMISSION".into(),
            ],
            _ => Vec::new(),
        };
        if self.is_lightmapped() {
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

#[cfg(test)]
mod tests {
    use bevy::{math::Vec3, shader::ShaderDefVal};
    use kit::compute::{Compute, WgslModule};

    use super::{LightingVariant, LightingVariants};
    use crate::{
        shader_library::layout::specialization as special, shading_models::unlit,
        view::ShadingModel,
    };

    const MODELS: [ShadingModel; 7] = [
        ShadingModel::Plain,
        ShadingModel::Subsurface,
        ShadingModel::Anisotropy,
        ShadingModel::Rim,
        ShadingModel::Clearcoat,
        ShadingModel::Backlight,
        ShadingModel::Unlit,
    ];

    const KERNEL: &str = "
#import bevy_lean_deferred::lighting::tile_lists::variant_of
fn kernel(word: array<u32, 1>) -> array<u32, 1> {
    return array(variant_of(word[0]));
}";

    #[test]
    fn shaders_know_variants_by_the_same_numbers() {
        let mut pixels = Vec::new();
        for shading_model in MODELS {
            for lightmap in [
                special::LIGHTMAP_NONE,
                special::LIGHTMAP_INCIDENT,
                special::LIGHTMAP_REFLECTED,
            ] {
                for flags in [0, special::NO_FOG, special::NO_SHADOWS] {
                    let word =
                        special::pack_specialization(0.7, shading_model as u32, lightmap | flags);
                    let is_lightmapped = lightmap != special::LIGHTMAP_NONE;
                    let variant = LightingVariant::new(shading_model, is_lightmapped);
                    pixels.push((word, variant));
                    pixels.push((special::with_arguments(word, 0x1_ffff), variant));
                }
            }
        }
        for brightness in [0.0, 0.3, 1.0, 70.0, 3e4] {
            let color = brightness * Vec3::new(1.0, 0.5, 0.9);
            let word = unlit::pack_unlit(color, special::NO_FOG);
            pixels.push((word, LightingVariant::PLAIN));
        }

        let compute = Compute::new();
        let modules = [
            WgslModule {
                path: "layout.wgsl",
                source: include_str!("../shader_library/layout.wgsl"),
            },
            WgslModule {
                path: "specialization.wgsl",
                source: include_str!("../shader_library/layout/specialization.wgsl"),
            },
            WgslModule {
                path: "view.wgsl",
                source: include_str!("../ambient_occlusion/view.wgsl"),
            },
            WgslModule {
                path: "bindings.wgsl",
                source: include_str!("bindings.wgsl"),
            },
            WgslModule {
                path: "tile_lists.wgsl",
                source: include_str!("tile_lists.wgsl"),
            },
        ];
        let kernel = compute.kernel::<1, 1>(&modules, KERNEL);
        let words: Vec<_> = pixels.iter().map(|(word, _)| [*word]).collect();
        for ((word, variant), [device]) in pixels.into_iter().zip(kernel.run(&words)) {
            assert_eq!(device, variant.index(), "{word:08x}, {variant:?}");
        }
    }

    #[test]
    fn lists_follow_in_the_order_of_the_numbers() {
        for bits in 0..=u16::MAX {
            let listed = LightingVariants::from_bits_retain(bits);
            // Of those that there are.
            let listed = listed
                .each()
                .fold(LightingVariants::empty(), |set, variant| {
                    set | variant.as_set()
                });
            for (place, variant) in listed.each().enumerate() {
                let rank = ShaderDefVal::UInt("LIST_RANK".into(), place as u32);
                assert!(variant.shader_defs(listed).contains(&rank), "{variant:?}");
            }
        }
    }
}
