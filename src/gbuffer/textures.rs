//! The targets of the G-buffer.

use bevy::{
    image::ToExtents,
    platform::collections::HashMap,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{
            LoadOp, Operations, RenderPassColorAttachment, RenderPassDepthStencilAttachment,
            StoreOp, TextureDescriptor, TextureDimension, TextureUsages,
        },
        renderer::RenderDevice,
        texture::{CachedTexture, TextureCache},
        view::ViewDepthTexture,
    },
};

use super::layout::{NO_GEOMETRY, NORMAL_FORMAT, SURFACE_FORMAT, WRITTEN_FORMAT};
use crate::view::{ActiveLeanView, GBufferTargets, OutOfMemory};

/// The targets of one view, as large as its render target.
#[derive(Component, Clone)]
pub struct GBufferTextures {
    /// Albedo, metallic, occlusion; `R32Uint`.
    pub surface: CachedTexture,
    /// Normal, roughness; [`NO_GEOMETRY`] where no mesh was drawn; `R32Uint`.
    pub normal: CachedTexture,
    /// Which of the optional targets hold a word of the surface, on a view that has some; `R8Uint`.
    pub written: Option<CachedTexture>,
    /// The optional targets that the view has in this frame, in the order of their bits.
    optional: Vec<(GBufferTargets, CachedTexture)>,
}

impl GBufferTextures {
    /// The texture of a single optional target, if the view has it in this frame.
    pub fn optional(&self, target: GBufferTargets) -> Option<&CachedTexture> {
        self.optional
            .iter()
            .find_map(|(other, texture)| (*other == target).then_some(texture))
    }

    /// The optional targets that there are.
    pub(super) fn targets(&self) -> GBufferTargets {
        self.optional.iter().map(|(target, _)| *target).collect()
    }

    /// The attachments of the pass that writes the base targets alone.
    pub(super) fn base_attachments(
        &self,
        load: LoadOp<wgpu::Color>,
    ) -> [Option<RenderPassColorAttachment<'_>>; 2] {
        [&self.surface, &self.normal].map(|texture| Some(attachment(texture, load)))
    }

    /// The attachments of the pass that writes all targets, in the order of the fragment shader's outputs. If it
    /// `is_first` to write the optional ones, none is written yet.
    pub(super) fn all_attachments(
        &self,
        base_load: LoadOp<wgpu::Color>,
        is_first: bool,
    ) -> Vec<Option<RenderPassColorAttachment<'_>>> {
        let mut attachments = self.base_attachments(base_load).to_vec();
        let [nothing_written, anything] = if is_first {
            // SAFETY: no word is read where `written` does not say that a mesh has written it, and that is cleared.
            let anything = LoadOp::DontCare(unsafe { wgpu::LoadOpDontCare::enabled() });
            [LoadOp::Clear(wgpu::Color::BLACK), anything]
        } else {
            [LoadOp::Load; 2]
        };
        attachments.extend(
            (self.written.iter()).map(|texture| Some(attachment(texture, nothing_written))),
        );
        for (target, texture) in &self.optional {
            attachments.resize(target.slot(), None);
            attachments.push(Some(attachment(texture, anything)));
        }
        attachments
    }
}

fn attachment(texture: &CachedTexture, load: LoadOp<wgpu::Color>) -> RenderPassColorAttachment<'_> {
    RenderPassColorAttachment {
        view: &texture.default_view,
        depth_slice: None,
        resolve_target: None,
        ops: Operations {
            load,
            store: StoreOp::Store,
        },
    }
}

/// Whether depth is as it was cleared: nobody has drawn into it in this frame.
pub(super) fn is_cleared(depth: &RenderPassDepthStencilAttachment) -> bool {
    (depth.depth_ops).is_some_and(|ops| matches!(ops.load, LoadOp::Clear(_)))
}

/// How the G-buffer starts into its first pass. What others have drawn into depth before tells of nothing that is in it.
pub(super) fn initial_load(view: &ActiveLeanView, depth_is_cleared: bool) -> LoadOp<wgpu::Color> {
    if view.depth_tells_geometry && depth_is_cleared {
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

fn make_textures(
    cache: &mut TextureCache,
    device: &RenderDevice,
    size: UVec2,
    targets: GBufferTargets,
) -> GBufferTextures {
    let mut texture = |label, format| {
        let descriptor = TextureDescriptor {
            label: Some(label),
            size: size.to_extents(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        cache.get(device, descriptor)
    };
    GBufferTextures {
        surface: texture("lean_deferred/gbuffer/surface", SURFACE_FORMAT),
        normal: texture("lean_deferred/gbuffer/normal", NORMAL_FORMAT),
        written: (!targets.is_empty())
            .then(|| texture("lean_deferred/gbuffer/written", WRITTEN_FORMAT)),
        optional: targets
            .iter()
            .map(|target| (target, texture(target.label(), target.format())))
            .collect(),
    }
}

/// Gives each active view its targets and takes them from views that are no longer active. Cameras are drawn one after
/// the other, so those of one size that need the same share them.
///
/// They are as large as the depth that they are drawn with. What the camera says may lag behind a target that was resized
/// or replaced: then Bevy gives cameras of one target one depth, though they say different sizes.
pub(super) fn prepare_gbuffer_textures(
    mut commands: Commands,
    mut texture_cache: ResMut<TextureCache>,
    render_device: Res<RenderDevice>,
    mut memory: ResMut<OutOfMemory>,
    views: Query<(Entity, &ViewDepthTexture, &ActiveLeanView)>,
    stale: Query<
        Entity,
        (
            With<GBufferTextures>,
            Or<(Without<ActiveLeanView>, Without<ExtractedCamera>)>,
        ),
    >,
    mut by_size: Local<HashMap<(UVec2, GBufferTargets), GBufferTextures>>,
) {
    for entity in &stale {
        commands.entity(entity).remove::<GBufferTextures>();
    }
    for (entity, depth, active) in &views {
        let size = UVec2::new(depth.texture.width(), depth.texture.height());
        let key = (size, active.targets);
        let made = by_size.get(&key).cloned().or_else(|| {
            memory.fit(&render_device, entity, "lean_deferred/gbuffer", || {
                make_textures(&mut texture_cache, &render_device, size, active.targets)
            })
        });
        let Some(made) = made else {
            commands.entity(entity).remove::<GBufferTextures>();
            continue;
        };
        by_size.insert(key, made.clone());
        commands.entity(entity).insert(made);
    }
    by_size.clear();
}
