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

use super::{
    LeanAmbientOcclusion, ViewOcclusion, activity::ActiveOcclusion, support::OcclusionSupport,
};

/// The occlusion of a view, as large as its viewport or half that. 0 is none.
#[derive(Component, Clone)]
pub struct OcclusionTexture(pub CachedTexture);

/// Gives each view with ambient occlusion its texture.
pub(super) fn prepare_occlusion_textures(
    mut commands: Commands,
    mut texture_cache: ResMut<TextureCache>,
    render_device: Res<RenderDevice>,
    support: Res<OcclusionSupport>,
    views: Query<(Entity, &LeanAmbientOcclusion, &ViewOcclusion)>,
) {
    for (entity, settings, view) in &views {
        let storage = if support.can_store(settings.format) {
            TextureUsages::STORAGE_BINDING
        } else {
            TextureUsages::RENDER_ATTACHMENT
        };
        let texture = texture_cache.get(
            &render_device,
            TextureDescriptor {
                label: Some("lean_deferred/occlusion"),
                size: view.texture_size.to_extents(),
                mip_level_count: 1,
                sample_count: 1,
                dimension: TextureDimension::D2,
                format: settings.format.texture_format(),
                usage: storage | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC,
                view_formats: &[],
            },
        );
        commands.entity(entity).insert(OcclusionTexture(texture));
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
