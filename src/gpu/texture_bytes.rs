//! Sizes of textures in memory.

use bevy::render::render_resource::Texture;

/// Bytes of the texels of a 2D texture, without the padding of drivers.
pub(crate) fn texture_bytes(texture: &Texture) -> u64 {
    let size = texture.size();
    let texel = texture.format().block_copy_size(None).unwrap_or(0);
    let texels = (0..texture.mip_level_count()).map(|mip| {
        let [width, height] = [size.width, size.height].map(|side| (side >> mip).max(1));
        u64::from(width) * u64::from(height)
    });
    u64::from(texel) * u64::from(size.depth_or_array_layers) * texels.sum::<u64>()
}
