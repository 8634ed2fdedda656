//! What depth textures are made for.

use bevy::{prelude::*, render::render_resource::TextureUsages};

/// Views with `C` have depth textures that can be used for `usage` too, so that depth is read where it was drawn. To be run
/// before Bevy's `prepare_core_3d_depth_textures`, which makes them with the usages found here.
pub(crate) fn extend_depth_usage<C: Component>(
    usage: TextureUsages,
) -> impl FnMut(Query<&mut Camera3d, With<C>>) {
    move |mut cameras| {
        for mut camera in &mut cameras {
            let usages = TextureUsages::from(camera.depth_texture_usages) | usage;
            camera.depth_texture_usages = usages.into();
        }
    }
}
