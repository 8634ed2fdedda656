//! Bind groups of the lighting pass.

use bevy::{
    ecs::{query::QueryData, system::SystemParam},
    image::Image,
    light::IrradianceVolume,
    pbr::{
        AreaLightLuts, Bluenoise, DfgLut, FogMeta, GlobalClusterableObjectMeta, LightMeta,
        LightProbesBuffer, RenderViewLightProbes, ScreenSpaceAmbientOcclusionResources,
        ShadowSamplers, ViewClusterBindings, ViewContactShadowsUniformOffset, ViewFogUniformOffset,
        ViewLightProbesUniformOffset, ViewLightsUniformOffset, ViewShadowBindings,
        contact_shadows::ContactShadowsBuffer,
        decal::clustered::{DecalsBuffer, RenderClusteredDecals},
        resources::{AtmosphereSampler, AtmosphereTextures},
    },
    prelude::*,
    render::{
        globals::GlobalsBuffer,
        render_asset::RenderAssets,
        render_resource::{
            BindGroup, BindGroupEntry, BindGroupLayoutDescriptor, BindingResource, IntoBinding,
            PipelineCache, TextureView, TextureViewId,
        },
        renderer::RenderDevice,
        texture::{FallbackImage, GpuImage},
        view::{ViewDepthTexture, ViewTarget, ViewUniformOffset, ViewUniforms},
    },
};

use super::{
    ViewLighting,
    buffers::LightingBuffers,
    features::ViewEnvironmentMaps,
    pipeline::{
        AREA_LIGHT_LUTS_BINDING, BLUE_NOISE_BINDING, DFG_LUT_BINDING, LIGHT_LAYERS_BINDING,
        LightingLayouts, LightingPipelines, target_binding,
    },
    tile_lists::{filling_layout, reading_layout},
};
use crate::{
    ambient_occlusion::{OcclusionPipelines, OcclusionTexture, OcclusionUniforms, ViewOcclusion},
    bind_group_cache::CachedBindGroup,
    camera::ActiveLeanView,
    gbuffer::GBufferTextures,
    tiles,
};

/// The bind groups of one view, and what the dispatch needs beside them.
#[derive(Default)]
pub(super) struct ViewLightingBindings {
    pub(super) view: CachedBindGroup,
    pub(super) view_offsets: Vec<u32>,
    pub(super) arrays: CachedBindGroup,
    /// Post-processing swaps the two main textures, also between cameras of one target: there is a group for each.
    targets: [(Option<TextureViewId>, CachedBindGroup); 2],
    /// The lists of tiles, to be filled and to be read. Empty where there are no special surfaces.
    pub(super) fill_lists: CachedBindGroup,
    pub(super) read_lists: CachedBindGroup,
    /// Offsets of the uniform without and with `writes_background`.
    pub(super) uniform_offsets: [u32; 2],
    /// Offset of the view's uniform of ambient occlusion, if lighting applies that.
    pub(super) occlusion_offset: Option<u32>,
    pub(super) viewport_size: UVec2,
    /// The viewport is the whole render target.
    pub(super) covers_target: bool,
}

impl ViewLightingBindings {
    /// The group that writes into `main_texture`.
    pub(super) fn targets_for(&self, main_texture: &TextureView) -> Option<&BindGroup> {
        self.targets
            .iter()
            .find(|(id, _)| *id == Some(main_texture.id()))
            .and_then(|(_, group)| group.get())
    }

    /// All but that of the view.
    pub(super) fn lasting(&self) -> impl Iterator<Item = &BindGroup> {
        let targets = self.targets.iter().map(|(_, group)| group);
        [&self.arrays, &self.fill_lists, &self.read_lists]
            .into_iter()
            .chain(targets)
            .filter_map(CachedBindGroup::get)
    }

    fn clear(&mut self) {
        self.view.clear();
        self.arrays.clear();
        self.targets = default();
        self.fill_lists.clear();
        self.read_lists.clear();
    }
}

/// What lighting reads of a view.
#[derive(QueryData)]
#[query_data(mutable)]
pub(super) struct LitView {
    lighting: &'static mut ViewLighting,
    gbuffer: &'static GBufferTextures,
    depth: &'static ViewDepthTexture,
    target: &'static ViewTarget,
    shadows: &'static ViewShadowBindings,
    clusters: &'static ViewClusterBindings,
    ssao: Option<&'static ScreenSpaceAmbientOcclusionResources>,
    occlusion: Option<(&'static OcclusionTexture, &'static ViewOcclusion)>,
    atmosphere: Option<&'static AtmosphereTextures>,
    environment_maps: Option<&'static ViewEnvironmentMaps>,
    irradiance_volumes: Option<&'static RenderViewLightProbes<IrradianceVolume>>,
    view_offset: &'static ViewUniformOffset,
    lights_offset: &'static ViewLightsUniformOffset,
    probes_offset: &'static ViewLightProbesUniformOffset,
    fog_offset: Option<&'static ViewFogUniformOffset>,
    contact_shadows_offset: Option<&'static ViewContactShadowsUniformOffset>,
}

