//! The textures of the light that enters surfaces beneath which it scatters, for those that scatter it.

use bevy::{
    prelude::*,
    render::{
        render_resource::{Texture, TextureFormat},
        renderer::RenderDevice,
    },
};

use super::ViewLighting;
use crate::{
    gpu::{storage_texture::StorageTexture, tiles},
    view::{ActiveLeanView, LightExchange, ScattersLight},
};

/// Of the light: distance and material, and the word of the light.
pub(crate) const SUBSURFACE_LIGHT_FORMAT: TextureFormat = TextureFormat::Rg32Uint;
/// Of the picture: colour, what is left of scattered light, and the arguments of the shading model.
pub(super) const SUBSURFACE_PICTURE_FORMAT: TextureFormat = TextureFormat::Rgba32Uint;
/// Of the light, whose coarser ones scattering makes. Compute shaders can store to at least four textures on any device.
pub(crate) const LEVELS: usize = 4;

/// On a view with [`ScattersLight`], for as long as it is lean. Layouts of words: `subsurface_light.wgsl`. As large as the
/// viewport in whole tiles.
#[derive(Component)]
pub struct SubsurfaceLight {
    /// What enters. Zeros wherever nothing does: who scatters light clears it again.
    pub(crate) light: StorageTexture<LEVELS>,
    /// Of the pixels whose light scatters.
    pub(crate) picture: StorageTexture,
    /// Nobody cleared it.
    is_stale: bool,
}

impl SubsurfaceLight {
    fn new(device: &RenderDevice, size: UVec2) -> Self {
        Self {
            light: StorageTexture::new(
                device,
                "lean_deferred/subsurface/light",
                size,
                SUBSURFACE_LIGHT_FORMAT,
            ),
            picture: StorageTexture::new(
                device,
                "lean_deferred/subsurface/picture",
                size,
                SUBSURFACE_PICTURE_FORMAT,
            ),
            is_stale: false,
        }
    }

    fn size(&self) -> UVec2 {
        let texture = &self.light.texture;
        UVec2::new(texture.width(), texture.height())
    }

    /// All that it holds on the GPU.
    pub fn textures(&self) -> [&Texture; 2] {
        [&self.light.texture, &self.picture.texture]
    }
}

/// Gives each view whose lighting writes it its textures, and takes them from other lean views. With [`ActiveLeanView`] they
/// go too.
pub(super) fn prepare_subsurface_light(
    mut commands: Commands,
    device: Res<RenderDevice>,
    mut views: Query<(
        Entity,
        &ViewLighting,
        &ActiveLeanView,
        Has<ScattersLight>,
        Option<&mut SubsurfaceLight>,
    )>,
) {
    for (entity, lighting, active, scatters, current) in &mut views {
        if !active.exchange.contains(LightExchange::SUBSURFACE_LIGHT) {
            if current.is_some() {
                commands.entity(entity).remove::<SubsurfaceLight>();
            }
            continue;
        }
        let size = tiles::count(lighting.bindings.viewport_size).max(UVec2::ONE) * tiles::SIDE;
        match current {
            Some(mut current) if current.size() == size && !(current.is_stale && scatters) => {
                // Lighting for the view without scattering is still compiling.
                current.is_stale |= !scatters;
            }
            _ => {
                let made = SubsurfaceLight::new(&device, size);
                commands.entity(entity).insert(made);
            }
        }
    }
}
