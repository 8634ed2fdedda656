//! Depths that samples far from their pixel are read from: neighbouring pixels then read texels that are close together in memory.

use bevy::{
    image::ToExtents,
    math::Vec4Swizzles,
    prelude::*,
    render::{
        render_resource::{
            TextureDescriptor, TextureDimension, TextureFormat, TextureUsages,
            TextureViewDescriptor,
        },
        renderer::RenderDevice,
        texture::CachedTexture,
        view::ExtractedView,
    },
};

use super::{
    active::ActiveOcclusion,
    prepare::{OcclusionTexture, ViewOcclusion},
    settings::LeanScreenSpaceAmbientOcclusion,
    uniforms::OcclusionUniform,
};
use crate::{
    gpu::texture_bytes::texture_bytes,
    shader_library::reconstruction::position::without_scale,
    view::{AmbientOcclusion, OutOfMemory},
};

/// Largest radius in pixels whose samples are all read at their pixels.
pub const FAR_RADIUS: f32 = 48.0;
/// Side of a cell in pixels.
pub const CELL_SIDE: u32 = 4;
pub(super) const FAR_DEPTHS_FORMAT: TextureFormat = TextureFormat::R32Float;

/// Depths at the corners of cells of a view, for radii above [`FAR_RADIUS`].
#[derive(Component, Clone)]
pub struct FarDepths(pub(super) CachedTexture);

impl FarDepths {
    pub(super) fn bytes(&self) -> u64 {
        texture_bytes(&self.0.texture)
    }
}

/// Number of cells along each axis of a viewport of this size, which may be empty.
pub fn cells(viewport_size: UVec2) -> UVec2 {
    viewport_size.map(|side| side.div_ceil(CELL_SIDE).max(1))
}

/// Samples on either side that are read at their pixels at any radius, of this many.
pub fn near_steps(steps: u32) -> u32 {
    (steps / 4).max(1)
}

/// True if the radius may exceed [`FAR_RADIUS`] in a view.
pub(super) fn marches_far(
    settings: &LeanScreenSpaceAmbientOcclusion,
    view: &ExtractedView,
) -> bool {
    let (clip_from_view, _) = without_scale(view.clip_from_view, view.world_from_view.to_matrix());
    let size = view.viewport.zw();
    OcclusionUniform::new(settings, clip_from_view, size).largest_radius() > FAR_RADIUS
}

/// Creates [`FarDepths`] of views whose gather reads them, and removes those of others. A texture is kept while its size stays the same.
pub(super) fn prepare_far_depths(
    mut commands: Commands,
    render_device: Res<RenderDevice>,
    mut memory: ResMut<OutOfMemory>,
    views: Query<(Entity, &ActiveOcclusion, &ViewOcclusion, Option<&FarDepths>)>,
) {
    for (entity, active, view, current) in &views {
        if !active.key.far_depths || active.gather.is_none() {
            if current.is_some() {
                commands.entity(entity).remove::<FarDepths>();
            }
            continue;
        }
        let label = "lean_deferred/effects/ambient_occlusion/far_depths";
        let size = cells(view.viewport.physical_size).to_extents();
        if current.is_some_and(|current| current.0.texture.size() == size) {
            continue;
        }
        let make = || {
            render_device.create_texture(&TextureDescriptor {
                label: Some(label),
                size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: TextureDimension::D2,
                format: FAR_DEPTHS_FORMAT,
                usage: TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        };
        match memory.fit(&render_device, entity, label, make) {
            Some(texture) => {
                let default_view = texture.create_view(&TextureViewDescriptor::default());
                let texture = CachedTexture {
                    texture,
                    default_view,
                };
                commands.entity(entity).insert(FarDepths(texture));
            }
            None => {
                // Without them the gather does not run, and its texture holds nothing.
                commands
                    .entity(entity)
                    .remove::<(FarDepths, OcclusionTexture, AmbientOcclusion)>();
            }
        }
    }
}
