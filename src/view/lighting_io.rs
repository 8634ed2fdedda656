//! Lighting inputs and outputs: light that effects take from lighting, and give to it.
//!
//! An effect inserts these components on its views in the render world before
//! [`LeanViewSystems`](super::LeanViewSystems), and removes them when it is done.
//! [`ActiveLeanView`](super::ActiveLeanView) has those of this frame: while lighting compiles for others,
//! and no general pipeline lights the view with them, it keeps the former ones.

use bevy::{
    prelude::*,
    render::{render_resource::TextureView, texture::CachedTexture},
};
use bitflags::bitflags;

use crate::gpu::growing_size::GrowingSize;

bitflags! {
    /// Inputs and outputs of lighting that effects provide or read.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub struct LightingIo: u16 {
        /// Lighting writes the [`DiffuseLight`].
        const DIFFUSE_LIGHT = 1 << 0;
        /// Lighting adds the [`IndirectSpecular`].
        const INDIRECT_SPECULAR = 1 << 1;
        /// Lighting adds the [`IndirectDiffuse`].
        const INDIRECT_DIFFUSE = 1 << 2;
        /// Lighting writes the light that scatters beneath surfaces: [`ScattersLight`].
        const SUBSURFACE_LIGHT = 1 << 3;
        /// Lighting darkens indirect light by the [`AmbientOcclusion`]. The bits below say how.
        const AMBIENT_OCCLUSION = 1 << 4;
        /// The filter is 5×5 texels wide, not 3×3.
        const OCCLUSION_WIDE = 1 << 5;
        /// The filter ignores neighbours across a depth step.
        const OCCLUSION_EDGE_AWARE = 1 << 6;
        /// The texture has half the size of the viewport per axis.
        const OCCLUSION_HALF = 1 << 7;
        /// Some of the occluded light returns from bright surfaces.
        const OCCLUSION_MULTIBOUNCE = 1 << 8;
        /// Occlusion darkens direct light too.
        const OCCLUSION_OF_DIRECT_LIGHT = 1 << 9;
        /// The bits that the filter is compiled by.
        const OCCLUSION_FILTER = Self::OCCLUSION_WIDE.bits()
            | Self::OCCLUSION_EDGE_AWARE.bits()
            | Self::OCCLUSION_HALF.bits();
        /// All kinds of indirect light that lighting adds.
        const INDIRECT = Self::INDIRECT_SPECULAR.bits() | Self::INDIRECT_DIFFUSE.bits();
    }
}

/// On a view: an effect reads its [`DiffuseLight`].
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct ReadsDiffuseLight;

/// On a view: an effect scatters the light that enters its surfaces, which lighting writes separately.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct ScattersLight;

/// On a view with [`ReadsDiffuseLight`], for as long as it is lean: the part of the picture that surfaces emit,
/// transmit or reflect diffusely. The picture contains it too.
///
/// `R32Uint`, at least as large as the viewport, whose light begins in its corner; larger while the size of the viewport
/// changes. Each word has a shared exponent (`layout/light.wgsl`: error at most 1/511 of the brightest channel).
/// Exposed, before fog; 0 at pixels without a lean mesh.
#[derive(Component, Clone)]
pub struct DiffuseLight {
    /// Lighting writes this frame's light to it.
    pub texture: CachedTexture,
    /// Has the light of the last frame until lighting writes to `texture`, which most often is the same one. Zeros if no
    /// frame came before.
    pub last: CachedTexture,
    pub(crate) size: GrowingSize,
}

/// An effect provides the reflections on surfaces of this view. Lighting blends them with environment maps, reflection
/// probes and ambient light, with the same Fresnel and roughness terms.
///
/// The texture has a float format and is at least as large as the viewport, whose light begins in its corner. RGB:
/// radiance around the mirrored direction, for the roughness of the surface (of its coat, if it has one), with the
/// exposure of this frame. Alpha: confidence, 0 to 1, with which it replaces the other sources. Its visibility was
/// tested, so ambient occlusion does not darken it. Without a texture there are no reflections.
#[derive(Component, Clone, Debug, Default)]
pub struct IndirectSpecular(pub Option<TextureView>);

