//! Depth of the opaque meshes, on views that show meshes with specular transmission. Those write depth, but their pixels show light
//! from behind, and rays pass through them: the history stores that light at the depth of the opaque surface.

use bevy::{
    pbr::Transmissive3d,
    platform::collections::HashMap,
    prelude::*,
    render::{
        render_phase::ViewSortedRenderPhases,
        render_resource::{
            Extent3d, TextureDescriptor, TextureDimension, TextureUsages, TextureViewDescriptor,
        },
        renderer::{RenderContext, RenderDevice, ViewQuery},
        texture::CachedTexture,
        view::{ExtractedView, ViewDepthTexture},
    },
};

use super::{prepare::ViewHistory, request::ReadsHistory};
use crate::view::OutOfMemory;

/// In the render world: copies of depth, by size. Views are rendered one after another, so views of one size share a copy. A copy is
/// created when the first transmissive mesh becomes visible, and kept while any history has its size.
#[derive(Resource, Default)]
pub(super) struct OpaqueDepths(HashMap<Extent3d, CachedTexture>);

impl OpaqueDepths {
    fn get(
        &mut self,
        device: &RenderDevice,
        memory: &mut OutOfMemory,
        view: Entity,
        depth: &ViewDepthTexture,
    ) -> Option<CachedTexture> {
        let size = depth.texture.size();
        if let Some(copy) = self.0.get(&size) {
            return Some(copy.clone());
        }
        let label = "lean_deferred/effects/history/opaque_depth";
        let make = || {
            device.create_texture(&TextureDescriptor {
                label: Some(label),
                size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: TextureDimension::D2,
                format: depth.texture.format(),
                usage: TextureUsages::COPY_DST | TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        };
        let texture = memory.fit(device, view, label, make)?;
        let default_view = texture.create_view(&TextureViewDescriptor::default());
        let copy = CachedTexture {
            texture,
            default_view,
        };
        self.0.insert(size, copy.clone());
        Some(copy)
    }
}

/// Gives a copy of depth to each history whose view shows a transmissive mesh, and removes it from the others.
pub(super) fn prepare_opaque_depths(
    device: Res<RenderDevice>,
    mut depths: ResMut<OpaqueDepths>,
    mut memory: ResMut<OutOfMemory>,
    transmissive: Option<Res<ViewSortedRenderPhases<Transmissive3d>>>,
    mut views: Query<
        (Entity, &ExtractedView, &ViewDepthTexture, &mut ViewHistory),
        With<ReadsHistory>,
    >,
) {
    depths.0.retain(|size, _| {
        views
            .iter()
            .any(|(_, _, depth, _)| depth.texture.size() == *size)
    });
    for (entity, view, depth, mut history) in &mut views {
        let phase = transmissive
            .as_ref()
            .and_then(|phases| phases.get(&view.retained_view_entity));
        let hides = phase.is_some_and(|phase| !phase.items.is_empty());
        history.opaque_depth = if hides {
            depths.get(&device, &mut memory, entity, depth)
        } else {
            None
        };
    }
}

/// Runs before transmissive meshes are drawn.
pub(super) fn copy_opaque_depth(
    view: ViewQuery<(&ViewHistory, &ViewDepthTexture)>,
    mut ctx: RenderContext,
) {
    let (history, depth) = view.into_inner();
    // Depth textures can only be copied whole.
    if let Some(copy) = &history.opaque_depth
        && copy.texture.size() == depth.texture.size()
        && depth.texture.usage().contains(TextureUsages::COPY_SRC)
    {
        ctx.command_encoder().copy_texture_to_texture(
            depth.texture.as_image_copy(),
            copy.texture.as_image_copy(),
            depth.texture.size(),
        );
    }
}
