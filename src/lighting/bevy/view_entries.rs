//! Bevy's resources that lighting binds: the view, light probes and decals.

use bevy::{
    image::Image,
    prelude::*,
    render::{
        render_resource::{BindGroupLayoutEntry, BindingResource, IntoBinding},
        texture::GpuImage,
    },
};

use super::binding_numbers::{arrays, view};
use crate::{
    gpu::bind_group_cache::Entries,
    lighting::{
        inputs::{LightingResources, LitViewItem},
        parts::LightingParts,
        placeholders::Placeholders,
    },
};

/// The part for which a view needs the resource at `binding` of bind group 0, if not all views do.
fn part_of(binding: u32) -> Option<LightingParts> {
    Some(match binding {
        view::FOG => LightingParts::DISTANCE_FOG,
        view::CONTACT_SHADOWS_SETTINGS => LightingParts::CONTACT_SHADOWS,
        view::SCREEN_SPACE_AMBIENT_OCCLUSION_TEXTURE => {
            LightingParts::SCREEN_SPACE_AMBIENT_OCCLUSION
        }
        view::ATMOSPHERE_TRANSMITTANCE_TEXTURE
        | view::ATMOSPHERE_TRANSMITTANCE_SAMPLER
        | view::ATMOSPHERE => LightingParts::ATMOSPHERE,
        _ => return None,
    })
}

/// Returns what stands in for the resource of a part at `binding` of bind group 0, with its dynamic offset. Bevy's own
/// resource may be that of a former frame: it keeps the offsets of a view whose fog or contact shadows were removed.
fn placeholder<'a>(
    binding: u32,
    resources: &'a LightingResources,
    placeholders: &'a Placeholders,
) -> (BindingResource<'a>, Option<u32>) {
    let fallback = &resources.fallback.d2;
    let zeros = &placeholders.zeros;
    match binding {
        view::ATMOSPHERE_TRANSMITTANCE_TEXTURE | view::SCREEN_SPACE_AMBIENT_OCCLUSION_TEXTURE => {
            (fallback.texture_view.into_binding(), None)
        }
        view::ATMOSPHERE_TRANSMITTANCE_SAMPLER => (fallback.sampler.into_binding(), None),
        view::ATMOSPHERE => (zeros.as_entire_binding(), None),
        _ => (zeros.as_entire_binding(), Some(0)),
    }
}

/// Returns the resource at `binding` of bind group 0, and its dynamic offset if it has one.
pub(in crate::lighting) fn view_entry<'a>(
    binding: u32,
    lit: &'a LitViewItem,
    resources: &'a LightingResources,
    placeholders: Option<&'a Placeholders>,
) -> Option<(BindingResource<'a>, Option<u32>)> {
    if part_of(binding).is_some_and(|part| !lit.needs(part)) {
        return Some(placeholder(binding, resources, placeholders?));
    }
    let images = &resources.images;
    let fallback = &resources.fallback;
    let atmosphere = resources.buffers.atmosphere.as_ref();
    let mut offset = None;
    let resource = match binding {
        view::VIEW => {
            offset = Some(lit.view_offset.offset);
            resources.view_uniforms.uniforms.binding()?
        }
        view::LIGHTS => {
            offset = Some(lit.lights_offset.offset);
            resources.lights.view_gpu_lights.binding()?
        }
        view::POINT_SHADOW_TEXTURES => lit.shadows.point_light_depth_texture_view.into_binding(),
        view::POINT_SHADOW_TEXTURES_COMPARISON_SAMPLER => resources
            .shadow_samplers
            .point_light_comparison_sampler
            .into_binding(),
        view::POINT_SHADOW_TEXTURES_LINEAR_SAMPLER
        | view::DIRECTIONAL_SHADOW_TEXTURES_LINEAR_SAMPLER => {
            resources.blocker_sampler.0.into_binding()
        }
        view::DIRECTIONAL_SHADOW_TEXTURES => lit
            .shadows
            .directional_light_depth_texture_view
            .into_binding(),
        view::DIRECTIONAL_SHADOW_TEXTURES_COMPARISON_SAMPLER => resources
            .shadow_samplers
            .directional_light_comparison_sampler
            .into_binding(),
        view::CLUSTERED_LIGHTS => resources.clustered.gpu_clustered_lights.binding()?,
        view::CLUSTERABLE_OBJECT_INDEX_LISTS => {
            lit.clusters.clusterable_object_index_lists_binding()?
        }
        view::CLUSTER_OFFSETS_AND_COUNTS => lit.clusters.offsets_and_counts_binding()?,
        view::GLOBALS => resources.globals.buffer.binding()?,
        view::LIGHT_PROBES => {
            offset = Some(**lit.probes_offset);
            resources.probes.binding()?
        }
        view::FOG => {
            offset = Some(lit.fog_offset?.offset);
            resources.fog.gpu_fogs.binding()?
        }
        view::CONTACT_SHADOWS_SETTINGS => {
            offset = Some(**lit.contact_shadows_offset?);
            resources.contact_shadows.0.binding()?
        }
        view::SCREEN_SPACE_AMBIENT_OCCLUSION_TEXTURE => lit
            .ssao?
            .screen_space_ambient_occlusion_texture
            .default_view
            .into_binding(),
        view::DEPTH_PREPASS_TEXTURE => lit.depth.view().into_binding(),
        view::ATMOSPHERE_TRANSMITTANCE_TEXTURE => lit
            .atmosphere?
            .transmittance_lut
            .default_view
            .into_binding(),
        view::ATMOSPHERE_TRANSMITTANCE_SAMPLER => {
            (***resources.atmosphere_sampler.as_ref()?).into_binding()
        }
        view::ATMOSPHERE => atmosphere?.binding()?,
        view::BLUE_NOISE_TEXTURE => images
            .get(&resources.blue_noise.texture)?
            .texture_view
            .into_binding(),
        view::AREA_LIGHT_LUTS => match images.get(&resources.area_light_luts.image) {
            Some(image) => image.texture_view.into_binding(),
            None => fallback.d2_array.texture_view.into_binding(),
        },
        view::AREA_LIGHT_LUTS_SAMPLER => match images.get(&resources.area_light_luts.image) {
            Some(image) => image.sampler.into_binding(),
            None => fallback.d2_array.sampler.into_binding(),
        },
        view::DFG_LUT => match images.get(&resources.dfg_lut.texture) {
            Some(image) => image.texture_view.into_binding(),
            None => fallback.d2.texture_view.into_binding(),
        },
        view::DFG_LUT_SAMPLER => match images.get(&resources.dfg_lut.texture) {
            Some(image) => image.sampler.into_binding(),
            None => fallback.d2.sampler.into_binding(),
        },
        _ => return None,
    };
    Some((resource, offset))
}

