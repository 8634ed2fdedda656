//! What other effects take from lighting, and give to it.
//!
//! An effect inserts these components on its views in the render world before [`LeanViewSystems`](super::LeanViewSystems),
//! and removes them when it is done. [`ActiveLeanView`](super::ActiveLeanView) says what lighting does in this frame: while
//! it is compiling for what is new, it does what it did before.

use bevy::{
    prelude::*,
    render::{render_resource::TextureView, texture::CachedTexture},
};
use bitflags::bitflags;

bitflags! {
    /// What lighting takes and gives.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub struct LightExchange: u8 {
        /// It writes the [`DiffuseLight`].
        const DIFFUSE_LIGHT = 1 << 0;
        /// It adds the [`IndirectSpecular`].
        const INDIRECT_SPECULAR = 1 << 1;
        /// It adds the [`IndirectDiffuse`].
        const INDIRECT_DIFFUSE = 1 << 2;
        /// It writes the light that scatters beneath surfaces: [`ScattersLight`].
        const SUBSURFACE_LIGHT = 1 << 3;
        /// Either of those that it adds.
        const INDIRECT = Self::INDIRECT_SPECULAR.bits() | Self::INDIRECT_DIFFUSE.bits();
    }
}

/// Something reads the [`DiffuseLight`] of this view.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct ReadsDiffuseLight;

/// Something scatters the light beneath the surfaces of this view that let it in, where lighting has written it apart.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct ScattersLight;

/// On a view with [`ReadsDiffuseLight`], for as long as it is lean: what of the picture is light that surfaces send out in all
/// directions alike, because they reflect it diffusely, transmit or emit it. The picture has it too.
///
/// `R32Uint`, as large as the viewport, each word with a shared exponent (`layout/light.wgsl`: off by at most 1/511 of
/// the brightest channel). Exposed, before fog; 0 where no lean mesh is. Until lighting writes it, it holds what the last
/// frame has sent out, or zeros.
#[derive(Component, Clone)]
pub struct DiffuseLight(pub CachedTexture);

/// An effect finds what surfaces of this view mirror. Lighting mixes it with the environment maps, reflection probes and
/// ambient light that it finds itself, with the same Fresnel and roughness terms.
///
/// In the texture, of a format with floats and as large as the viewport: radiance from about the mirrored direction, as
/// rough as the surface is (its coat, if it has one), exposed as this frame is; and, in alpha, the confidence, 0 to 1, with
/// which it takes the place of the others. What is there was seen, so that ambient occlusion does not darken it. Without a
/// texture nothing is found.
#[derive(Component, Clone, Debug, Default)]
pub struct IndirectSpecular(pub Option<TextureView>);

/// An effect finds light that falls onto surfaces of this view from others. Lighting adds it to the irradiance volumes,
/// environment maps and ambient light that it finds itself, but on lightmapped surfaces, whose lightmap has it.
///
/// In the texture, of a format with floats and as large as the viewport: irradiance over π (the mean radiance), exposed
/// as this frame is; and, in alpha, what part of the light from everywhere else is hidden, 0 to 1: applied in the place of
/// ambient occlusion. Without a texture nothing is found or hidden. It may also be half as large each way, rounded up: then
/// each texel is about the middle of the 2×2 pixels that it stands for, and lighting scales up along the edges that depth
/// shows.
#[derive(Component, Clone, Debug, Default)]
pub struct IndirectDiffuse(pub Option<TextureView>);

/// What effects ask of a view. A tuple: the bounds in a derived query have the compiler walk over all types of `wgpu`.
pub(crate) type ExchangeQuery = (
    Has<ReadsDiffuseLight>,
    Has<ScattersLight>,
    Has<IndirectSpecular>,
    Has<IndirectDiffuse>,
);

impl LightExchange {
    /// What has been found by an [`ExchangeQuery`].
    pub(crate) fn asked(
        (diffuse_light, scatters, specular, diffuse): (bool, bool, bool, bool),
    ) -> Self {
        [
            (diffuse_light, Self::DIFFUSE_LIGHT),
            (scatters, Self::SUBSURFACE_LIGHT),
            (specular, Self::INDIRECT_SPECULAR),
            (diffuse, Self::INDIRECT_DIFFUSE),
        ]
        .into_iter()
        .filter_map(|(is_asked, what)| is_asked.then_some(what))
        .collect()
    }
}
