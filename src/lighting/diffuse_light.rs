//! The texture of the light that surfaces reflect diffusely, for those that read it.

use bevy::{
    image::ToExtents,
    prelude::*,
    render::{
        render_resource::{TextureDescriptor, TextureDimension, TextureFormat, TextureUsages},
        renderer::RenderDevice,
        texture::TextureCache,
        view::ViewTarget,
    },
};

use crate::view::{ActiveLeanView, DiffuseLight, LightExchange};

/// Words with a shared exponent.
pub(super) const DIFFUSE_LIGHT_FORMAT: TextureFormat = TextureFormat::R32Uint;

/// Gives each view whose lighting writes it its texture, and takes it from other lean views. With [`ActiveLeanView`] it
/// goes too.
pub(super) fn prepare_diffuse_light(
    mut commands: Commands,
    mut texture_cache: ResMut<TextureCache>,
    device: Res<RenderDevice>,
    views: Query<(Entity, &ViewTarget, &ActiveLeanView, Has<DiffuseLight>)>,
) {
    for (entity, target, active, has_texture) in &views {
        if active.exchange.contains(LightExchange::DIFFUSE_LIGHT) {
            // The cache counts textures as used in the frames in which they are asked for.
            let target = target.main_texture();
            let texture = texture_cache.get(
                &device,
                TextureDescriptor {
                    label: Some("lean_deferred/lighting/diffuse"),
                    size: UVec2::new(target.width(), target.height()).to_extents(),
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: TextureDimension::D2,
                    format: DIFFUSE_LIGHT_FORMAT,
                    usage: TextureUsages::STORAGE_BINDING
                        | TextureUsages::TEXTURE_BINDING
                        | TextureUsages::COPY_SRC,
                    view_formats: &[],
                },
            );
            commands.entity(entity).insert(DiffuseLight(texture));
        } else if has_texture {
            commands.entity(entity).remove::<DiffuseLight>();
        }
    }
}
