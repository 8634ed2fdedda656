//! The kinds of surfaces that there are, and what of the G-buffer they need.

use bevy::prelude::*;
use bitflags::bitflags;

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

/// How a surface reflects light. A pixel has one of these; a material that asks for two at once is drawn forward.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq, Hash)]
#[repr(u8)]
pub enum ShadingModel {
    /// Base colour, metallic, roughness.
    #[default]
    Plain = 0,
    /// Light that enters scatters and leaves elsewhere. Lit as [`Plain`](Self::Plain), then scattered.
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

/// One kind of surface, as lighting tells them apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct LightingVariant {
    shading_model: ShadingModel,
    lightmapped: bool,
}

bitflags! {
    /// A set of kinds, by [`LightingVariant::index`]: lighting is compiled for these, and nothing else. The plain one is always
    /// there, and not in it.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub(crate) struct LightingVariants: u16 {
        const _ = !0;
    }
}

impl LightingVariants {
    /// Whether light scatters beneath one of them.
    pub(crate) fn scatter(self) -> bool {
        self.intersects(LightingVariant::scattering_ones())
    }

    /// What they are where no light scatters beneath surfaces.
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
}

impl LightingVariant {
    /// Those beneath which light scatters.
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
            _ => Self {
                shading_model,
                lightmapped,
            },
        }
    }

    /// The number by which shaders know it; that of the plain one is 0. `variant_of` in `tile_list.wgsl` finds it; it knows
    /// those only that are lit in a way of their own: [`unscattered`](Self::unscattered) ones.
    pub(crate) fn index(self) -> u32 {
        self.shading_model as u32 | (u32::from(self.lightmapped) << 3)
    }

    /// What it is where no light scatters beneath surfaces.
    pub(crate) fn unscattered(self) -> Self {
        match self.shading_model {
            ShadingModel::Subsurface => Self {
                shading_model: ShadingModel::Plain,
                ..self
            },
            _ => self,
        }
    }

    /// The set of just this one.
    pub(crate) fn as_set(self) -> LightingVariants {
        LightingVariants::from_bits_retain((1 << self.index()) & !1)
    }

    /// How light is reflected.
    pub(crate) fn shading_model(self) -> ShadingModel {
        self.shading_model
    }

    /// Whether a lightmap's light is added.
    pub(crate) fn is_lightmapped(self) -> bool {
        self.lightmapped
    }
}