/// An effect provides light that surfaces of this view receive from others. Lighting adds it to irradiance volumes,
/// environment maps and ambient light, except on lightmapped surfaces, whose lightmap contains it.
///
/// RGB: irradiance over π (the mean radiance), with the exposure of this frame. Alpha: occluded fraction of the light from
/// elsewhere, 0 to 1, which replaces ambient occlusion. Without a texture there is neither light nor occlusion.
#[derive(Component, Clone, Debug, Default)]
pub struct IndirectDiffuse {
    /// Has a float format, and is at least as large as the viewport, whose light begins in its corner.
    pub texture: Option<TextureView>,
    /// True if a texel represents 2×2 pixels, and the texture has half of that size per axis, rounded up: lighting upsamples it along
    /// the edges in depth. A texel shows the first of its pixels. Where it shows another, its alpha is -(n + fraction): n, 1 to 3, is
    /// x + 2 y of that pixel, and the fraction is below 1.
    pub is_half: bool,
}

/// On a view: an effect occludes ambient light, and lighting is asked to apply that. Has the bits of [`LightingIo`] that
/// say how, [`AMBIENT_OCCLUSION`](LightingIo::AMBIENT_OCCLUSION) among them.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct OccludesLight(pub LightingIo);

/// On a view with [`OccludesLight`], for as long as the effect computes occlusion for lighting: the occlusion of ambient
/// light, and the parameters of its filter, `occlusion_filter.wgsl`.
///
/// The texture has a float format. R: occluded fraction, 0 to 1. It is as large as the viewport, or with
/// [`OCCLUSION_HALF`](LightingIo::OCCLUSION_HALF) half as large per axis, rounded up. Without the component nothing is
/// occluded.
#[derive(Component, Clone, Debug)]
pub struct AmbientOcclusion {
    /// Occluded fractions.
    pub texture: TextureView,
    /// As in the filter.
    pub edge: Vec3,
    /// Factor on the occlusion.
    pub intensity: f32,
    /// Share of the occlusion that darkens direct light too, 0 to 1.
    pub of_direct_light: f32,
    /// Share of the occlusion that darkens the light of lightmaps too, 0 to 1.
    pub of_baked_light: f32,
}

/// Inputs and outputs that effects request on a view. A tuple, because the bounds of a derived query make the compiler walk all
/// types of `wgpu`.
pub(crate) type LightingIoQuery = (
    Has<ReadsDiffuseLight>,
    Has<ScattersLight>,
    Has<IndirectSpecular>,
    Has<IndirectDiffuse>,
    Option<&'static OccludesLight>,
);

impl LightingIo {
    /// Converts the result of a [`LightingIoQuery`].
    pub(crate) fn asked(
        (diffuse_light, scatters, specular, diffuse, occludes): (
            bool,
            bool,
            bool,
            bool,
            Option<&OccludesLight>,
        ),
    ) -> Self {
        let light: Self = [
            (diffuse_light, Self::DIFFUSE_LIGHT),
            (scatters, Self::SUBSURFACE_LIGHT),
            (specular, Self::INDIRECT_SPECULAR),
            (diffuse, Self::INDIRECT_DIFFUSE),
        ]
        .into_iter()
        .filter_map(|(is_asked, what)| is_asked.then_some(what))
        .collect();
        match occludes {
            Some(OccludesLight(occlusion)) if !light.replaces_occlusion() => light | *occlusion,
            _ => light,
        }
    }

    /// True if ambient occlusion is off beside this light: [`IndirectDiffuse`] has an occlusion of its own.
    pub(crate) fn replaces_occlusion(self) -> bool {
        self.contains(Self::INDIRECT_DIFFUSE)
    }

    /// The shader definitions of the bits that say how occlusion is filtered and applied.
    pub(crate) fn occlusion_defs(self) -> impl Iterator<Item = &'static str> {
        [
            (Self::OCCLUSION_WIDE, "OCCLUSION_WIDE"),
            (Self::OCCLUSION_EDGE_AWARE, "OCCLUSION_EDGE_AWARE"),
            (Self::OCCLUSION_HALF, "OCCLUSION_HALF"),
            (Self::OCCLUSION_MULTIBOUNCE, "OCCLUSION_MULTIBOUNCE"),
            (Self::OCCLUSION_OF_DIRECT_LIGHT, "OCCLUSION_OF_DIRECT_LIGHT"),
        ]
        .into_iter()
        .filter(move |(bit, _)| self.contains(*bit))
        .map(|(_, name)| name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diffuse_gi_replaces_occlusion() {
        let occlusion = LightingIo::AMBIENT_OCCLUSION | LightingIo::OCCLUSION_HALF;
        let occludes = OccludesLight(occlusion);
        let asked = |has_gi| LightingIo::asked((false, false, true, has_gi, Some(&occludes)));
        assert_eq!(asked(false), LightingIo::INDIRECT_SPECULAR | occlusion);
        assert_eq!(asked(true), LightingIo::INDIRECT);
    }
}
