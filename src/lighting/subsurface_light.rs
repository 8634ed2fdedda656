//! The textures of the light that enters surfaces beneath which it scatters, and the tiles that have some, for those that scatter
//! it.

use bevy::{
    camera::MainPassResolutionOverride,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{
            Buffer, BufferDescriptor, BufferUsages, CommandEncoder, Texture, TextureFormat,
        },
        renderer::RenderDevice,
        view::ViewTarget,
    },
};

use super::buffers::lit_pixels;
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
pub(crate) const LEVELS: usize = 6;
/// Pixels a side of a texel of the coarsest level that there is, though it is in no texture.
const COARSEST_TEXEL: u32 = 128;
/// 2 to the power of this is how many pixels a side a block of tiles has.
pub const BLOCK_LOG: u32 = 5;

const LABEL: &str = "lean_deferred/lighting/subsurface_light";

/// Where the buffer of the tiles has the masks of its blocks. How many blocks are listed and the materials of the frame come first.
pub const MASKS: u64 = 257;

/// On a view with [`ScattersLight`], for as long as it is lean. Layouts of words: `subsurface_light.wgsl`.
#[derive(Component)]
pub struct SubsurfaceLight {
    /// What enters, from the corner of the viewport, in tiles that have some; others have what they had in former frames. A multiple
    /// of the coarsest level's texel.
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
                size: 4 * (MASKS + 2 * blocks_of(size)),
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

    /// Before lighting notes tiles and materials.
    pub(super) fn clear_tiles(&self, encoder: &mut CommandEncoder) {
        encoder.clear_buffer(&self.tiles, 0, Some(4 * (MASKS + blocks_of(self.size()))));
    }

    /// All that it holds on the GPU but for the list.
    pub fn textures(&self) -> [&Texture; 2] {
        [&self.light.texture, &self.picture.texture]
    }
}

fn size_of(tile_count: UVec2) -> UVec2 {
    (tile_count * tiles::SIDE).map(|length| length.next_multiple_of(COARSEST_TEXEL))
}

/// How many blocks of tiles textures of this size have.
fn blocks_of(size: UVec2) -> u64 {
    u64::from((size >> BLOCK_LOG).element_product())
}

/// Gives each view whose lighting writes it its textures, and takes them from other lean views. With [`ActiveLeanView`] they
/// go too.
pub(crate) fn prepare_subsurface_light(
    mut commands: Commands,
    device: Res<RenderDevice>,
    mut memory: ResMut<OutOfMemory>,
    views: Query<(
        Entity,
        (
            &ExtractedCamera,
            &ViewTarget,
            Option<&MainPassResolutionOverride>,
        ),
        &ActiveLeanView,
        Has<ScattersLight>,
        Option<&SubsurfaceLight>,
    )>,
) {
    for (entity, (camera, target, resolution), active, scatters, current) in &views {
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
        let (_, size) = lit_pixels(camera, target, resolution);
        let tile_count = tiles::count(size).max(UVec2::ONE);
        if current.is_none_or(|current| current.tile_count != tile_count) {
            let make = || SubsurfaceLight::new(&device, tile_count);
            match memory.fit(&device, entity, LABEL, make) {
                Some(made) => commands.entity(entity).insert(made),
                None => commands.entity(entity).remove::<SubsurfaceLight>(),
            };
        }
    }
}
