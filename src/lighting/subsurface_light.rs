//! The textures of the light that enters surfaces beneath which it scatters, and the list of the tiles that have some, for
//! those that scatter it.

use bevy::{
    prelude::*,
    render::{
        render_resource::{
            Buffer, BufferDescriptor, BufferUsages, CommandEncoder, Texture, TextureFormat,
        },
        renderer::RenderDevice,
    },
};

use super::ViewLighting;
use crate::{
    gpu::storage_texture::StorageTexture,
    shader_library::tiles,
    view::{ActiveLeanView, LightExchange, OutOfMemory, ScattersLight},
};

/// Of the light: distance and material, and the word of the light.
pub(crate) const SUBSURFACE_LIGHT_FORMAT: TextureFormat = TextureFormat::Rg32Uint;
/// Of the picture: colour, what is left of scattered light, and the arguments of the shading model.
pub(super) const SUBSURFACE_PICTURE_FORMAT: TextureFormat = TextureFormat::Rgba32Uint;
/// Of the light, whose coarser ones scattering makes.
pub(crate) const LEVELS: usize = 8;

const LABEL: &str = "lean_deferred/lighting/subsurface_light";

/// Where the buffer of the tiles has these. Their count and the materials of the frame come first.
pub const TILES: u64 = 257;

/// On a view with [`ScattersLight`], for as long as it is lean. Layouts of words: `subsurface_light.wgsl`.
#[derive(Component)]
pub struct SubsurfaceLight {
    /// What enters, from the corner of the viewport; zeros wherever nothing does. A multiple of the coarsest level's texel.
    pub(crate) light: StorageTexture<LEVELS>,
    /// Of the pixels whose light scatters.
    pub(crate) picture: StorageTexture,
    pub(crate) tiles: Buffer,
    /// Of the view.
    tile_count: UVec2,
}

impl SubsurfaceLight {
    fn new(device: &RenderDevice, tile_count: UVec2) -> Self {
        let size = size_of(tile_count);
        Self {
            light: StorageTexture::new(device, LABEL, size, SUBSURFACE_LIGHT_FORMAT),
            picture: StorageTexture::new(
                device,
                "lean_deferred/lighting/subsurface_picture",
                size,
                SUBSURFACE_PICTURE_FORMAT,
            ),
            tiles: device.create_buffer(&BufferDescriptor {
                label: Some("lean_deferred/lighting/scattering_tiles"),
                size: 4 * (TILES + 2 * u64::from(tile_count.element_product())),
                usage: BufferUsages::STORAGE | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            tile_count,
        }
    }

    /// Of the textures, in pixels.
    pub(crate) fn size(&self) -> UVec2 {
        size_of(self.tile_count)
    }

    /// Before lighting lists tiles and materials.
    pub(super) fn clear_list(&self, encoder: &mut CommandEncoder) {
        encoder.clear_buffer(&self.tiles, 0, Some(4 * TILES));
    }

    /// All that it holds on the GPU but for the list.
    pub fn textures(&self) -> [&Texture; 2] {
        [&self.light.texture, &self.picture.texture]
    }
}

fn size_of(tile_count: UVec2) -> UVec2 {
    let texel = 1 << (LEVELS - 1);
    (tile_count * tiles::SIDE).map(|length| length.next_multiple_of(texel))
}

/// Gives each view whose lighting writes it its textures, and takes them from other lean views. With [`ActiveLeanView`] they
/// go too.
pub(crate) fn prepare_subsurface_light(
    mut commands: Commands,
    device: Res<RenderDevice>,
    mut memory: ResMut<OutOfMemory>,
    views: Query<(
        Entity,
        &ViewLighting,
        &ActiveLeanView,
        Has<ScattersLight>,
        Option<&SubsurfaceLight>,
    )>,
) {
    for (entity, lighting, active, scatters, current) in &views {
        // While lighting without it is still compiling, it is kept.
        let is_written = active.exchange.contains(LightExchange::SUBSURFACE_LIGHT);
        if !is_written {
            if current.is_some() {
                commands.entity(entity).remove::<SubsurfaceLight>();
            }
            continue;
        }
        if !scatters && current.is_some() {
            continue;
        }
        let tile_count = tiles::count(lighting.bindings.viewport_size).max(UVec2::ONE);
        if current.is_none_or(|current| current.tile_count != tile_count) {
            let make = || SubsurfaceLight::new(&device, tile_count);
            match memory.fit(&device, entity, LABEL, make) {
                Some(made) => commands.entity(entity).insert(made),
                None => commands.entity(entity).remove::<SubsurfaceLight>(),
            };
        }
    }
}