/// What lighting reads of the scene.
#[derive(SystemParam)]
pub(super) struct LightingResources<'w> {
    buffers: Res<'w, LightingBuffers>,
    view_uniforms: Res<'w, ViewUniforms>,
    lights: Res<'w, LightMeta>,
    shadow_samplers: Res<'w, ShadowSamplers>,
    clustered: Res<'w, GlobalClusterableObjectMeta>,
    globals: Res<'w, GlobalsBuffer>,
    probes: Res<'w, LightProbesBuffer>,
    fog: Res<'w, FogMeta>,
    contact_shadows: Res<'w, ContactShadowsBuffer>,
    atmosphere_sampler: Option<Res<'w, AtmosphereSampler>>,
    blue_noise: Res<'w, Bluenoise>,
    area_light_luts: Res<'w, AreaLightLuts>,
    dfg_lut: Res<'w, DfgLut>,
    decals_buffer: Res<'w, DecalsBuffer>,
    decals: Res<'w, RenderClusteredDecals>,
    images: Res<'w, RenderAssets<GpuImage>>,
    fallback: Res<'w, FallbackImage>,
    occlusion_pipelines: Option<Res<'w, OcclusionPipelines>>,
    occlusion_uniforms: Option<Res<'w, OcclusionUniforms>>,
}

/// Makes the bind groups of the active views, where something they bind has changed.
pub(super) fn prepare_lighting_bind_groups(
    render_device: Res<RenderDevice>,
    pipeline_cache: Res<PipelineCache>,
    pipelines: Res<LightingPipelines>,
    resources: LightingResources,
    mut views: Query<LitView, With<ActiveLeanView>>,
) {
    for mut view in &mut views {
        let Some(key) = view.lighting.pipelines.first().map(|(key, _)| *key) else {
            continue;
        };
        let Some(layouts) = pipelines.layouts_of(key) else {
            continue;
        };
        let tiles = tiles::count(view.lighting.bindings.viewport_size).element_product();
        view.lighting.update_tile_lists(&render_device, key, tiles);
        // Out of the view while its other parts are borrowed for the entries.
        let mut bindings = core::mem::take(&mut view.lighting.bindings);
        let complete = update_bind_groups(
            &mut bindings,
            layouts,
            &view,
            &resources,
            &render_device,
            &pipeline_cache,
            pipelines.binds_arrays(),
        );
        if complete.is_none() {
            bindings.clear();
        }
        view.lighting.bindings = bindings;
    }
}

/// `None` if something that the layouts ask for is not there.
fn update_bind_groups(
    bindings: &mut ViewLightingBindings,
    layouts: &LightingLayouts,
    view: &LitViewItem,
    resources: &LightingResources,
    device: &RenderDevice,
    pipeline_cache: &PipelineCache,
    binds_arrays: bool,
) -> Option<()> {
    let (entries, offsets) = view_entries(layouts, view, resources)?;
    bindings
        .view
        .update(device, pipeline_cache, &layouts.view, &entries);
    bindings.view_offsets = offsets;

    let arrays = ProbeAndDecalViews::new(&layouts.arrays, view, resources);
    let entries = arrays.entries(&layouts.arrays, resources, binds_arrays)?;
    bindings
        .arrays
        .update(device, pipeline_cache, &layouts.arrays, &entries);

    if let Some(lists) = &view.lighting.tile_lists {
        let entries = [
            (0, lists.dispatches().as_entire_binding()),
            (1, lists.lists().as_entire_binding()),
        ];
        let [filled, read] = [&entries[..], &[(0, entries[1].1.clone())]].map(group_entries);
        let (fill, reading) = (filling_layout(), reading_layout());
        bindings
            .fill_lists
            .update(device, pipeline_cache, &fill, &filled);
        bindings
            .read_lists
            .update(device, pipeline_cache, &reading, &read);
    } else {
        bindings.fill_lists.clear();
        bindings.read_lists.clear();
    }

    let uniforms = resources.buffers.uniforms.binding()?;
    let outputs = [
        view.target.main_texture_view(),
        view.target.main_texture_other_view(),
    ];
    // The textures keep their slots while they swap roles, so that neither group is made anew.
    if bindings.targets[0].0 == Some(outputs[1].id())
        || bindings.targets[1].0 == Some(outputs[0].id())
    {
        bindings.targets.swap(0, 1);
    }
    let occlusion = occlusion_entries(layouts, view, resources)?;
    bindings.occlusion_offset = view
        .occlusion
        .filter(|_| !occlusion.is_empty())
        .map(|(_, view)| view.offset);
    for (slot, output) in bindings.targets.iter_mut().zip(outputs) {
        let mut entries = vec![
            (0, view.gbuffer.surface.default_view.into_binding()),
            (1, view.gbuffer.normal.default_view.into_binding()),
            (2, output.into_binding()),
            (3, uniforms.clone()),
        ];
        entries.extend_from_slice(&occlusion);
        if layouts.has_light_layers() {
            let table = view.lighting.light_layers.as_ref()?;
            entries.push((LIGHT_LAYERS_BINDING, table.binding()?));
        }
        for target in layouts.read_targets {
            if let Some(texture) = view.gbuffer.optional(target) {
                let texture = texture.default_view.into_binding();
                entries.push((target_binding(target), texture));
            }
        }
        slot.0 = Some(output.id());
        slot.1.update(
            device,
            pipeline_cache,
            &layouts.targets,
            &group_entries(&entries),
        );
    }
    Some(())
}

