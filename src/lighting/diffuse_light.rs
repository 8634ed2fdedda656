//! Allocates the texture of the light that surfaces emit, transmit or reflect diffusely, for effects that read it.

use bevy::{
    camera::MainPassResolutionOverride,
    image::ToExtents,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{
            TextureDescriptor, TextureDimension, TextureFormat, TextureUsages,
            TextureViewDescriptor,
        },
        renderer::RenderDevice,
        texture::CachedTexture,
        view::ViewTarget,
    },
};

use super::bevy::background::lit_pixels;
use crate::view::{ActiveLeanView, DiffuseLight, LightingIo, OutOfMemory};

/// One word per pixel, with a shared exponent.
pub(super) const DIFFUSE_LIGHT_FORMAT: TextureFormat = TextureFormat::R32Uint;

/// Assigns a texture, as large as the viewport, to each view whose lighting writes it, and removes it from other lean
/// views. It is also removed with [`ActiveLeanView`]. It persists between frames: the next one reads it before it is
/// rewritten.
pub(super) fn prepare_diffuse_light(
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
        Option<&DiffuseLight>,
    )>,
) {
    for (entity, (camera, target, resolution), active, current) in &views {
        if !active.io.contains(LightingIo::DIFFUSE_LIGHT) {
            if current.is_some() {
                commands.entity(entity).remove::<DiffuseLight>();
            }
            continue;
        }
        // Viewports may be empty.
        let (_, size) = lit_pixels(camera, target, resolution);
        let size = size.max(UVec2::ONE).to_extents();
        if current.is_some_and(|current| current.0.texture.size() == size) {
            continue;
        }
        let label = "lean_deferred/lighting/diffuse";
        let descriptor = TextureDescriptor {
            label: Some(label),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: DIFFUSE_LIGHT_FORMAT,
            usage: TextureUsages::STORAGE_BINDING
                | TextureUsages::TEXTURE_BINDING
                | TextureUsages::COPY_SRC,
            view_formats: &[],
        };
        let made = memory.fit(&device, entity, label, || {
            device.create_texture(&descriptor)
        });
        let Some(texture) = made else {
            commands.entity(entity).remove::<DiffuseLight>();
            continue;
        };
        let default_view = texture.create_view(&TextureViewDescriptor::default());
        let texture = CachedTexture {
            texture,
            default_view,
        };
        commands.entity(entity).insert(DiffuseLight(texture));
    }
}
