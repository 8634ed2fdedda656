//! The layers of lights, decals and light probes: which meshes each affects.
//!
//! Bevy asks the `RenderLayers` of a light which cameras see its light, and which meshes throw its shadows, but not which
//! meshes it lights. Here it lights those that share a layer with it.

use bevy::{
    camera::visibility::RenderLayers,
    ecs::system::SystemParam,
    light::{ClusteredDecal, EnvironmentMapLight, IrradianceVolume, LightProbe, RectLight},
    pbr::{
        ExtractedDirectionalLight, ExtractedPointLight, ExtractedRectLight,
        GlobalClusterableObjectMeta, MAX_DIRECTIONAL_LIGHTS, MAX_RECT_LIGHTS,
        MAX_VIEW_LIGHT_PROBES, RenderViewLightProbes, decal::clustered::RenderClusteredDecals,
    },
    prelude::*,
    render::{
        Extract,
        render_resource::{ShaderType, StorageBuffer},
        renderer::{RenderDevice, RenderQueue},
        sync_world::{MainEntity, MainEntityHashMap},
    },
};

use super::{ViewLighting, features::ViewEnvironmentMaps};
use crate::{camera::ActiveLeanView, gbuffer::layout::visibility_mask};

/// The mask of what affects all meshes.
const ALL: u32 = !0;

/// In the render world: the lights, decals and light probes that have layers of their own.
#[derive(Resource, Default)]
pub(crate) struct LightLayers(MainEntityHashMap<LayeredLight>);

struct LayeredLight {
    layers: RenderLayers,
    /// Bevy keeps it from views that share no layer with it.
    is_culled: bool,
}

impl LightLayers {
    /// Whether some of them may affect a part only of what a view with `view_layers` sees.
    pub(super) fn matter_to(&self, view_layers: &RenderLayers) -> bool {
        self.0.values().any(|light| {
            // A light that is on all layers of the view is on one of each mesh in it.
            let shared = light.layers.intersection(view_layers);
            shared != *view_layers && !(light.is_culled && shared == RenderLayers::none())
        })
    }

    fn mask(&self, light: &MainEntity) -> u32 {
        let light = self.0.get(light);
        light.map_or(ALL, |light| visibility_mask(&light.layers))
    }
}

pub(super) fn extract_light_layers(
    mut light_layers: ResMut<LightLayers>,
    lights: Extract<
        Query<
            (
                Entity,
                &RenderLayers,
                Has<PointLight>,
                Has<SpotLight>,
                Has<DirectionalLight>,
            ),
            Or<(
                With<PointLight>,
                With<SpotLight>,
                With<DirectionalLight>,
                With<RectLight>,
                With<ClusteredDecal>,
                With<LightProbe>,
            )>,
        >,
    >,
) {
    light_layers.0.clear();
    for (entity, layers, point, spot, directional) in &lights {
        let light = LayeredLight {
            layers: layers.clone(),
            is_culled: point || spot || directional,
        };
        light_layers.0.insert(entity.into(), light);
    }
}

/// Twin of the struct of the same name in `bindings.wgsl`.
#[derive(ShaderType, Clone, Debug)]
pub(super) struct LightLayersTable {
    directional_lights: [u32; MAX_DIRECTIONAL_LIGHTS],
    rect_lights: [u32; MAX_RECT_LIGHTS],
    reflection_probes: [u32; MAX_VIEW_LIGHT_PROBES],
    irradiance_volumes: [u32; MAX_VIEW_LIGHT_PROBES],
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
            // A buffer holds one element at least.
            clustered: vec![UVec2::splat(ALL)],
        }
    }
}

impl LightLayersTable {
    /// The masks at `index` of the clustered lights and decals.
    fn clustered_at(&mut self, index: usize) -> &mut UVec2 {
        if self.clustered.len() <= index {
            self.clustered.resize(index + 1, UVec2::splat(ALL));
        }
        &mut self.clustered[index]
    }
}

/// The lights, decals and light probes of the render world, as far as their places in Bevy's buffers follow from it.
#[derive(SystemParam)]
pub(super) struct PlacedLights<'w, 's> {
    layers: Res<'w, LightLayers>,
    clustered: Res<'w, GlobalClusterableObjectMeta>,
    decals: Option<Res<'w, RenderClusteredDecals>>,
    point_lights: Query<'w, 's, (Entity, &'static MainEntity), With<ExtractedPointLight>>,
    decal_entities: Query<'w, 's, (Entity, &'static MainEntity), With<ClusteredDecal>>,
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
    // What Bevy queries, so that it comes in Bevy's order.
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

impl PlacedLights<'_, '_> {
    /// What is the same for all views.
    fn table(&self) -> LightLayersTable {
        let mut table = LightLayersTable::default();
        for (entity, light) in &self.point_lights {
            let mask = self.layers.mask(light);
            let index = self.clustered.entity_to_index.get(&entity);
            if let (true, Some(index)) = (mask != ALL, index) {
                table.clustered_at(*index).x = mask;
            }
        }
        for (entity, decal) in &self.decal_entities {
            let mask = self.layers.mask(decal);
            let index = self.decals.as_ref().and_then(|decals| decals.get(entity));
            if let (true, Some(index)) = (mask != ALL, index) {
                table.clustered_at(index).y = mask;
            }
        }
        for (mask, (_, light, ..)) in table.rect_lights.iter_mut().zip(&self.rect_lights) {
            *mask = self.layers.mask(light);
        }
        table
    }

    /// The masks of the directional lights that a view has, in the order of Bevy's `prepare_lights`.
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

    /// The masks of the probes of a view of one kind.
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

/// Fills the tables of the views whose lighting is compiled for them.
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
) {
    let mut common = None;
    for (mut lighting, active, view_layers, environment_maps, volumes) in &mut views {
        if !active.is_some_and(|active| active.has_light_layers) {
            lighting.light_layers = None;
            continue;
        }
        let mut table = common.get_or_insert_with(|| lights.table()).clone();
        table.directional_lights = lights.directional_lights(view_layers.unwrap_or_default());
        table.reflection_probes = lights.probes::<EnvironmentMapLight>(environment_maps);
        table.irradiance_volumes = lights.probes(volumes);
        let buffer = lighting.light_layers.get_or_insert_default();
        buffer.set(table);
        buffer.write_buffer(&device, &queue);
    }
}

/// The table of one view.
pub(super) type LightLayersBuffer = StorageBuffer<LightLayersTable>;
