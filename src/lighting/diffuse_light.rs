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

/// Assigns a texture, at least as large as the viewport, to each view whose lighting writes it, and removes it from other
/// lean views. It is also removed with [`ActiveLeanView`]. It persists between frames: the next one reads it before it is
/// rewritten. In the frame of a reallocation, that is the former texture.
pub(super) fn prepare_diffuse_light(
    mut commands: Commands,
    device: Res<RenderDevice>,
    mut memory: ResMut<OutOfMemory>,
    mut views: Query<(
        Entity,
        (
            &ExtractedCamera,
            &ViewTarget,
            Option<&MainPassResolutionOverride>,
        ),
        &ActiveLeanView,
        Option<&mut DiffuseLight>,
    )>,
) {
    let largest = device.limits().max_texture_dimension_2d;
    for (entity, (camera, target, resolution), active, mut current) in &mut views {
        if !active.io.contains(LightingIo::DIFFUSE_LIGHT) {
            if current.is_some() {
                commands.entity(entity).remove::<DiffuseLight>();
            }
            continue;
        }
        // Viewports may be empty.
        let (_, needed) = lit_pixels(camera, target, resolution);
        let mut growing = current.as_ref().map(|light| light.size).unwrap_or_default();
        let size = growing.fit(needed.max(UVec2::ONE), largest, false);
        if let Some(current) = &mut current {
            current.size = growing;
            if current.last.texture.id() != current.texture.texture.id() {
                current.last = current.texture.clone();
            }
            if current.texture.texture.size() == size.to_extents() {
                continue;
            }
        }
        let label = "lean_deferred/lighting/diffuse";
        let descriptor = |size: UVec2| TextureDescriptor {
            label: Some(label),
            size: size.to_extents(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: DIFFUSE_LIGHT_FORMAT,
            usage: TextureUsages::STORAGE_BINDING
                | TextureUsages::TEXTURE_BINDING
                | TextureUsages::COPY_SRC,
            view_formats: &[],
        };
        let made = memory.fit_growing(&device, entity, label, &mut growing, |size| {
            device.create_texture(&descriptor(size))
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
        match current {
            Some(mut current) => {
                current.texture = texture;
                current.size = growing;
            }
            None => {
                commands.entity(entity).insert(DiffuseLight {
                    last: texture.clone(),
                    texture,
                    size: growing,
                });
            }
        }
    }
}
