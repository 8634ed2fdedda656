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
            BindGroup, BindGroupLayoutEntry, BindingResource, IntoBinding, TextureView,
            TextureViewId,
        },
        renderer::RenderDevice,
        texture::{FallbackImage, FallbackImageZero, GpuImage},
        view::{ViewDepthTexture, ViewTarget, ViewUniformOffset, ViewUniforms},
    },
};

use super::{
    ViewLighting,
    buffers::LightingBuffers,
    features::ViewEnvironmentMaps,
    pipeline::{
        AREA_LIGHT_LUTS_BINDING, BLUE_NOISE_BINDING, DFG_LUT_BINDING, LIGHT_LAYERS_BINDING,
        LightingLayouts, LightingPipelines, WRITTEN_BINDING, target_binding,
    },
};
use crate::{
    ambient_occlusion::{OcclusionPipelines, OcclusionTexture, OcclusionUniforms, ViewOcclusion},
    gbuffer::GBufferTextures,
    gpu::{
        bind_group_cache::{CachedBindGroup, Entries},
        tiles,
    },
    view::ActiveLeanView,
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
    occlusion: Option<&'static ViewOcclusion>,
    occlusion_texture: Option<&'static OcclusionTexture>,
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
    fallback_zero: Res<'w, FallbackImageZero>,
    occlusion_pipelines: Option<Res<'w, OcclusionPipelines>>,
    occlusion_uniforms: Option<Res<'w, OcclusionUniforms>>,
}

/// Makes the bind groups of the active views, where something they bind has changed.
pub(super) fn prepare_lighting_bind_groups(
    render_device: Res<RenderDevice>,
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
            &pipelines,
            &view,
            &resources,
            &render_device,
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
    pipelines: &LightingPipelines,
    view: &LitViewItem,
    resources: &LightingResources,
    device: &RenderDevice,
) -> Option<()> {
    let offsets = &mut bindings.view_offsets;
    offsets.clear();
    bindings.view.update(device, &layouts.view, |entries| {
        for layout_entry in &layouts.view.descriptor().entries {
            let (resource, offset) = view_entry(layout_entry.binding, view, resources)?;
            entries.push(layout_entry.binding, resource)?;
            offsets.extend(offset);
        }
        Some(())
    })?;

    bindings.arrays.update(device, &layouts.arrays, |entries| {
        let binds_arrays = pipelines.binds_arrays();
        for layout_entry in &layouts.arrays.descriptor().entries {
            push_array_entry(entries, layout_entry, view, resources, binds_arrays)?;
        }
        Some(())
    })?;

    if let Some(lists) = &view.lighting.tile_lists {
        let dispatches = || lists.dispatches().as_entire_binding();
        let places = || lists.lists().as_entire_binding();
        let filling = &pipelines.filling_lists;
        bindings.fill_lists.update(device, filling, |entries| {
            entries.push(0, dispatches())?;
            entries.push(1, places())
        })?;
        let reading = &pipelines.reading_lists;
        let read_lists = &mut bindings.read_lists;
        read_lists.update(device, reading, |entries| entries.push(0, places()))?;
    } else {
        bindings.fill_lists.clear();
        bindings.read_lists.clear();
    }

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
    bindings.occlusion_offset = if layouts.has_occlusion() {
        Some(view.occlusion?.offset)
    } else {
        None
    };
    for (slot, output) in bindings.targets.iter_mut().zip(outputs) {
        slot.0 = Some(output.id());
        slot.1.update(device, &layouts.targets, |entries| {
            push_target_entries(entries, layouts, view, resources, output)
        })?;
    }
    Some(())
}

