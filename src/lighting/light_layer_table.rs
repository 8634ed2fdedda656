//! Uploads the layers of lights for the lighting shader: a table per view, written when it has changed.

use bevy::{
    camera::visibility::RenderLayers,
    light::{EnvironmentMapLight, IrradianceVolume},
    pbr::{
        ExtractedDirectionalLight, ExtractedRectLight, GlobalClusterableObjectMeta,
        MAX_DIRECTIONAL_LIGHTS, MAX_RECT_LIGHTS, MAX_VIEW_LIGHT_PROBES, RenderViewLightProbes,
        decal::clustered::RenderClusteredDecals,
    },
    prelude::*,
    render::{
        render_resource::{ShaderType, StorageBuffer},
        renderer::{RenderDevice, RenderQueue},
        sync_world::MainEntity,
    },
};

use super::{
    ViewLighting,
    features::ViewEnvironmentMaps,
    light_layers::{ALL, LightKind, LightLayers},
};
use crate::{gpu::named::system_param, view::ActiveLeanView};

/// The visibility masks of lights, light probes and decals, at the index by which Bevy's shaders know each.
#[derive(ShaderType, Reflect, Clone, Debug, PartialEq)]
#[reflect(no_auto_register)]
pub struct LightLayersTable {
    directional_lights: [u32; MAX_DIRECTIONAL_LIGHTS],
    rect_lights: [u32; MAX_RECT_LIGHTS],
    reflection_probes: [u32; MAX_VIEW_LIGHT_PROBES],
    irradiance_volumes: [u32; MAX_VIEW_LIGHT_PROBES],
    /// Length of `clustered`. The buffer may be longer: it does not shrink.
    clustered_count: u32,
    #[shader(size(runtime))]
    clustered: Vec<UVec2>,
}

impl Default for LightLayersTable {
    fn default() -> Self {
        Self {
            directional_lights: [ALL; MAX_DIRECTIONAL_LIGHTS],
            rect_lights: [ALL; MAX_RECT_LIGHTS],
            reflection_probes: [ALL; MAX_VIEW_LIGHT_PROBES],
            irradiance_volumes: [ALL; MAX_VIEW_LIGHT_PROBES],
            clustered_count: 0,
            // A runtime-sized array needs at least one element.
            clustered: vec![UVec2::splat(ALL)],
        }
    }
}

impl LightLayersTable {
    fn clear(&mut self) {
        let mut clustered = core::mem::take(&mut self.clustered);
        clustered.clear();
        clustered.push(UVec2::splat(ALL));
        *self = Self {
            clustered,
            ..default()
        };
    }

    /// The masks at `index` of the clustered lights and decals.
    fn clustered_at(&mut self, index: usize) -> &mut UVec2 {
        if self.clustered.len() <= index {
            self.clustered.resize(index + 1, UVec2::splat(ALL));
        }
        self.clustered_count = self.clustered_count.max(index as u32 + 1);
        &mut self.clustered[index]
    }
}

system_param! {
    /// The lights, decals and light probes of the render world that determine their indices in Bevy's buffers.
    pub(super) struct PlacedLights<'w, 's> {
        layers: Res<'w, LightLayers>,
        clustered: Res<'w, GlobalClusterableObjectMeta>,
        decals: Option<Res<'w, RenderClusteredDecals>>,
        directional_lights: Query<
            'w,
            's,
            (
                Entity,
                &'static MainEntity,
                &'static ExtractedDirectionalLight,
                &'static RenderLayers,
            ),
        >,
        // Same query as Bevy's, so that its items come in the same order.
        rect_lights: Query<
            'w,
            's,
            (
                Entity,
                &'static MainEntity,
                &'static ExtractedRectLight,
                &'static RenderLayers,
            ),
        >,
    }
}

impl PlacedLights<'_, '_> {
    /// Fills in the masks that all views share.
    fn fill_common(&self, table: &mut LightLayersTable) {
        table.clear();
        for (entity, mask, kind) in self.layers.masks() {
            // Bevy keeps the indices of lights and decals in one map, although they refer to two buffers, and the
            // textures of lights in the list of decals.
            match kind {
                LightKind::Decal => {
                    let decals = self.decals.as_ref();
                    if let Some(index) = decals.and_then(|decals| decals.get(entity)) {
                        table.clustered_at(index).y = mask;
                    }
                }
                LightKind::Clustered => {
                    if let Some(index) = self.clustered.entity_to_index.get(&entity) {
                        table.clustered_at(*index).x = mask;
                    }
                }
                // Looked up by main-world entity below.
                LightKind::Other => {}
            }
        }
        for (mask, (_, light, ..)) in table.rect_lights.iter_mut().zip(&self.rect_lights) {
            *mask = self.layers.mask(light);
        }
    }

    /// The masks of a view's directional lights, in the order of Bevy's `prepare_lights`.
    fn directional_lights(&self, view_layers: &RenderLayers) -> [u32; MAX_DIRECTIONAL_LIGHTS] {
        let mut lights: Vec<_> = self
            .directional_lights
            .iter()
            .filter(|(_, _, _, layers)| layers.intersects(view_layers))
            .map(|(entity, main_entity, light, _)| {
                let place = (light.volumetric, light.shadow_maps_enabled, entity);
                (place, main_entity)
            })
            .collect();
        lights.sort_unstable_by_key(|(place, _)| *place);
        let mut masks = [ALL; MAX_DIRECTIONAL_LIGHTS];
        for (mask, (_, light)) in masks.iter_mut().zip(lights) {
            *mask = self.layers.mask(light);
        }
        masks
    }

    /// The masks of a view's probes of one kind.
    fn probes<C: bevy::pbr::LightProbeComponent>(
        &self,
        probes: Option<&RenderViewLightProbes<C>>,
    ) -> [u32; MAX_VIEW_LIGHT_PROBES] {
        let mut masks = [ALL; MAX_VIEW_LIGHT_PROBES];
        for (probe, index) in probes
            .iter()
            .flat_map(|probes| &probes.main_entity_to_render_light_probe_index)
        {
            if let Some(mask) = masks.get_mut(*index as usize) {
                *mask = self.layers.mask(probe);
            }
        }
        masks
    }
}

/// Fills the tables of views whose lighting is compiled for light layers.
pub(super) fn write_light_layers(
    lights: PlacedLights,
    (device, queue): (Res<RenderDevice>, Res<RenderQueue>),
    mut views: Query<(
        &mut ViewLighting,
        Option<&ActiveLeanView>,
        Option<&RenderLayers>,
        Option<&ViewEnvironmentMaps>,
        Option<&RenderViewLightProbes<IrradianceVolume>>,
    )>,
    mut table: Local<LightLayersTable>,
) {
    let mut has_common = false;
    for (mut lighting, active, view_layers, environment_maps, volumes) in &mut views {
        if !active.is_some_and(|active| active.has_light_layers) {
            lighting.light_layers = None;
            continue;
        }
        if !has_common {
            lights.fill_common(&mut table);
            has_common = true;
        }
        table.directional_lights = lights.directional_lights(view_layers.unwrap_or_default());
        table.reflection_probes = lights.probes::<EnvironmentMapLight>(environment_maps);
        table.irradiance_volumes = lights.probes(volumes);
        let buffer = lighting.light_layers.get_or_insert_default();
        if buffer.buffer().is_none() || *buffer.get() != *table {
            buffer.set(table.clone());
            buffer.write_buffer(&device, &queue);
        }
    }
}

/// The table of one view.
pub(super) type LightLayersBuffer = StorageBuffer<LightLayersTable>;
