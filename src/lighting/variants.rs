//! The shader definitions of lighting for the special surfaces of a view.

use bevy::shader::ShaderDefVal;

use crate::view::{LightingVariant, LightingVariants, ShadingModel};

/// Returns the definitions for the dispatch that lights the tiles with special surfaces of the kinds `shaded`. If that
/// is empty, returns those for the dispatch over all tiles, which lists tiles with kinds in `binned`.
pub(super) fn shader_defs(binned: LightingVariants, shaded: LightingVariants) -> Vec<ShaderDefVal> {
    if shaded.is_empty() {
        return match binned.is_empty() {
            true => Vec::new(),
            false => vec!["LISTED_VARIANTS".into()],
        };
    }
    let has = |model| {
        shaded
            .each()
            .any(|variant| variant.shading_model() == model)
    };
    let mut defs: Vec<ShaderDefVal> = vec!["VISITED_VARIANTS".into()];
    let mut define = |condition: bool, name: &'static str| {
        if condition {
            defs.push(name.into());
        }
    };
    define(
        has(ShadingModel::Anisotropy),
        "STANDARD_MATERIAL_ANISOTROPY",
    );
    define(has(ShadingModel::Clearcoat), "STANDARD_MATERIAL_CLEARCOAT");
    define(has(ShadingModel::Rim), "SHADING_MODEL_RIM");
    define(
        has(ShadingModel::DiffuseTransmission),
        "STANDARD_MATERIAL_DIFFUSE_TRANSMISSION",
    );
    define(
        shaded.each().any(|variant| variant.is_lightmapped()),
        // Not `LIGHTMAP`: with it, Bevy's functions assume that all surfaces have one.
        "LIGHTMAPPED_SURFACES",
    );
    defs
}

impl LightingVariants {
    /// Each variant in the set, in the order of their numbers.
    fn each(self) -> impl Iterator<Item = LightingVariant> {
        use ShadingModel::{Anisotropy, Clearcoat, DiffuseTransmission, Plain, Rim};
        [false, true].into_iter().flat_map(move |lightmapped| {
            [Plain, Anisotropy, Rim, Clearcoat, DiffuseTransmission]
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
    use bevy::math::Vec3;
    use kit::{compute::Compute, shipped_wgsl};

    use super::LightingVariant;
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
        ShadingModel::DiffuseTransmission,
        ShadingModel::Unlit,
    ];

    const KERNEL: &str = "
#import bevy_lean_deferred::lighting::tile_list::variant_of
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
                    let variant = LightingVariant::new(shading_model, is_lightmapped).unscattered();
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
            shipped_wgsl!("shader_library/layout.wgsl"),
            shipped_wgsl!("shader_library/layout/specialization.wgsl"),
            shipped_wgsl!("lighting/bindings.wgsl"),
            shipped_wgsl!("lighting/tile_list.wgsl"),
        ];
        let kernel = compute.kernel::<1, 1>(&modules, KERNEL);
        let words: Vec<_> = pixels.iter().map(|(word, _)| [*word]).collect();
        for ((word, variant), [device]) in pixels.into_iter().zip(kernel.run(&words)) {
            assert_eq!(device, variant.index(), "{word:08x}, {variant:?}");
        }
    }
}
