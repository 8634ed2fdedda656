//! The occlusion texture.

use bevy::{
    image::ToExtents,
    prelude::*,
    render::{
        render_resource::{TextureDescriptor, TextureDimension, TextureUsages},
        renderer::RenderDevice,
        texture::{CachedTexture, TextureCache},
    },
};

use super::{ActiveOcclusion, ViewOcclusion, activity::GatherPipeline};

/// The occlusion of a view, as large as its viewport or half that. 0 is none.
#[derive(Component, Clone)]
pub struct OcclusionTexture(pub CachedTexture);

/// Gives each view that finds occlusion its texture.
pub(super) fn prepare_occlusion_textures(
    mut commands: Commands,
    mut texture_cache: ResMut<TextureCache>,
    render_device: Res<RenderDevice>,
    mut views: Query<(
        Entity,
        &ActiveOcclusion,
        &ViewOcclusion,
        Option<&mut OcclusionTexture>,
    )>,
) {
    for (entity, active, view, current) in &mut views {
        let usage = match active.gather {
            Some(GatherPipeline::Compute(_)) => TextureUsages::STORAGE_BINDING,
            Some(GatherPipeline::Raster(_)) => TextureUsages::RENDER_ATTACHMENT,
            None => {
                if current.is_some() {
                    commands.entity(entity).remove::<OcclusionTexture>();
                }
                continue;
            }
        };
        let texture = texture_cache.get(
            &render_device,
            TextureDescriptor {
                label: Some("lean_deferred/occlusion"),
                size: view.texture_size.to_extents(),
                mip_level_count: 1,
                sample_count: 1,
                dimension: TextureDimension::D2,
                format: active.key.format.texture_format(),
                usage: usage | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC,
                view_formats: &[],
            },
        );
        match current {
            Some(mut current) => current.0 = texture,
            None => {
                commands.entity(entity).insert(OcclusionTexture(texture));
            }
        }
    }
}

/// Depth is read where it was drawn: no copy. Bevy creates the depth texture with the usages found here.
pub(super) fn make_depth_readable(mut cameras: Query<&mut Camera3d, With<ActiveOcclusion>>) {
    for mut camera in &mut cameras {
        let usages =
            TextureUsages::from(camera.depth_texture_usages) | TextureUsages::TEXTURE_BINDING;
        camera.depth_texture_usages = usages.into();
    }
}
