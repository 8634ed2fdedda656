//! Bind groups of the lighting pass.

use bevy::{
    prelude::*,
    render::{
        render_resource::{IntoBinding, TextureView},
        renderer::RenderDevice,
        settings::WgpuFeatures,
    },
};

use super::{
    bevy::view_entries::{push_array_entry, view_entry},
    binding_numbers::{list, targets},
    inputs::{LightingResources, LitView, LitViewItem},
    layouts::{INDIRECT_LIGHT, LightingLayouts, target_binding},
    parts::LightingParts,
    pipeline::LightingPipelines,
    state::ViewLightingBindings,
};
use crate::{
    gpu::bind_group_cache::Entries,
    shader_library::tiles,
    view::{ActiveLeanView, LightingIo},
};

/// Updates the bind groups of the active views if a bound resource has changed.
pub(super) fn prepare_lighting_bind_groups(
    render_device: Res<RenderDevice>,
    pipelines: Res<LightingPipelines>,
    resources: LightingResources,
    mut views: Query<LitView, With<ActiveLeanView>>,
) {
    for view in &mut views {
        let mut view = LitViewItem::of(view);
        let Some(key) = view.lighting.pipelines.first().map(|(key, _)| *key) else {
            continue;
        };
        let Some(layouts) = pipelines.layouts_of(key) else {
            continue;
        };
        let tiles = tiles::count(view.lighting.bindings.viewport_size).element_product();
        view.lighting.update_tile_list(&render_device, key, tiles);
        // Taken out because other parts of the view are borrowed for the entries.
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

/// Returns `None` if a resource that the layouts need is missing.
pub(super) fn update_bind_groups(
    bindings: &mut ViewLightingBindings,
    layouts: &LightingLayouts,
    pipelines: &LightingPipelines,
    view: &LitViewItem,
    resources: &LightingResources,
    device: &RenderDevice,
) -> Option<()> {
    let placeholders = pipelines.placeholders.as_ref();
    let offsets = &mut bindings.view_offsets;
    offsets.clear();
    bindings.view.update(device, &layouts.view, |entries| {
        for layout_entry in &layouts.view.descriptor().entries {
            let (resource, offset) =
                view_entry(layout_entry.binding, view, resources, placeholders)?;
            entries.push(layout_entry.binding, resource)?;
            offsets.extend(offset);
        }
        Some(())
    })?;

    bindings.arrays.update(device, &layouts.arrays, |entries| {
        let features = device.features();
        let pads_decals = !features.contains(WgpuFeatures::PARTIALLY_BOUND_BINDING_ARRAY);
        for layout_entry in &layouts.arrays.descriptor().entries {
            push_array_entry(entries, layout_entry, view, resources, pads_decals)?;
        }
        Some(())
    })?;

    if let Some(tile_list) = &view.lighting.tile_list {
        let dispatch = || tile_list.dispatch().as_entire_binding();
        let tiles = || tile_list.list().as_entire_binding();
        let filling = &pipelines.filling_list;
        bindings.fill_list.update(device, filling, |entries| {
            entries.push(list::DISPATCH, dispatch())?;
            entries.push(list::LIST, tiles())
        })?;
        let reading = &pipelines.reading_list;
        bindings
            .read_list
            .update(device, reading, |entries| entries.push(list::LIST, tiles()))?;
    } else {
        bindings.fill_list.clear();
        bindings.read_list.clear();
    }

    let outputs = [
        view.target.main_texture_view(),
        view.target.main_texture_other_view(),
    ];
    // The textures keep their slots while they swap roles, so that neither group is recreated.
    if bindings.targets[0].0 == Some(outputs[1].id())
        || bindings.targets[1].0 == Some(outputs[0].id())
    {
        bindings.targets.swap(0, 1);
    }
    for (slot, output) in bindings.targets.iter_mut().zip(outputs) {
        slot.0 = Some(output.id());
        slot.1.update(device, &layouts.targets, |entries| {
            push_target_entries(entries, layouts, pipelines, view, resources, output)
        })?;
    }
    Some(())
}

/// The entries of bind group 2.
fn push_target_entries(
    entries: &mut Entries,
    layouts: &LightingLayouts,
    pipelines: &LightingPipelines,
    view: &LitViewItem,
    resources: &LightingResources,
    output: &TextureView,
) -> Option<()> {
    entries.push(
        targets::SURFACE_TEXTURE,
        view.gbuffer.surface.default_view.into_binding(),
    )?;
    entries.push(
        targets::NORMAL_TEXTURE,
        view.gbuffer.normal.default_view.into_binding(),
    )?;
    entries.push(targets::OUTPUT_TEXTURE, output.into_binding())?;
    entries.push(targets::UNIFORMS, resources.buffers.uniforms.binding()?)?;
    if layouts.io.contains(LightingIo::AMBIENT_OCCLUSION) {
        // Zeros mean no occlusion.
        let texture = match view.ambient_occlusion {
            Some(occlusion) => &occlusion.texture,
            None => &resources.fallback_zero.texture_view,
        };
        entries.push(
            targets::NEAREST_SAMPLER,
            pipelines.nearest_sampler.into_binding(),
        )?;
        entries.push(targets::OCCLUSION_TEXTURE, texture.into_binding())?;
    }
    let placeholders = pipelines.placeholders.as_ref();
    if layouts.has_light_layers() {
        let table = if view.needs(LightingParts::LIGHT_LAYERS) {
            view.lighting.light_layers.as_ref()?.binding()?
        } else {
            placeholders?.zeros.as_entire_binding()
        };
        entries.push(targets::LIGHT_LAYERS, table)?;
    }
    if !layouts.read_targets.is_empty() {
        let valid_mask = match &view.gbuffer.valid_mask {
            Some(texture) => &texture.default_view,
            None => &placeholders?.words.view,
        };
        entries.push(targets::VALID_MASK_TEXTURE, valid_mask.into_binding())?;
    }
    if layouts.io.contains(LightingIo::DIFFUSE_LIGHT) {
        let texture = if view.needs(LightingParts::DIFFUSE_LIGHT) {
            &view.diffuse_light?.texture.default_view
        } else {
            &placeholders?.diffuse_light.view
        };
        entries.push(targets::DIFFUSE_LIGHT_TEXTURE, texture.into_binding())?;
    }
    if layouts.scatters {
        let (light, picture, tiles) = if view.needs(LightingParts::SCATTERS_LIGHT) {
            let subsurface = view.subsurface_light?;
            (
                &subsurface.light.levels[0],
                &subsurface.picture.view,
                &subsurface.tiles,
            )
        } else {
            let scattering = placeholders?.scattering.as_ref()?;
            (
                &scattering.light.view,
                &scattering.picture.view,
                &scattering.tiles,
            )
        };
        entries.push(targets::SUBSURFACE_LIGHT_TEXTURE, light.into_binding())?;
        entries.push(targets::SUBSURFACE_PICTURE_TEXTURE, picture.into_binding())?;
        entries.push(targets::SCATTERING_TILES, tiles.as_entire_binding())?;
    }
    for (found, binding) in INDIRECT_LIGHT {
        if layouts.io.contains(found) {
            let light = view.screen_space_light(found);
            // Zeros mean no light and no occlusion.
            let light = light.unwrap_or(&resources.fallback_zero.texture_view);
            entries.push(binding, light.into_binding())?;
        }
    }
    for target in layouts.read_targets {
        let texture = match view.gbuffer.optional(target) {
            Some(texture) => &texture.default_view,
            // No pixel of the valid mask has the bit of a missing target.
            None => &placeholders?.words.view,
        };
        entries.push(target_binding(target), texture.into_binding())?;
    }
    Some(())
}
