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
        /// Light that a surface emits, or that its lightmap contains.
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

/// A kind of surface that lighting treats on its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct LightingVariant {
    shading_model: ShadingModel,
    lightmapped: bool,
}

bitflags! {
    /// A set of kinds, by [`LightingVariant::index`], for which lighting is compiled. The plain kind is always included
    /// and has no bit.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub(crate) struct LightingVariants: u16 {
        const _ = !0;
    }
}

impl LightingVariants {
    /// True if light scatters beneath surfaces of one of these kinds.
    pub(crate) fn scatter(self) -> bool {
        self.intersects(LightingVariant::scattering_ones())
    }

    /// Replaces scattering kinds by those without scattering, for views that do not scatter light.
    pub(crate) fn unscattered(self) -> Self {
        let plain = LightingVariant::SCATTERING
            .into_iter()
            .filter(|variant| self.intersects(variant.as_set()))
            .map(|variant| variant.unscattered().as_set());
        plain.fold(
            self.difference(LightingVariant::scattering_ones()),
            Self::union,
        )
    }

    /// All kinds that lighting distinguishes.
    pub(crate) fn of_lighting() -> Self {
        let kinds = MODELS.iter().flat_map(|model| {
            [false, true].map(|lightmapped| LightingVariant::new(model.model, lightmapped))
        });
        kinds.map(|kind| kind.unscattered().as_set()).collect()
    }

    /// The largest set for which lighting is compiled by the same definitions: one per model, and one for lightmaps.
    pub(crate) fn by_definitions(self) -> Self {
        let lightmapped = self.have_lightmaps().then_some(true);
        let kinds = MODELS.iter().map(|model| model.model).flat_map(|model| {
            let has_model = self.have(model) || model == ShadingModel::Plain;
            let forms = core::iter::once(false).chain(lightmapped);
            forms
                .filter(move |_| has_model)
                .map(move |lightmapped| LightingVariant::new(model, lightmapped).as_set())
        });
        kinds.collect()
    }

    /// True if surfaces of one of these kinds have `shading_model`.
    pub(crate) fn have(self, shading_model: ShadingModel) -> bool {
        let kinds =
            [false, true].map(|lightmapped| LightingVariant::new(shading_model, lightmapped));
        kinds.into_iter().any(|kind| self.intersects(kind.as_set()))
    }

    /// Those of these kinds whose surfaces have no lightmap.
    pub(crate) fn without_lightmaps(self) -> Self {
        Self::from_bits_retain(self.bits() & ((1 << LightingVariant::LIGHTMAPPED) - 1))
    }

    /// True if surfaces of one of these kinds have lightmaps.
    pub(crate) fn have_lightmaps(self) -> bool {
        self.bits() >> LightingVariant::LIGHTMAPPED != 0
    }
}

impl LightingVariant {
    /// The kinds with scattering.
    const SCATTERING: [Self; 2] = [
        Self {
            shading_model: ShadingModel::Subsurface,
            lightmapped: false,
        },
        Self {
            shading_model: ShadingModel::Subsurface,
            lightmapped: true,
        },
    ];

    fn scattering_ones() -> LightingVariants {
        Self::SCATTERING.map(Self::as_set).into_iter().collect()
    }

    /// Bit of [`index`](Self::index): the surface has a lightmap. The bits below it hold the shading model.
    const LIGHTMAPPED: u32 = 1 << 3;

    /// Plain surfaces.
    pub(crate) const PLAIN: Self = Self {
        shading_model: ShadingModel::Plain,
        lightmapped: false,
    };

    /// The kind of surfaces with `shading_model`.
    pub(crate) fn new(shading_model: ShadingModel, lightmapped: bool) -> Self {
        match shading_model {
            // Lightmaps do not affect it.
            ShadingModel::Unlit => Self::PLAIN,
            _ => Self {
                shading_model,
                lightmapped,
            },
        }
    }

    /// Its number in shaders; 0 for the plain kind. `variant_of` in `tile_list.wgsl` computes it, but only for
    /// [`unscattered`](Self::unscattered) kinds, which are those that lighting treats differently.
    pub(crate) fn index(self) -> u32 {
        self.shading_model as u32 | (u32::from(self.lightmapped) * Self::LIGHTMAPPED)
    }

    /// The same kind without scattering.
    pub(crate) fn unscattered(self) -> Self {
        match self.shading_model {
            ShadingModel::Subsurface => Self {
                shading_model: ShadingModel::Plain,
                ..self
            },
            _ => self,
        }
    }

    /// The set of this kind alone.
    pub(crate) fn as_set(self) -> LightingVariants {
        LightingVariants::from_bits_retain((1 << self.index()) & !1)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use bevy::math::Vec3;
    use kit::{
        compute::Compute,
        reference::{shader_library::layout::specialization as special, shading_models::unlit},
        shipped_wgsl,
    };

    use super::{LightingVariant, LightingVariants};
    use crate::shading_models::MODELS;

    const KERNEL: &str = "
#import bevy_lean_deferred::lighting::tile_list::variant_of
fn kernel(word: array<u32, 1>) -> array<u32, 1> {
    return array(variant_of(word[0]));
}";

    /// Four models and lightmaps: 31 sets, and the empty one.
    #[test]
    fn sets_with_the_same_definitions_are_one() {
        let kinds: Vec<LightingVariants> = MODELS
            .iter()
            .flat_map(|model| {
                [false, true].map(|lightmapped| LightingVariant::new(model.model, lightmapped))
            })
            .map(|kind| kind.unscattered().as_set())
            .filter(|kind| !kind.is_empty())
            .collect();
        let sets: HashSet<LightingVariants> = (0..1u32 << kinds.len())
            .map(|set| {
                let chosen = kinds
                    .iter()
                    .enumerate()
                    .filter(|(i, _)| (set >> i) & 1 != 0);
                let chosen: LightingVariants = chosen.map(|(_, kind)| *kind).collect();
                let widened = chosen.by_definitions();
                assert!(widened.contains(chosen));
                assert_eq!(widened.is_empty(), chosen.is_empty());
                widened
            })
            .collect();
        assert_eq!(sets.len(), 32);
    }

    #[test]
    fn shaders_know_variants_by_the_same_numbers() {
        let mut pixels = Vec::new();
        for shading_model in MODELS.map(|model| model.model) {
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
