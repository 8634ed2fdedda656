//! Allocates the targets of the G-buffer.

use bevy::{
    image::ToExtents,
    platform::collections::HashMap,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{
            LoadOp, Operations, RenderPassColorAttachment, RenderPassDepthStencilAttachment,
            StoreOp, Texture, TextureDescriptor, TextureDimension, TextureUsages,
        },
        renderer::RenderDevice,
        texture::{CachedTexture, TextureCache},
        view::ViewDepthTexture,
    },
};

use crate::{
    gpu::named::system_param,
    shader_library::layout::{NO_GEOMETRY, NORMAL_FORMAT, SURFACE_FORMAT, VALID_MASK_FORMAT},
    view::{ActiveLeanView, GBufferTargets, OutOfMemory},
};

/// The targets of one view, as large as its render target.
///
/// They contain this frame's words of the view from its [`GBufferPasses`](super::GBufferPasses) to the end of its
/// `Core3d` schedule, so a pass that reads them runs in `Core3d` after that set. At other times they may contain words
/// of another camera or frame: cameras with render targets of one size and the same optional targets share textures. A
/// pass that needs them longer copies them.
///
/// On views with [`ReadsGBuffer`], `normal` marks the pixels whose other words may be read.
#[derive(Component, Clone)]
pub struct GBufferTextures {
    /// Albedo, metallic, occlusion; undefined where `normal` has [`NO_GEOMETRY`]; `R32Uint`.
    pub surface: CachedTexture,
    /// Normal, roughness; [`NO_GEOMETRY`] wherever no lean mesh was drawn, also outside the viewport; `R32Uint`.
    /// Without [`ReadsGBuffer`] undefined there while [`ActiveLeanView::depth_tells_geometry`] is set: lighting tests
    /// for depth 0 instead.
    pub normal: CachedTexture,
    /// The [`GBufferTargets`] that contain a word of the surface, as their bits, on a view that has some; 0 where
    /// `normal` has [`NO_GEOMETRY`]; `R8Uint`.
    pub valid_mask: Option<CachedTexture>,
    /// The optional targets that the view has in this frame, in the order of their bits.
    optional: Vec<(GBufferTargets, CachedTexture)>,
}

/// On a view of the render world: a pass of the app reads its [`GBufferTextures`], so they are cleared in each frame.
/// Insert it before [`LeanViewSystems`](crate::view::LeanViewSystems). Clearing took 0.7 to 0.9 ms at 4K on an NVIDIA
/// H200, which rasterises weakly.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct ReadsGBuffer;

impl GBufferTextures {
    /// The texture of a single optional target, if the view has it in this frame. Undefined at pixels where `valid_mask`
    /// lacks its bit.
    pub fn optional(&self, target: GBufferTargets) -> Option<&CachedTexture> {
        self.optional
            .iter()
            .find_map(|(other, texture)| (*other == target).then_some(texture))
    }

    /// The optional targets that are allocated.
    pub(super) fn targets(&self) -> GBufferTargets {
        self.optional.iter().map(|(target, _)| *target).collect()
    }

    /// Key by which views share textures: size and optional targets.
    fn key(&self) -> (UVec2, GBufferTargets) {
        let normal = &self.normal.texture;
        (UVec2::new(normal.width(), normal.height()), self.targets())
    }

    /// The attachments of a pass, in the order of the fragment shader's outputs.
    pub(super) fn attachments(
        &self,
        pass: PassTargets,
        load: PassLoad,
    ) -> Vec<Option<RenderPassColorAttachment<'_>>> {
        let (surface, normal) = match load.base {
            BaseLoad::Drawn => (LoadOp::Load, LoadOp::Load),
            BaseLoad::Cleared => {
                let no_geometry = wgpu::Color {
                    r: f64::from(NO_GEOMETRY),
                    ..default()
                };
                (load_anything(), LoadOp::Clear(no_geometry))
            }
            BaseLoad::Anything => (load_anything(), load_anything()),
        };
        let mut attachments = vec![
            Some(attachment(&self.surface, surface)),
            Some(attachment(&self.normal, normal)),
        ];
        if pass == PassTargets::Base {
            return attachments;
        }
        let valid_mask = if load.has_valid_mask {
            LoadOp::Load
        } else {
            LoadOp::Clear(wgpu::Color::BLACK)
        };
        let drawn = (self.valid_mask.iter()).map(|texture| Some(attachment(texture, valid_mask)));
        attachments.extend(drawn);
        if pass == PassTargets::ValidMask {
            return attachments;
        }
        let words = if load.has_optional {
            LoadOp::Load
        } else {
            load_anything()
        };
        for (target, texture) in &self.optional {
            attachments.resize(target.slot(), None);
            attachments.push(Some(attachment(texture, words)));
        }
        attachments
    }
}

/// The targets of a pass.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum PassTargets {
    Base,
    /// The base and the valid mask.
    ValidMask,
    All,
}

/// State of the targets at the start of a pass.
#[derive(Clone, Copy)]
pub(super) struct PassLoad {
    pub(super) base: BaseLoad,
    /// An earlier pass of the frame has cleared the valid mask.
    pub(super) has_valid_mask: bool,
    /// An earlier pass of the frame may have drawn into the optional targets.
    pub(super) has_optional: bool,
}