/// Pushes the next entry of bind group 1: light probes and decals. As in Bevy, arrays of probes are padded to the length
/// that the layout declares, as D3D12 and Metal need; those of decals, whose length may be 1,024, only if the device
/// cannot bind a part of an array (`pads_decals`).
pub(in crate::lighting) fn push_array_entry(
    entries: &mut Entries,
    layout: &BindGroupLayoutEntry,
    view: &LitViewItem,
    resources: &LightingResources,
    pads_decals: bool,
) -> Option<()> {
    let maps = view
        .environment_maps
        .map_or(&[][..], |maps| &maps.binding_index_to_textures[..]);
    let volumes = view
        .irradiance_volumes
        .map_or(&[][..], |volumes| &volumes.binding_index_to_textures[..]);
    let decals = &resources.decals.binding_index_to_textures[..];
    let fallback = &resources.fallback;

    let image = |id: Option<AssetId<Image>>| id.and_then(|id| resources.images.get(id));
    let mut push_textures =
        |count: usize, id: &dyn Fn(usize) -> Option<AssetId<Image>>, fallback| {
            let texture = |i| &*image(id(i)).unwrap_or(fallback).texture_view;
            let Some(capacity) = layout.count else {
                return entries.push(layout.binding, BindingResource::TextureView(texture(0)));
            };
            let capacity = capacity.get() as usize;
            let is_padded = pads_decals || layout.binding != arrays::CLUSTERED_DECAL_TEXTURES;
            let least = if is_padded { capacity } else { 1 };
            entries.push_textures(layout.binding, count.clamp(least, capacity), texture);
            Some(())
        };
    // The sampler of the first image that is loaded.
    let sampler = |ids: &mut dyn Iterator<Item = AssetId<Image>>, fallback: &GpuImage| {
        let image = ids.filter_map(|id| image(Some(id))).next();
        image.unwrap_or(fallback).sampler.clone()
    };
    match layout.binding {
        arrays::DIFFUSE_ENVIRONMENT_MAPS => push_textures(
            maps.len(),
            &|i| maps.get(i).map(|map| map.diffuse),
            &fallback.cube,
        ),
        arrays::SPECULAR_ENVIRONMENT_MAPS => push_textures(
            maps.len(),
            &|i| maps.get(i).map(|map| map.specular),
            &fallback.cube,
        ),
        arrays::ENVIRONMENT_MAP_SAMPLER => {
            let mut ids = maps.iter().map(|map| map.diffuse);
            let sampler = sampler(&mut ids, &fallback.cube);
            entries.push(layout.binding, sampler.into_binding())
        }
        arrays::IRRADIANCE_VOLUMES => {
            push_textures(volumes.len(), &|i| volumes.get(i).copied(), &fallback.d3)
        }
        arrays::IRRADIANCE_VOLUME_SAMPLER => {
            let sampler = sampler(&mut volumes.iter().copied(), &fallback.d3);
            entries.push(layout.binding, sampler.into_binding())
        }
        arrays::CLUSTERED_DECALS => entries.push(
            layout.binding,
            resources.decals_buffer.buffer()?.as_entire_binding(),
        ),
        arrays::CLUSTERED_DECAL_TEXTURES => {
            push_textures(decals.len(), &|i| decals.get(i).copied(), &fallback.d2)
        }
        arrays::CLUSTERED_DECAL_SAMPLER => {
            let sampler = sampler(&mut decals.iter().copied(), &fallback.d2);
            entries.push(layout.binding, sampler.into_binding())
        }
        _ => None,
    }
}
