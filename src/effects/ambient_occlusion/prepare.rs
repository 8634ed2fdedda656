//! Per-view resources of the passes: uniform, texture and bind groups. Bind groups are recreated only when their resources change.

use bevy::{
    camera::{MainPassResolutionOverride, Viewport},
    diagnostic::FrameCount,
    image::ToExtents,
    pbr::DistanceFog,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{
            BindGroup, DynamicUniformBuffer, IntoBinding, Texture, TextureDescriptor,
            TextureDimension, TextureUsages, TextureViewDescriptor,
        },
        renderer::{RenderDevice, RenderQueue},
        texture::CachedTexture,
        view::{ExtractedView, ViewDepthTexture},
    },
};

use super::{
    active::ActiveOcclusion,
    binding_numbers::{
        DEPTH_TEXTURE, NEAREST_SAMPLER, NORMAL_TEXTURE, OCCLUSION_TEXTURE, OUTPUT_TEXTURE, VIEW,
    },
    pipelines::{GatherPipeline, OcclusionPipelines},
    support::FORMAT,
    uniforms::{OcclusionUniform, fog_parameters},
};
use crate::{
    gbuffer::GBufferTextures,
    gpu::{bind_group_cache::CachedBindGroup, texture_bytes::texture_bytes},
    shader_library::reconstruction::position::without_scale,
    view::{AmbientOcclusion, FrameAveraging, OutOfMemory},
};

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

/// Occlusion of a view, at full or half the size of its viewport. 0 is unoccluded.
#[derive(Component, Clone)]
pub struct OcclusionTexture(pub CachedTexture);

impl OcclusionTexture {
    pub(super) fn bytes(&self) -> u64 {
        texture_bytes(&self.0.texture)
    }
}

/// Creates the occlusion textures of active views, and gives lighting those that it reads: as [`AmbientOcclusion`]. A
/// texture is kept while its size and usage stay the same.
pub(super) fn prepare_occlusion_textures(
    mut commands: Commands,
    render_device: Res<RenderDevice>,
    mut memory: ResMut<OutOfMemory>,
    mut views: Query<(
        Entity,
        &ActiveOcclusion,
        &ViewOcclusion,
        Option<&OcclusionTexture>,
        Option<&mut AmbientOcclusion>,
    )>,
) {
    for (entity, active, view, current, given) in &mut views {
        let usage = match active.gather {
            Some(GatherPipeline::Compute(_)) => TextureUsages::STORAGE_BINDING,
            Some(GatherPipeline::Raster(_)) => TextureUsages::RENDER_ATTACHMENT,
            None => {
                if current.is_some() {
                    commands
                        .entity(entity)
                        .remove::<(OcclusionTexture, AmbientOcclusion)>();
                }
                continue;
            }
        };
        let label = "lean_deferred/effects/ambient_occlusion";
        let descriptor = TextureDescriptor {
            label: Some(label),
            size: view.uniform.texture_size.to_extents(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: FORMAT,
            usage: usage | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC,
            view_formats: &[],
        };
        let is_as_asked = |texture: &Texture| {
            (texture.size(), texture.usage()) == (descriptor.size, descriptor.usage)
        };
        let texture = match current {
            Some(current) if is_as_asked(&current.0.texture) => current.clone(),
            _ => {
                let make = || render_device.create_texture(&descriptor);
                let Some(texture) = memory.fit(&render_device, entity, label, make) else {
                    commands
                        .entity(entity)
                        .remove::<(OcclusionTexture, AmbientOcclusion)>();
                    continue;
                };
                let default_view = texture.create_view(&TextureViewDescriptor::default());
                let texture = OcclusionTexture(CachedTexture {
                    texture,
                    default_view,
                });
                commands.entity(entity).insert(texture.clone());
                texture
            }
        };
        let is_read = active.merge.is_none();
        let occlusion = (view.uniform).for_lighting(&active.settings, texture.0.default_view);
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
    }
}

/// On a view with ambient occlusion: the bind groups of its passes.
#[derive(Component, Default)]
pub struct OcclusionBindings {
    pub(super) gather: CachedBindGroup,
    pub(super) merge: CachedBindGroup,
}

impl OcclusionBindings {
    /// Bind groups that are reused across frames while nothing changes.
    pub fn lasting_bind_groups(&self) -> impl Iterator<Item = &BindGroup> {
        [&self.gather, &self.merge]
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
        Option<&OcclusionTexture>,
        &ViewDepthTexture,
        Option<&GBufferTextures>,
        Option<&mut OcclusionBindings>,
    )>,
) {
    let (Some(pipelines), Some(uniforms)) = (pipelines, uniforms.0.binding()) else {
        return;
    };
    for (entity, active, texture, depth, gbuffer, bindings) in &mut views {
        let mut new = None;
        let bindings = match bindings {
            Some(bindings) => bindings.into_inner(),
            None => new.insert(OcclusionBindings::default()),
        };
        let (Some(texture), Some(_)) = (texture, active.gather) else {
            bindings.gather.clear();
            bindings.merge.clear();
            continue;
        };
        let occlusion = || texture.0.default_view.into_binding();

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
                Some(())
            });
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
