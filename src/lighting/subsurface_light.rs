//! Allocates the textures of the light that enters scattering surfaces and the list of tiles that have some, for the
//! scattering pass.

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

use super::bevy::background::lit_pixels;
use crate::{
    gpu::{storage_texture::StorageTexture, texture_bytes::texture_bytes},
    view::{ActiveLeanView, LightingIo, OutOfMemory, ScattersLight},
};

/// Per texel of the light: a word of distance and material, and a word of the light.
pub(crate) const SUBSURFACE_LIGHT_FORMAT: TextureFormat = TextureFormat::Rg32Uint;
/// Per pixel of the picture: colour (two words), remaining part of scattered light, and the normal word of the
/// G-buffer.
pub(super) const SUBSURFACE_PICTURE_FORMAT: TextureFormat = TextureFormat::Rgba32Uint;
/// Mips of the light; scattering fills the coarser ones.
pub(crate) const LEVELS: usize = 6;
/// Side in pixels of a texel of the coarsest level, which is in no texture.
const COARSEST_TEXEL: u32 = 128;
/// Base-2 logarithm of the side of a block of tiles, in pixels.
pub const BLOCK_LOG: u32 = 5;

const LABEL: &str = "lean_deferred/lighting/subsurface_light";

/// Index of the block masks in the buffer of the tiles, in words. The number of listed blocks and the materials of the
/// frame come first.
pub const MASKS: u64 = 257;

/// On a view with [`ScattersLight`], for as long as it is lean. `subsurface_light.wgsl` defines the layouts of its
/// words.
#[derive(Component)]
pub struct SubsurfaceLight {
    /// Entering light, relative to the corner of the viewport. Valid in tiles that have some; others keep words of
    /// former frames. The size is a multiple of the coarsest level's texel.
    pub(crate) light: StorageTexture<LEVELS>,
    /// The picture at pixels that scatter light.
    pub(crate) picture: StorageTexture,
    pub(crate) tiles: Buffer,
    /// Size of the textures in pixels.
    size: UVec2,
}

impl SubsurfaceLight {
    fn new(device: &RenderDevice, size: UVec2) -> Self {
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
            size,
        }
    }

    /// Size of the textures in pixels.
    pub(crate) fn size(&self) -> UVec2 {
        self.size
    }

    /// Clears the list before lighting records tiles and materials.
    pub(super) fn clear_tiles(&self, encoder: &mut CommandEncoder) {
        encoder.clear_buffer(&self.tiles, 0, Some(4 * (MASKS + blocks_of(self.size()))));
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.textures().map(texture_bytes).into_iter().sum::<u64>() + self.tiles.size()
    }

    /// Its textures; its only other GPU resource is the list.
    pub fn textures(&self) -> [&Texture; 2] {
        [&self.light.texture, &self.picture.texture]
    }
}

/// Size of the textures of a view with `pixels`.
fn size_of(pixels: UVec2) -> UVec2 {
    (pixels.max(UVec2::ONE)).map(|length| length.next_multiple_of(COARSEST_TEXEL))
}

/// Number of blocks of tiles in textures of this size.
fn blocks_of(size: UVec2) -> u64 {
    u64::from((size >> BLOCK_LOG).element_product())
}

/// Assigns textures to each view whose lighting writes this light, and removes them from other lean views. They are
/// also removed with [`ActiveLeanView`].
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
        // Kept until lighting without it is compiled.
        let is_written = active.io.contains(LightingIo::SUBSURFACE_LIGHT);
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
        let size = size_of(size);
        if current.is_none_or(|current| current.size != size) {
            let make = || SubsurfaceLight::new(&device, size);
            match memory.fit(&device, entity, LABEL, make) {
                Some(made) => commands.entity(entity).insert(made),
                None => commands.entity(entity).remove::<SubsurfaceLight>(),
            };
        }
    }
}
