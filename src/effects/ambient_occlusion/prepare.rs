//! Per-view resources of the passes: uniform, texture and bind groups. Bind groups are recreated only when their resources change.

use core::iter;

use bevy::{
    camera::{MainPassResolutionOverride, Viewport},
    diagnostic::FrameCount,
    image::ToExtents,
    pbr::DistanceFog,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{
            BindGroup, DynamicUniformBuffer, IntoBinding, TextureDescriptor, TextureDimension,
            TextureUsages, TextureViewDescriptor,
        },
        renderer::{RenderDevice, RenderQueue},
        texture::CachedTexture,
        view::{ExtractedView, ViewDepthTexture},
    },
};

use super::{
    active::ActiveOcclusion,
    binding_numbers::{
        DEPTH_TEXTURE, NEAREST_SAMPLER, NORMAL_TEXTURE, OCCLUSION_TEXTURE, OUTPUT_TEXTURE,
        SPARSE_DEPTH_OUTPUT, SPARSE_DEPTH_TEXTURE, VIEW,
    },
    lattice,
    pipelines::{GatherPipeline, OcclusionPipelines},
    support::{FORMAT, SPARSE_DEPTH_FORMAT},
    uniforms::{OcclusionUniform, fog_parameters},
};
use crate::{
    gbuffer::GBufferTextures,
    gpu::{
        bind_group_cache::CachedBindGroup, growing_size::GrowingSize,
        storage_texture::StorageTexture, texture_bytes::texture_bytes,
    },
    shader_library::reconstruction::position::without_scale,
    view::{AmbientOcclusion, FrameAveraging, OutOfMemory},
};

const LABEL: &str = "lean_deferred/effects/ambient_occlusion";

/// Uniforms of all views.
#[derive(Resource, Default)]
pub(super) struct OcclusionUniforms(pub(super) DynamicUniformBuffer<OcclusionUniform>);

/// On a view with ambient occlusion: its uniform, the offset of that, and its viewport.
#[derive(Component)]
pub struct ViewOcclusion {
    pub(super) offset: u32,
    pub(super) uniform: OcclusionUniform,
    pub(super) viewport: Viewport,
}

/// Fills [`OcclusionUniforms`] and inserts [`ViewOcclusion`].
pub(super) fn write_occlusion_uniforms(
    mut commands: Commands,
    mut uniforms: ResMut<OcclusionUniforms>,
    (device, queue): (Res<RenderDevice>, Res<RenderQueue>),
    frame: Res<FrameCount>,
    mut views: Query<(
        Entity,
        &ActiveOcclusion,
        &ExtractedCamera,
        &ExtractedView,
        Option<&MainPassResolutionOverride>,
        Option<&DistanceFog>,
        Option<&FrameAveraging>,
        Option<&mut ViewOcclusion>,
    )>,
) {
    let Some(mut writer) = uniforms.0.get_writer(views.iter().len(), &device, &queue) else {
        return;
    };
    for (entity, active, camera, view, resolution_override, fog, averaging, current) in &mut views {
        let viewport =
            Viewport::from_viewport_and_override(camera.viewport.as_ref(), resolution_override)
                .unwrap_or_else(|| Viewport {
                    physical_size: camera.physical_target_size.unwrap_or(UVec2::ONE),
                    ..default()
                });
        let (clip_from_view, world_from_view) =
            without_scale(view.clip_from_view, view.world_from_view.to_matrix());
        let mut uniform =
            OcclusionUniform::new(&active.settings, clip_from_view, viewport.physical_size);
        uniform.view_from_world = world_from_view.inverse();
        uniform.fog = fog_parameters(fog);
        uniform.viewport_origin = viewport.physical_position;
        let turn = FrameAveraging::turn(averaging, &frame);
        // The gather may stand in for one of another quality.
        let (slices, _) = active.key.samples;
        uniform.set_pattern(slices, turn);
        let view = ViewOcclusion {
            offset: writer.write(&uniform),
            uniform,
            viewport,
        };
        match current {
            Some(mut current) => *current = view,
            None => {
                commands.entity(entity).insert(view);
            }
        }
    }
}

