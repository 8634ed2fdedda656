//! The targets of the G-buffer.

use bevy::{
    image::ToExtents,
    platform::collections::HashMap,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{
            LoadOp, Operations, RenderPassColorAttachment, StoreOp, TextureDescriptor,
            TextureDimension, TextureUsages,
        },
        renderer::RenderDevice,
        texture::{CachedTexture, TextureCache},
    },
};

use super::layout::{NO_GEOMETRY, NORMAL_FORMAT, SURFACE_FORMAT};
use crate::camera::ActiveLeanView;

/// The base targets of one view, as large as its render target. Optional targets will stand beside them.
#[derive(Component, Clone)]
pub struct GBufferTextures {
    /// Albedo, metallic, occlusion.
    pub surface: CachedTexture,
    /// Normal, roughness; [`NO_GEOMETRY`] where no mesh was drawn.
    pub normal: CachedTexture,
}

impl GBufferTextures {
    /// The attachments of the G-buffer pass, in the order of the fragment shader's outputs.
    pub(super) fn attachments(
        &self,
        load: LoadOp<wgpu::Color>,
    ) -> [Option<RenderPassColorAttachment<'_>>; 2] {
        [&self.surface, &self.normal].map(|texture| {
            Some(RenderPassColorAttachment {
                view: &texture.default_view,
                depth_slice: None,
                resolve_target: None,
                ops: Operations {
                    load,
                    store: StoreOp::Store,
                },
            })
        })
    }
}

/// How the G-buffer starts into its first pass.
pub(super) fn initial_load(view: &ActiveLeanView) -> LoadOp<wgpu::Color> {
    if view.depth_tells_geometry {
        // SAFETY: no pixel is read that the pass has not written: lighting looks at depth first, which is cleared, and
        // which each fragment that writes the G-buffer also writes.
        LoadOp::DontCare(unsafe { wgpu::LoadOpDontCare::enabled() })
    } else {
        LoadOp::Clear(wgpu::Color {
            r: f64::from(NO_GEOMETRY),
            ..default()
        })
    }
}

/// Gives each active view its targets and takes them from views that are no longer active. Cameras are drawn one after
/// the other, so those of one size share them.
pub(super) fn prepare_gbuffer_textures(
    mut commands: Commands,
    mut texture_cache: ResMut<TextureCache>,
    render_device: Res<RenderDevice>,
    views: Query<(Entity, &ExtractedCamera), With<ActiveLeanView>>,
    stale: Query<
        Entity,
        (
            With<GBufferTextures>,
            Or<(Without<ActiveLeanView>, Without<ExtractedCamera>)>,
        ),
    >,
    mut by_size: Local<HashMap<UVec2, GBufferTextures>>,
) {
    for entity in &stale {
        commands.entity(entity).remove::<GBufferTextures>();
    }
    for (entity, camera) in &views {
        let Some(size) = camera.physical_target_size else {
            continue;
        };
        let textures = by_size.entry(size).or_insert_with(|| {
            let mut texture = |label, format| {
                texture_cache.get(
                    &render_device,
                    TextureDescriptor {
                        label: Some(label),
                        size: size.to_extents(),
                        mip_level_count: 1,
                        sample_count: 1,
                        dimension: TextureDimension::D2,
                        format,
                        usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING,
                        view_formats: &[],
                    },
                )
            };
            GBufferTextures {
                surface: texture("lean_deferred/gbuffer/surface", SURFACE_FORMAT),
                normal: texture("lean_deferred/gbuffer/normal", NORMAL_FORMAT),
            }
        });
        commands.entity(entity).insert(textures.clone());
    }
    by_size.clear();
}

/// The lighting pass reads depth where it was drawn: no copy. Bevy creates the depth texture with the usages found
/// here.
pub(super) fn make_depth_readable(mut cameras: Query<&mut Camera3d, With<ActiveLeanView>>) {
    for mut camera in &mut cameras {
        let usages =
            TextureUsages::from(camera.depth_texture_usages) | TextureUsages::TEXTURE_BINDING;
        camera.depth_texture_usages = usages.into();
    }
}
