//! The index by which Bevy's shaders know each light and decal.

use bevy::{
    camera::visibility::RenderLayers,
    pbr::{
        ExtractedDirectionalLight, ExtractedRectLight, GlobalClusterableObjectMeta,
        decal::clustered::RenderClusteredDecals,
    },
    prelude::*,
    render::sync_world::MainEntity,
};

use crate::gpu::named::system_param;

system_param! {
    /// The lights and decals of the render world that determine their indices in Bevy's buffers.
    pub(in crate::lighting) struct LightOrder<'w, 's> {
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

// Bevy keeps the indices of lights and decals in one map, although they refer to two buffers, and the textures of lights
// in the list of decals.
impl LightOrder<'_, '_> {
    /// Index of a point or spot light.
    pub(in crate::lighting) fn clustered_light(&self, light: Entity) -> Option<usize> {
        self.clustered.entity_to_index.get(&light).copied()
    }

    /// Index of a decal.
    pub(in crate::lighting) fn decal(&self, decal: Entity) -> Option<usize> {
        self.decals.as_ref()?.get(decal)
    }

    /// The rectangular lights, by index.
    pub(in crate::lighting) fn rect_lights(&self) -> impl Iterator<Item = &MainEntity> {
        self.rect_lights.iter().map(|(_, light, ..)| light)
    }

    /// The directional lights of a view by index, in the order of Bevy's `prepare_lights`.
    pub(in crate::lighting) fn directional_lights(
        &self,
        view_layers: &RenderLayers,
    ) -> impl Iterator<Item = &MainEntity> {
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
        lights.into_iter().map(|(_, light)| light)
    }
}