/// Textures of a view with ambient occlusion.
#[derive(Component)]
pub struct OcclusionTextures {
    /// Occlusion at full or half the size of the viewport, with headroom while that changes. 0 is unoccluded.
    pub(super) occlusion: CachedTexture,
    /// Depths of the lattices, for gathers that read them.
    sparse_depth: Option<StorageTexture>,
    growing: GrowingSize,
}

/// Sizes and usages of these textures.
struct TexturesNeeded {
    /// Of the occlusion, in texels.
    size: UVec2,
    usage: TextureUsages,
    sparse_depth_size: Option<UVec2>,
}

impl OcclusionTextures {
    fn new(device: &RenderDevice, needed: &TexturesNeeded) -> Self {
        let texture = device.create_texture(&TextureDescriptor {
            label: Some(LABEL),
            size: needed.size.to_extents(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: FORMAT,
            usage: needed.usage,
            view_formats: &[],
        });
        let default_view = texture.create_view(&TextureViewDescriptor::default());
        Self {
            occlusion: CachedTexture {
                texture,
                default_view,
            },
            sparse_depth: needed.sparse_depth_size.map(|size| {
                let label = "lean_deferred/effects/ambient_occlusion/sparse_depth";
                StorageTexture::new(device, label, size, SPARSE_DEPTH_FORMAT)
            }),
            growing: default(),
        }
    }

    fn are_as(&self, needed: &TexturesNeeded) -> bool {
        let texture = &self.occlusion.texture;
        let sparse_depth = self.sparse_depth.as_ref();
        (texture.size(), texture.usage()) == (needed.size.to_extents(), needed.usage)
            && sparse_depth.map(|held| held.texture.size())
                == needed.sparse_depth_size.map(|size| size.to_extents())
    }

    pub(super) fn bytes(&self) -> u64 {
        let sparse_depth = self.sparse_depth.as_ref().map(|held| &held.texture);
        iter::once(&self.occlusion.texture)
            .chain(sparse_depth)
            .map(texture_bytes)
            .sum()
    }
}

/// Creates the textures of active views, and gives lighting the occlusion that it reads: as [`AmbientOcclusion`]. Textures are kept
/// while they are large enough and their usages stay the same.
pub(super) fn prepare_occlusion_textures(
    mut commands: Commands,
    render_device: Res<RenderDevice>,
    mut memory: ResMut<OutOfMemory>,
    mut views: Query<(
        Entity,
        &ActiveOcclusion,
        &ViewOcclusion,
        Option<&mut OcclusionTextures>,
        Option<&mut AmbientOcclusion>,
    )>,
) {
    let largest = render_device.limits().max_texture_dimension_2d;
    for (entity, active, view, current, given) in &mut views {
        let Some(pipeline) = active.gather else {
            if current.is_some() {
                commands
                    .entity(entity)
                    .remove::<(OcclusionTextures, AmbientOcclusion)>();
            }
            continue;
        };
        let is_compute = matches!(pipeline, GatherPipeline::Compute { .. });
        let usage = if is_compute {
            TextureUsages::STORAGE_BINDING
        } else {
            TextureUsages::RENDER_ATTACHMENT
        };
        let divisor = active.settings.resolution.divisor();
        let needed = |size| TexturesNeeded {
            size,
            usage: usage | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC,
            sparse_depth_size: (active.key.reads_sparse_depth())
                .then(|| lattice::texture_size(size * divisor)),
        };
        let mut growing = current
            .as_ref()
            .map(|current| current.growing)
            .unwrap_or_default();
        // The raster pass does not repeat the last texels for the filter, so its textures have no headroom.
        let size = growing.fit(view.uniform.texture_size, largest, !is_compute);
        let mut made = None;
        let textures = match current {
            Some(current) if current.are_as(&needed(size)) => current.into_inner(),
            _ => {
                let make = |size| OcclusionTextures::new(&render_device, &needed(size));
                let fitting = memory.fit_growing(&render_device, entity, LABEL, &mut growing, make);
                let Some(textures) = fitting else {
                    commands
                        .entity(entity)
                        .remove::<(OcclusionTextures, AmbientOcclusion)>();
                    continue;
                };
                made.insert(textures)
            }
        };
        textures.growing = growing;
        let is_read = active.merge.is_none();
        let texture = textures.occlusion.default_view.clone();
        let occlusion = view.uniform.for_lighting(&active.settings, texture);
        match given {
            Some(mut given) if is_read => *given = occlusion,
            None if is_read => {
                commands.entity(entity).insert(occlusion);
            }
            Some(_) => {
                commands.entity(entity).remove::<AmbientOcclusion>();
            }
            None => {}
        }
        if let Some(made) = made {
            commands.entity(entity).insert(made);
        }
    }
}

/// On a view with ambient occlusion: the bind groups of its passes.
#[derive(Component, Default)]
pub struct OcclusionBindings {
    pub(super) sparse_depth: CachedBindGroup,
    pub(super) gather: CachedBindGroup,
    pub(super) merge: CachedBindGroup,
}

impl OcclusionBindings {
    /// Bind groups that are reused across frames while nothing changes.
    pub fn lasting_bind_groups(&self) -> impl Iterator<Item = &BindGroup> {
        [&self.sparse_depth, &self.gather, &self.merge]
            .into_iter()
            .filter_map(CachedBindGroup::get)
    }
}

/// Updates the bind groups of all active views.
pub(super) fn prepare_occlusion_bind_groups(
    mut commands: Commands,
    device: Res<RenderDevice>,
    pipelines: Option<Res<OcclusionPipelines>>,
    uniforms: Res<OcclusionUniforms>,
    mut views: Query<(
        Entity,
        &ActiveOcclusion,
        Option<&OcclusionTextures>,
        &ViewDepthTexture,
        Option<&GBufferTextures>,
        Option<&mut OcclusionBindings>,
    )>,
) {
    let (Some(pipelines), Some(uniforms)) = (pipelines, uniforms.0.binding()) else {
        return;
    };
    for (entity, active, textures, depth, gbuffer, bindings) in &mut views {
        let mut new = None;
        let bindings = match bindings {
            Some(bindings) => bindings.into_inner(),
            None => new.insert(OcclusionBindings::default()),
        };
        let (Some(textures), Some(_)) = (textures, active.gather) else {
            bindings.sparse_depth.clear();
            bindings.gather.clear();
            bindings.merge.clear();
            continue;
        };
        let occlusion = || textures.occlusion.default_view.into_binding();

        if let Some(layout) = pipelines.gather_layout(active.key) {
            bindings.gather.update(&device, layout, |entries| {
                entries.push(VIEW, uniforms.clone())?;
                entries.push(DEPTH_TEXTURE, depth.view().into_binding())?;
                entries.push(NEAREST_SAMPLER, pipelines.nearest_sampler.into_binding())?;
                if active.key.shading_normals {
                    entries.push(NORMAL_TEXTURE, gbuffer?.normal.default_view.into_binding())?;
                }
                if active.key.computes {
                    entries.push(OUTPUT_TEXTURE, occlusion())?;
                }
                if active.key.reads_sparse_depth() {
                    let sparse_depth = &textures.sparse_depth.as_ref()?.view;
                    entries.push(SPARSE_DEPTH_TEXTURE, sparse_depth.into_binding())?;
                }
                Some(())
            });
        }
        match &textures.sparse_depth {
            Some(sparse_depth) => {
                let layout = &pipelines.sparse_depth_layout;
                bindings.sparse_depth.update(&device, layout, |entries| {
                    entries.push(VIEW, uniforms.clone())?;
                    entries.push(DEPTH_TEXTURE, depth.view().into_binding())?;
                    entries.push(SPARSE_DEPTH_OUTPUT, sparse_depth.view.into_binding())
                });
            }
            None => bindings.sparse_depth.clear(),
        }
        if active.merge.is_some() {
            bindings
                .merge
                .update(&device, &pipelines.merge_layout, |entries| {
                    entries.push(VIEW, uniforms.clone())?;
                    entries.push(DEPTH_TEXTURE, depth.view().into_binding())?;
                    entries.push(NEAREST_SAMPLER, pipelines.nearest_sampler.into_binding())?;
                    entries.push(OCCLUSION_TEXTURE, occlusion())
                });
        } else {
            bindings.merge.clear();
        }
        if let Some(new) = new {
            commands.entity(entity).insert(new);
        }
    }
}