impl PassLoad {
    /// The state after the `pass`.
    pub(super) fn after(self, pass: PassTargets) -> Self {
        Self {
            base: BaseLoad::Drawn,
            has_valid_mask: self.has_valid_mask || pass != PassTargets::Base,
            has_optional: self.has_optional || pass == PassTargets::All,
        }
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

/// State of the base targets at the start of a pass.
#[derive(Clone, Copy)]
pub(super) enum BaseLoad {
    /// An earlier pass has drawn into them.
    Drawn,
    /// Cleared to no geometry.
    Cleared,
    /// Undefined: depth tells which words may be read.
    Anything,
}

impl BaseLoad {
    /// The state for the first pass of a view. Depth that was not cleared may be of other systems' surfaces, so it does
    /// not mark geometry in the G-buffer.
    pub(super) fn first(view: &ActiveLeanView, depth: &RenderPassDepthStencilAttachment) -> Self {
        let is_cleared = (depth.depth_ops).is_some_and(|ops| matches!(ops.load, LoadOp::Clear(_)));
        if view.depth_tells_geometry && is_cleared {
            Self::Anything
        } else {
            Self::Cleared
        }
    }
}

/// Load operation for targets that are read only where `normal`, `valid_mask` (both cleared) or depth marks a word as
/// written.
fn load_anything<T>() -> LoadOp<T> {
    // SAFETY: only written words are read, see above.
    LoadOp::DontCare(unsafe { wgpu::LoadOpDontCare::enabled() })
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
        valid_mask: (!targets.is_empty())
            .then(|| texture("lean_deferred/gbuffer/valid_mask", VALID_MASK_FORMAT)),
        optional: targets
            .iter()
            .map(|target| (target, texture(target.label(), target.format())))
            .collect(),
    }
}

system_param! {
    /// Textures that views requested in this frame, by size and targets. Cameras are drawn in sequence, so those with
    /// equal keys share them.
    pub(super) struct SharedTextures<'w, 's> {
        cache: ResMut<'w, TextureCache>,
        device: Res<'w, RenderDevice>,
        memory: ResMut<'w, OutOfMemory>,
        by_size: Local<'s, HashMap<(UVec2, GBufferTargets), GBufferTextures>>,
    }
}

impl SharedTextures<'_, '_> {
    /// Returns `None` if they do not fit into memory. Textures that the view `held` in the last frame are still in
    /// Bevy's cache: nothing is allocated, so no check is needed.
    fn get(
        &mut self,
        view: Entity,
        held: Option<&GBufferTextures>,
        size: UVec2,
        targets: GBufferTargets,
    ) -> Option<GBufferTextures> {
        if let Some(made) = self.by_size.get(&(size, targets)) {
            return Some(made.clone());
        }
        let mut make = || make_textures(&mut self.cache, &self.device, size, targets);
        let made = if held.is_some_and(|held| held.key() == (size, targets)) {
            make()
        } else {
            (self.memory).fit(&self.device, view, "lean_deferred/gbuffer", make)?
        };
        self.by_size.insert((size, targets), made.clone());
        Some(made)
    }
}

/// Assigns each active view its targets and removes them from views that are no longer active.
pub(super) fn prepare_gbuffer_textures(
    mut commands: Commands,
    mut textures: SharedTextures,
    views: Query<(
        Entity,
        &ExtractedCamera,
        &ActiveLeanView,
        Option<&GBufferTextures>,
    )>,
    stale: Query<
        Entity,
        (
            With<GBufferTextures>,
            Or<(Without<ActiveLeanView>, Without<ExtractedCamera>)>,
        ),
    >,
) {
    for entity in &stale {
        commands.entity(entity).remove::<GBufferTextures>();
    }
    for (entity, camera, active, held) in &views {
        let Some(size) = camera.physical_target_size else {
            continue;
        };
        match textures.get(entity, held, size, active.targets) {
            Some(made) => commands.entity(entity).insert(made),
            None => commands.entity(entity).remove::<GBufferTextures>(),
        };
    }
    textures.by_size.clear();
}

/// Matches the size of the targets to that of depth. The size that the camera reports may lag behind a target that was
/// resized or replaced; Bevy then gives cameras of one target one depth texture although they report different sizes.
pub(super) fn fit_gbuffer_textures_to_depth(
    mut textures: SharedTextures,
    mut views: Query<(
        Entity,
        &ViewDepthTexture,
        &ActiveLeanView,
        &mut GBufferTextures,
    )>,
    mut commands: Commands,
) {
    for (entity, depth, active, mut held) in &mut views {
        let size = |texture: &Texture| UVec2::new(texture.width(), texture.height());
        let depth_size = size(&depth.texture);
        if size(&held.surface.texture) == depth_size {
            continue;
        }
        match textures.get(entity, None, depth_size, active.targets) {
            Some(made) => *held = made,
            None => {
                commands.entity(entity).remove::<GBufferTextures>();
            }
        }
    }
    textures.by_size.clear();
}