/// The entries of bind group 2.
fn push_target_entries(
    entries: &mut Entries,
    layouts: &LightingLayouts,
    view: &LitViewItem,
    resources: &LightingResources,
    output: &TextureView,
) -> Option<()> {
    entries.push(0, view.gbuffer.surface.default_view.into_binding())?;
    entries.push(1, view.gbuffer.normal.default_view.into_binding())?;
    entries.push(2, output.into_binding())?;
    entries.push(3, resources.buffers.uniforms.binding()?)?;
    if layouts.has_occlusion() {
        let pipelines = resources.occlusion_pipelines.as_ref()?;
        // Without the texture, nothing that could find occlusion is compiled: there is none.
        let texture = match view.occlusion_texture {
            Some(texture) => &texture.0.default_view,
            None => &resources.fallback_zero.texture_view,
        };
        entries.push(4, resources.occlusion_uniforms.as_ref()?.0.binding()?)?;
        entries.push(5, pipelines.nearest_sampler.into_binding())?;
        entries.push(6, texture.into_binding())?;
    }
    if layouts.has_light_layers() {
        let table = view.lighting.light_layers.as_ref()?;
        entries.push(LIGHT_LAYERS_BINDING, table.binding()?)?;
    }
    if !layouts.read_targets.is_empty() {
        let written = view.gbuffer.written.as_ref()?;
        entries.push(WRITTEN_BINDING, written.default_view.into_binding())?;
    }
    for target in layouts.read_targets {
        if let Some(texture) = view.gbuffer.optional(target) {
            entries.push(target_binding(target), texture.default_view.into_binding())?;
        }
    }
    Some(())
}

/// What bind group 0 has at `binding`, and its dynamic offset if it has one.
fn view_entry<'a>(
    binding: u32,
    view: &'a LitViewItem,
    resources: &'a LightingResources,
) -> Option<(BindingResource<'a>, Option<u32>)> {
    let images = &resources.images;
    let fallback = &resources.fallback;
    let atmosphere = resources.buffers.atmosphere.as_ref();
    let mut offset = None;
    let resource = match binding {
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
    Some((resource, offset))
}

/// The next entry of bind group 1: light probes and decals. Arrays are padded to the length that the layout declares.
fn push_array_entry(
    entries: &mut Entries,
    layout: &BindGroupLayoutEntry,
    view: &LitViewItem,
    resources: &LightingResources,
    binds_arrays: bool,
) -> Option<()> {
    let maps = view
        .environment_maps
        .map_or(&[][..], |maps| &maps.binding_index_to_textures[..]);
    let volumes = view
        .irradiance_volumes
        .map_or(&[][..], |volumes| &volumes.binding_index_to_textures[..]);
    let decals = &resources.decals.binding_index_to_textures[..];
    let fallback = &resources.fallback;

    let length = layout.count.map_or(1, |count| count.get() as usize);
    let image = |id: Option<AssetId<Image>>| id.and_then(|id| resources.images.get(id));
    let mut push_textures = |is_array, id: &dyn Fn(usize) -> Option<AssetId<Image>>, fallback| {
        let texture = |i| &*image(id(i)).unwrap_or(fallback).texture_view;
        if is_array {
            entries.push_textures(layout.binding, length, texture);
            Some(())
        } else {
            entries.push(layout.binding, BindingResource::TextureView(texture(0)))
        }
    };
    // That of the first image that is loaded.
    let sampler = |ids: &mut dyn Iterator<Item = AssetId<Image>>, fallback: &GpuImage| {
        let image = ids.take(length).find_map(|id| image(Some(id)));
        image.unwrap_or(fallback).sampler.clone()
    };
    match layout.binding {
        0 => push_textures(
            binds_arrays,
            &|i| maps.get(i).map(|map| map.diffuse),
            &fallback.cube,
        ),
        1 => push_textures(
            binds_arrays,
            &|i| maps.get(i).map(|map| map.specular),
            &fallback.cube,
        ),
        2 => {
            let mut ids = maps.iter().map(|map| map.diffuse);
            let sampler = sampler(&mut ids, &fallback.cube);
            entries.push(2, sampler.into_binding())
        }
        3 => push_textures(binds_arrays, &|i| volumes.get(i).copied(), &fallback.d3),
        4 => {
            let sampler = sampler(&mut volumes.iter().copied(), &fallback.d3);
            entries.push(4, sampler.into_binding())
        }
        5 => entries.push(5, resources.decals_buffer.buffer()?.as_entire_binding()),
        6 => push_textures(true, &|i| decals.get(i).copied(), &fallback.d2),
        7 => {
            let sampler = sampler(&mut decals.iter().copied(), &fallback.d2);
            entries.push(7, sampler.into_binding())
        }
        _ => None,
    }
}
