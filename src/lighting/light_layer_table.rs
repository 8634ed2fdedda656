//! The layers of lights as the lighting shader reads them.

use bevy::{
    camera::visibility::RenderLayers,
    light::IrradianceVolume,
    pbr::{
        LightProbeComponent, MAX_DIRECTIONAL_LIGHTS, MAX_RECT_LIGHTS, MAX_VIEW_LIGHT_PROBES,
        RenderViewLightProbes,
    },
    prelude::*,
    render::{render_resource::ShaderType, sync_world::MainEntity},
};

use super::{
    bevy::light_order::LightOrder,
    features::ViewEnvironmentMaps,
    light_layers::{ALL, LightKind, LightLayers},
};

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

    /// Fills in the masks that all views share.
    pub(super) fn fill_common(&mut self, layers: &LightLayers, order: &LightOrder) {
        self.clear();
        for (entity, mask, kind) in layers.masks() {
            match kind {
                LightKind::Decal => {
                    if let Some(index) = order.decal(entity) {
                        self.clustered_at(index).y = mask;
                    }
                }
                LightKind::Clustered => {
                    if let Some(index) = order.clustered_light(entity) {
                        self.clustered_at(index).x = mask;
                    }
                }
                // Looked up by main-world entity below.
                LightKind::Other => {}
            }
        }
        self.rect_lights = masks_of(layers, order.rect_lights());
    }

    /// Fills in the masks of a view's own lists.
    pub(super) fn fill_of_view(
        &mut self,
        layers: &LightLayers,
        order: &LightOrder,
        view_layers: &RenderLayers,
        environment_maps: Option<&ViewEnvironmentMaps>,
        volumes: Option<&RenderViewLightProbes<IrradianceVolume>>,
    ) {
        self.directional_lights = masks_of(layers, order.directional_lights(view_layers));
        self.reflection_probes = masks_of_probes(layers, environment_maps);
        self.irradiance_volumes = masks_of_probes(layers, volumes);
    }
}

/// The masks at the indices of these `lights`. Further indices are of lights that affect all meshes.
fn masks_of<'a, const N: usize>(
    layers: &LightLayers,
    lights: impl Iterator<Item = &'a MainEntity>,
) -> [u32; N] {
    let mut masks = [ALL; N];
    for (mask, light) in masks.iter_mut().zip(lights) {
        *mask = layers.mask(light);
    }
    masks
}

/// The masks of a view's probes of one kind.
fn masks_of_probes<C: LightProbeComponent>(
    layers: &LightLayers,
    probes: Option<&RenderViewLightProbes<C>>,
) -> [u32; MAX_VIEW_LIGHT_PROBES] {
    let mut masks = [ALL; MAX_VIEW_LIGHT_PROBES];
    for (probe, index) in probes
        .iter()
        .flat_map(|probes| &probes.main_entity_to_render_light_probe_index)
    {
        if let Some(mask) = masks.get_mut(*index as usize) {
            *mask = layers.mask(probe);
        }
    }
    masks
}
