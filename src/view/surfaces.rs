//! The kinds of surfaces, and the targets of the G-buffer that they need.

use bevy::prelude::*;
use bitflags::bitflags;

use crate::shading_models::MODELS;
pub use crate::shading_models::ShadingModel;

bitflags! {
    /// Optional targets. Each exists while a visible mesh writes it, and for some frames longer, so that meshes which
    /// come and go do not recreate textures; and while other meshes have no pipelines without it.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Reflect)]
    #[reflect(opaque, Default, Clone, PartialEq, Hash)]
    pub struct GBufferTargets: u8 {
        /// Light that a surface emits, or that its lightmap contains. Requested automatically by meshes with a lightmap.
        const EMISSIVE = 1 << 0;
        /// Specular constant, shading model with its arguments, and non-default flags.
        const SPECIALIZATION = 1 << 1;
        /// Motion of a surface since the last frame. Written automatically by meshes that move, are skinned or have
        /// morph targets; a material whose vertex shader animates must request it. Only on views with
        /// `MotionVectorPrepass`.
        const MOTION = 1 << 2;
        /// The [`RenderLayers`](bevy::camera::visibility::RenderLayers) of a mesh. Written automatically by meshes that
        /// are not on layer 0 alone, on views with a light, decal or light probe whose layers exclude some meshes.
        const VISIBILITY_MASK = 1 << 3;
    }
}

bitflags! {
    /// Kinds of surfaces for which lighting is compiled: the special shading models, one bit each, and surfaces of any model
    /// with lightmaps. Plain surfaces are always included and have no bit.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub(crate) struct LightingVariants: u16 {
        /// Surfaces with lightmaps. They are lit where others of their shading model are.
        const LIGHTMAPPED = 1 << 8;
        const _ = !0;
    }
}

impl LightingVariants {
    /// The kind of surfaces with `shading_model`, with or without lightmaps.
    pub(crate) fn of(shading_model: ShadingModel, lightmapped: bool) -> Self {
        match shading_model {
            // Lit as plain surfaces are, and lightmaps do not affect it.
            ShadingModel::Unlit => Self::empty(),
            _ if lightmapped => Self::of_model(shading_model) | Self::LIGHTMAPPED,
            _ => Self::of_model(shading_model),
        }
    }

    /// The bit of a model: 1 shifted by its number in shaders.
    const fn of_model(shading_model: ShadingModel) -> Self {
        Self::from_bits_retain((1 << shading_model as u16) & !1)
    }

    /// True if light scatters beneath surfaces of one of these kinds.
    pub(crate) fn scatter(self) -> bool {
        self.have(ShadingModel::Subsurface)
    }

    /// Replaces scattering kinds by those without scattering, for views that do not scatter light.
    pub(crate) fn unscattered(self) -> Self {
        self - Self::of_model(ShadingModel::Subsurface)
    }

    /// The special kinds, which the dispatch over listed tiles lights: models that lighting has code for. Surfaces with
    /// scattering are lit as plain ones.
    pub(crate) fn special(self) -> Self {
        self.unscattered() - Self::LIGHTMAPPED
    }

    /// All special kinds.
    pub(crate) fn all_special() -> Self {
        let models = MODELS.iter().map(|model| Self::of(model.model, false));
        models.collect::<Self>().special()
    }

    /// True if surfaces of one of these kinds have `shading_model`.
    pub(crate) fn have(self, shading_model: ShadingModel) -> bool {
        self.intersects(Self::of_model(shading_model))
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::Vec3;
    use kit::{
        compute::Compute,
        reference::{shader_library::layout::specialization as special, shading_models::unlit},
        shipped_wgsl,
    };

    use super::{LightingVariants, ShadingModel};
    use crate::shading_models::MODELS;

    const KERNEL: &str = "
#import bevy_lean_deferred::lighting::tile_list::variant_of
fn kernel(word: array<u32, 1>) -> array<u32, 1> {
    return array(variant_of(word[0]));
}";

    #[test]
    fn lightmaps_alone_need_no_dispatch_of_their_own() {
        for model in MODELS.map(|model| model.model) {
            let [without, with] = [false, true].map(|has| LightingVariants::of(model, has));
            let is_lit = model != ShadingModel::Unlit;
            assert_eq!(
                with.contains(LightingVariants::LIGHTMAPPED),
                is_lit,
                "{model:?}"
            );
            assert_eq!(with.special(), without.special(), "{model:?}");
        }
        let lightmapped = LightingVariants::of(ShadingModel::Plain, true);
        assert!(!lightmapped.is_empty() && lightmapped.special().is_empty());
    }

    /// Four models with code of their own.
    #[test]
    fn special_kinds_are_models_that_lighting_has_code_for() {
        let all = LightingVariants::all_special();
        for model in MODELS {
            let has_code = model.shader_def.is_some();
            assert_eq!(all.have(model.model), has_code, "{:?}", model.model);
        }
        assert_eq!(all.bits().count_ones(), 4);
    }

    #[test]
    fn shaders_know_variants_by_the_same_numbers() {
        let mut pixels = Vec::new();
        for shading_model in MODELS.map(|model| model.model) {
            let variant = LightingVariants::of(shading_model, false).special();
            for flags in [0, special::NO_FOG, special::NO_SHADOWS] {
                let word = special::pack_specialization(0.7, shading_model as u32, flags);
                pixels.push((word, variant));
                pixels.push((special::with_arguments(word, 0x1_ffff), variant));
            }
        }
        for brightness in [0.0, 0.3, 1.0, 70.0, 3e4] {
            let color = brightness * Vec3::new(1.0, 0.5, 0.9);
            let word = unlit::pack_unlit(color, special::NO_FOG);
            pixels.push((word, LightingVariants::empty()));
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
            let bits = (1u16 << device) & !1;
            assert_eq!(bits, variant.bits(), "{word:08x}: {device}, {variant:?}");
        }
    }
}