fn group_entries<'a>(entries: &[(u32, BindingResource<'a>)]) -> Vec<BindGroupEntry<'a>> {
    entries
        .iter()
        .map(|(binding, resource)| BindGroupEntry {
            binding: *binding,
            resource: resource.clone(),
        })
        .collect()
}

/// What bind group 2 has for ambient occlusion; empty if its layout asks for none.
fn occlusion_entries<'a>(
    layouts: &LightingLayouts,
    view: &'a LitViewItem,
    resources: &'a LightingResources,
) -> Option<Vec<(u32, BindingResource<'a>)>> {
    if !layouts.has_occlusion() {
        return Some(Vec::new());
    }
    let (texture, _) = view.occlusion?;
    Some(vec![
        (4, resources.occlusion_uniforms.as_ref()?.0.binding()?),
        (
            5,
            resources
                .occlusion_pipelines
                .as_ref()?
                .nearest_sampler
                .into_binding(),
        ),
        (6, texture.0.default_view.into_binding()),
    ])
}

/// The entries of bind group 0 in the order of its layout, and the dynamic offsets in the order of the entries.
fn view_entries<'a>(
    layouts: &LightingLayouts,
    view: &'a LitViewItem,
    resources: &'a LightingResources,
) -> Option<(Vec<BindGroupEntry<'a>>, Vec<u32>)> {
    let images = &resources.images;
    let fallback = &resources.fallback;
    let atmosphere = resources.buffers.atmosphere.as_ref();
    let mut entries = Vec::with_capacity(layouts.view.entries.len());
    let mut offsets = Vec::with_capacity(5);

    for layout_entry in &layouts.view.entries {
        let mut offset = None;
        let resource = match layout_entry.binding {
            0 => {
                offset = Some(view.view_offset.offset);
                resources.view_uniforms.uniforms.binding()?
            }
            1 => {
                offset = Some(view.lights_offset.offset);
                resources.lights.view_gpu_lights.binding()?
            }
            2 => view.shadows.point_light_depth_texture_view.into_binding(),
            3 => resources
                .shadow_samplers
                .point_light_comparison_sampler
                .into_binding(),
            5 => view
                .shadows
                .directional_light_depth_texture_view
                .into_binding(),
            6 => resources
                .shadow_samplers
                .directional_light_comparison_sampler
                .into_binding(),
            8 => resources.clustered.gpu_clustered_lights.binding()?,
            9 => view.clusters.clusterable_object_index_lists_binding()?,
            10 => view.clusters.offsets_and_counts_binding()?,
            11 => resources.globals.buffer.binding()?,
            12 => {
                offset = Some(**view.probes_offset);
                resources.probes.binding()?
            }
            13 => {
                offset = Some(view.fog_offset?.offset);
                resources.fog.gpu_fogs.binding()?
            }
            16 => {
                offset = Some(**view.contact_shadows_offset?);
                resources.contact_shadows.0.binding()?
            }
            17 => view
                .ssao?
                .screen_space_ambient_occlusion_texture
                .default_view
                .into_binding(),
            20 => view.depth.view().into_binding(),
            31 => view
                .atmosphere?
                .transmittance_lut
                .default_view
                .into_binding(),
            32 => (***resources.atmosphere_sampler.as_ref()?).into_binding(),
            33 => atmosphere?.binding()?,
            BLUE_NOISE_BINDING => images
                .get(&resources.blue_noise.texture)?
                .texture_view
                .into_binding(),
            AREA_LIGHT_LUTS_BINDING => match images.get(&resources.area_light_luts.image) {
                Some(image) => image.texture_view.into_binding(),
                None => fallback.d2_array.texture_view.into_binding(),
            },
            36 => match images.get(&resources.area_light_luts.image) {
                Some(image) => image.sampler.into_binding(),
                None => fallback.d2_array.sampler.into_binding(),
            },
            DFG_LUT_BINDING => match images.get(&resources.dfg_lut.texture) {
                Some(image) => image.texture_view.into_binding(),
                None => fallback.d2.texture_view.into_binding(),
            },
            38 => match images.get(&resources.dfg_lut.texture) {
                Some(image) => image.sampler.into_binding(),
                None => fallback.d2.sampler.into_binding(),
            },
            _ => return None,
        };
        entries.push(BindGroupEntry {
            binding: layout_entry.binding,
            resource,
        });
        offsets.extend(offset);
    }
    Some((entries, offsets))
}

