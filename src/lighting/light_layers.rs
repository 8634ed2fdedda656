//! Tracks the layers of lights, decals and light probes, which limit the meshes that each affects.
//!
//! In Bevy, the `RenderLayers` of a light select the cameras that see its light and the meshes that cast its shadows,
//! but not the meshes that it lights. Here it lights meshes that share a layer with it.

use core::mem::replace;
use std::collections::BTreeMap;

use bevy::{
    camera::visibility::RenderLayers,
    ecs::{entity_disabling::Disabled, system::SystemParam},
    light::{ClusteredDecal, LightProbe, RectLight},
    prelude::*,
    render::{
        Extract,
        sync_world::{MainEntity, MainEntityHashMap, RenderEntity},
    },
};

use crate::{shader_library::layout::visibility_mask, view::LeanDeferred};

/// The mask of lights that affect all meshes.
pub(super) const ALL: u32 = !0;

/// In the render world: the lights, decals and light probes with layers of their own.
#[derive(Resource, Default)]
pub(crate) struct LightLayers {
    by_light: MainEntityHashMap<LayeredLight>,
    /// Number of lights per set of layers. There are few sets, however many lights there are.
    sets: BTreeMap<LayerSet, usize>,
}

#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
struct LayerSet {
    layers: RenderLayers,
    /// Bevy culls the light from views that share no layer with it.
    is_culled: bool,
}

struct LayeredLight {
    set: LayerSet,
    mask: u32,
    /// `None` for irradiance volumes.
    render_entity: Option<Entity>,
    kind: LightKind,
}

/// Bevy's list in which a light has an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LightKind {
    /// Point and spot lights.
    Clustered,
    /// Decals. An entity that is a light too counts as a decal: of its two indices Bevy keeps that of the decal.
    Decal,
    Other,
}

impl LightLayers {
    /// True if some light may affect only a part of the meshes that a view with `view_layers` sees.
    pub(super) fn matter_to(&self, view_layers: &RenderLayers) -> bool {
        self.sets.keys().any(|LayerSet { layers, is_culled }| {
            // A light on all layers of the view shares one with each mesh in it.
            let shared = layers.intersection(view_layers);
            shared != *view_layers && !(*is_culled && shared == RenderLayers::none())
        })
    }

    pub(super) fn mask(&self, light: &MainEntity) -> u32 {
        self.by_light.get(light).map_or(ALL, |light| light.mask)
    }

    /// Render-world entity, mask and kind of each light that has such an entity.
    pub(super) fn masks(&self) -> impl Iterator<Item = (Entity, u32, LightKind)> {
        let lights = self.by_light.values();
        lights.filter_map(|light| Some((light.render_entity?, light.mask, light.kind)))
    }

    fn insert(&mut self, light: MainEntity, layered: LayeredLight) {
        self.remove(light);
        *self.sets.entry(layered.set.clone()).or_default() += 1;
        self.by_light.insert(light, layered);
    }

    fn remove(&mut self, light: MainEntity) {
        let Some(LayeredLight { set, .. }) = self.by_light.remove(&light) else {
            return;
        };
        if let Some(count) = self.sets.get_mut(&set) {
            *count -= 1;
            if *count == 0 {
                self.sets.remove(&set);
            }
        }
    }
}

type AnyLight = Or<(
    With<PointLight>,
    With<SpotLight>,
    With<DirectionalLight>,
    With<RectLight>,
    With<ClusteredDecal>,
    With<LightProbe>,
)>;

type ChangedLight = Or<(
    Changed<RenderLayers>,
    Changed<RenderEntity>,
    Added<PointLight>,
    Added<SpotLight>,
    Added<DirectionalLight>,
    Added<RectLight>,
    Added<ClusteredDecal>,
    Added<LightProbe>,
)>;

type LightQuery<'w, 's, Filter> = Query<
    'w,
    's,
    (
        Entity,
        Option<RenderEntity>,
        &'static RenderLayers,
        (Has<PointLight>, Has<SpotLight>, Has<DirectionalLight>),
        Has<ClusteredDecal>,
    ),
    (AnyLight, Filter),
>;

/// Lights that lost their layers or a component that made them lights, and entities that were enabled again: queries
/// skip disabled entities and miss their changes.
#[derive(SystemParam)]
pub(super) struct FormerLights<'w, 's> {
    layers: RemovedComponents<'w, 's, RenderLayers>,
    point: RemovedComponents<'w, 's, PointLight>,
    spot: RemovedComponents<'w, 's, SpotLight>,
    directional: RemovedComponents<'w, 's, DirectionalLight>,
    rect: RemovedComponents<'w, 's, RectLight>,
    decal: RemovedComponents<'w, 's, ClusteredDecal>,
    probe: RemovedComponents<'w, 's, LightProbe>,
    enabled: RemovedComponents<'w, 's, Disabled>,
}

impl FormerLights<'_, '_> {
    fn read(&mut self) -> impl Iterator<Item = Entity> {
        let Self {
            layers,
            point,
            spot,
            directional,
            rect,
            decal,
            probe,
            enabled,
        } = self;
        (layers.read())
            .chain(point.read())
            .chain(spot.read())
            .chain(directional.read())
            .chain(rect.read())
            .chain(decal.read())
            .chain(probe.read())
            .chain(enabled.read())
    }
}

/// Tracks changes; idle without lean cameras.
pub(super) fn extract_light_layers(
    mut light_layers: ResMut<LightLayers>,
    lean_cameras: Extract<Query<(), With<LeanDeferred>>>,
    changed: Extract<LightQuery<ChangedLight>>,
    all: Extract<LightQuery<()>>,
    mut former: Extract<FormerLights>,
    mut former_lights: Local<Vec<Entity>>,
    mut is_following: Local<bool>,
) {
    let was_following = replace(&mut *is_following, !lean_cameras.is_empty());
    if !*is_following {
        if was_following {
            *light_layers = default();
        }
        return;
    }
    former_lights.clear();
    former_lights.extend(former.read());
    for light in &*former_lights {
        light_layers.remove((*light).into());
    }
    // With their remaining components they may still be lights.
    let remaining = former_lights
        .iter()
        .filter_map(|light| all.get(*light).ok());
    let not_followed = (!was_following).then(|| all.iter());
    for (entity, render_entity, layers, (point, spot, directional), is_decal) in (changed.iter())
        .chain(remaining)
        .chain(not_followed.into_iter().flatten())
    {
        light_layers.insert(
            entity.into(),
            LayeredLight {
                set: LayerSet {
                    layers: layers.clone(),
                    is_culled: point || spot || directional,
                },
                mask: visibility_mask(layers),
                render_entity,
                kind: match (is_decal, point || spot) {
                    (true, _) => LightKind::Decal,
                    (false, true) => LightKind::Clustered,
                    (false, false) => LightKind::Other,
                },
            },
        );
    }
}