/// The texture views that bind group 1 binds as arrays, gathered before the entries borrow them.
struct ProbeAndDecalViews<'a> {
    diffuse: Vec<&'a wgpu::TextureView>,
    specular: Vec<&'a wgpu::TextureView>,
    environment_sampler: &'a wgpu::Sampler,
    irradiance: Vec<&'a wgpu::TextureView>,
    irradiance_sampler: &'a wgpu::Sampler,
    decals: Vec<&'a wgpu::TextureView>,
    decal_sampler: &'a wgpu::Sampler,
}

impl<'a> ProbeAndDecalViews<'a> {
    fn new(
        layout: &BindGroupLayoutDescriptor,
        view: &'a LitViewItem,
        resources: &'a LightingResources,
    ) -> Self {
        let fallback = &*resources.fallback;
        // Arrays are padded to the length that the layout declares.
        let length = |binding: u32| {
            layout
                .entries
                .iter()
                .find(|entry| entry.binding == binding)
                .and_then(|entry| entry.count)
                .map_or(1, |count| count.get() as usize)
        };
        let gather = |ids: &mut dyn Iterator<Item = AssetId<Image>>,
                      fallback: &'a GpuImage,
                      length: usize| {
            let mut views: Vec<&'a wgpu::TextureView> = Vec::with_capacity(length);
            let mut sampler = None;
            for id in ids.take(length) {
                let image = resources.images.get(id);
                sampler = sampler.or(image.map(|image| &*image.sampler));
                views.push(&image.unwrap_or(fallback).texture_view);
            }
            views.resize(length, &*fallback.texture_view);
            (views, sampler.unwrap_or(&*fallback.sampler))
        };

        let maps = view
            .environment_maps
            .map_or(&[][..], |maps| &maps.binding_index_to_textures[..]);
        let (diffuse, environment_sampler) = gather(
            &mut maps.iter().map(|map| map.diffuse),
            &fallback.cube,
            length(0),
        );
        let (specular, _) = gather(
            &mut maps.iter().map(|map| map.specular),
            &fallback.cube,
            length(1),
        );
        let volumes = view
            .irradiance_volumes
            .map_or(&[][..], |volumes| &volumes.binding_index_to_textures[..]);
        let (irradiance, irradiance_sampler) =
            gather(&mut volumes.iter().copied(), &fallback.d3, length(3));
        let (decals, decal_sampler) = gather(
            &mut resources.decals.binding_index_to_textures.iter().copied(),
            &fallback.d2,
            length(6),
        );
        Self {
            diffuse,
            specular,
            environment_sampler,
            irradiance,
            irradiance_sampler,
            decals,
            decal_sampler,
        }
    }

    fn entries<'b>(
        &'b self,
        layout: &BindGroupLayoutDescriptor,
        resources: &'b LightingResources,
        binds_arrays: bool,
    ) -> Option<Vec<BindGroupEntry<'b>>> {
        let probe = |views: &'b Vec<&'a wgpu::TextureView>| {
            if binds_arrays {
                BindingResource::TextureViewArray(views)
            } else {
                BindingResource::TextureView(views[0])
            }
        };
        layout
            .entries
            .iter()
            .map(|entry| {
                let resource = match entry.binding {
                    0 => probe(&self.diffuse),
                    1 => probe(&self.specular),
                    2 => BindingResource::Sampler(self.environment_sampler),
                    3 => probe(&self.irradiance),
                    4 => BindingResource::Sampler(self.irradiance_sampler),
                    5 => resources.decals_buffer.buffer()?.as_entire_binding(),
                    6 => BindingResource::TextureViewArray(&self.decals),
                    7 => BindingResource::Sampler(self.decal_sampler),
                    _ => return None,
                };
                Some(BindGroupEntry {
                    binding: entry.binding,
                    resource,
                })
            })
            .collect()
    }
}
