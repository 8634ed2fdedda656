//! Keys of the pipelines that fit a whole level: all lights, decals and light probes of the main world, and features that an app
//! names. For cameras that are prewarmed.

use bevy::{
    light::{
        ClusteredDecal, DirectionalLightTexture, EnvironmentMapLight, IrradianceVolume, LightProbe,
        PointLightTexture, RectLight, SpotLightTexture,
    },
    pbr::MeshPipelineKey,
    prelude::*,
    render::Extract,
};

use super::{
    features::{ClusteredLights, LightingKey, MANY_LIGHTS, SceneFeatures, SceneLights, ShadowMaps},
    pipeline::LightingPipelines,
};
use crate::view::{GBufferTargets, LeanDeferred, PrewarmFeatures};

/// In the render world, while cameras are prewarmed: the lights, decals and light probes of the main world, hidden and distant ones
/// too.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct LevelLights {
    lights: SceneLights,
    /// Number of point and spot lights.
    count: usize,
    has_rect_lights: bool,
    has_decals: bool,
    has_light_layers: bool,
    /// The key bits of light probes.
    probes: MeshPipelineKey,
    /// Key bits of the camera.
    of_camera: MeshPipelineKey,
}

impl LevelLights {
    fn add_clustered(&mut self, radius: f32, casts: bool, kind: ClusteredLights) {
        let is_spot = kind.contains(ClusteredLights::SPOT);
        self.count += 1;
        self.lights.clustered |= kind | ClusteredLights::ANY;
        if radius != 0.0 {
            self.lights.clustered |= ClusteredLights::SPHERE;
        }
        if casts {
            self.lights.shadow_maps |= if is_spot {
                ShadowMaps::SPOT
            } else {
                ShadowMaps::POINT
            };
        }
    }

    /// With features that an app names.
    fn with(mut self, features: PrewarmFeatures) -> Self {
        let has = |feature| features.contains(feature);
        let clustered = PrewarmFeatures::POINT_LIGHTS
            | PrewarmFeatures::SPOT_LIGHTS
            | PrewarmFeatures::SPHERE_LIGHTS
            | PrewarmFeatures::MANY_LIGHTS
            | PrewarmFeatures::POINT_SHADOWS
            | PrewarmFeatures::SPOT_SHADOWS;
        let spot = PrewarmFeatures::SPOT_LIGHTS | PrewarmFeatures::SPOT_SHADOWS;
        for (is_there, kind) in [
            (features.intersects(clustered), ClusteredLights::ANY),
            (features.intersects(spot), ClusteredLights::SPOT),
            (has(PrewarmFeatures::SPHERE_LIGHTS), ClusteredLights::SPHERE),
        ] {
            self.lights
                .clustered
                .set(kind, is_there || self.lights.clustered.contains(kind));
        }
        for (feature, kind) in [
            (
                PrewarmFeatures::DIRECTIONAL_SHADOWS,
                ShadowMaps::DIRECTIONAL,
            ),
            (PrewarmFeatures::POINT_SHADOWS, ShadowMaps::POINT),
            (PrewarmFeatures::SPOT_SHADOWS, ShadowMaps::SPOT),
            (PrewarmFeatures::SOFT_SHADOWS, ShadowMaps::SOFT),
        ] {
            self.lights
                .shadow_maps
                .set(kind, has(feature) || self.lights.shadow_maps.contains(kind));
        }
        if has(PrewarmFeatures::MANY_LIGHTS) {
            self.count = self.count.max(MANY_LIGHTS);
        }
        self.has_rect_lights |= has(PrewarmFeatures::RECT_LIGHTS);
        self.has_decals |= has(PrewarmFeatures::DECALS);
        let of_probes = [
            (
                PrewarmFeatures::ENVIRONMENT_MAPS,
                MeshPipelineKey::ENVIRONMENT_MAP,
            ),
            (
                PrewarmFeatures::IRRADIANCE_VOLUMES,
                MeshPipelineKey::IRRADIANCE_VOLUME,
            ),
        ];
        let of_camera = [
            (
                PrewarmFeatures::CONTACT_SHADOWS,
                MeshPipelineKey::CONTACT_SHADOWS,
            ),
            (PrewarmFeatures::FOG, MeshPipelineKey::DISTANCE_FOG),
            (PrewarmFeatures::ATMOSPHERE, MeshPipelineKey::ATMOSPHERE),
        ];
        let bits = |table: &[(PrewarmFeatures, MeshPipelineKey)]| -> MeshPipelineKey {
            let named = table.iter().filter(|(feature, _)| has(*feature));
            named.map(|(_, bit)| *bit).collect()
        };
        self.probes |= bits(&of_probes);
        self.of_camera |= bits(&of_camera);
        self.has_light_layers |= has(PrewarmFeatures::LIGHT_LAYERS);
        self
    }
}

/// Collects them, and forgets those of the last frame.
pub(super) fn extract_level_lights(
    mut level: ResMut<LevelLights>,
    points: Extract<Query<&PointLight>>,
    spots: Extract<Query<&SpotLight>>,
    suns: Extract<Query<&DirectionalLight>>,
    rect_lights: Extract<Query<(), With<RectLight>>>,
    decals: Extract<
        Query<
            (),
            Or<(
                With<ClusteredDecal>,
                With<PointLightTexture>,
                With<SpotLightTexture>,
                With<DirectionalLightTexture>,
            )>,
        >,
    >,
    environment_maps: Extract<Query<(), (With<LightProbe>, With<EnvironmentMapLight>)>>,
    irradiance_volumes: Extract<Query<(), With<IrradianceVolume>>>,
) {
    let mut found = LevelLights::default();
    for light in &points {
        found.add_clustered(
            light.radius,
            light.shadow_maps_enabled,
            ClusteredLights::ANY,
        );
    }
    for light in &spots {
        found.add_clustered(
            light.radius,
            light.shadow_maps_enabled,
            ClusteredLights::SPOT,
        );
    }
    let casting_suns = suns
        .iter()
        .filter(|light| light.shadow_maps_enabled)
        .count();
    let shadow_maps = &mut found.lights.shadow_maps;
    shadow_maps.set(ShadowMaps::DIRECTIONAL, casting_suns > 0);
    shadow_maps.set(ShadowMaps::SEVERAL_DIRECTIONAL, casting_suns > 1);
    found.has_rect_lights = !rect_lights.is_empty();
    found.has_decals = !decals.is_empty();
    let probes = &mut found.probes;
    probes.set(
        MeshPipelineKey::ENVIRONMENT_MAP,
        !environment_maps.is_empty(),
    );
    probes.set(
        MeshPipelineKey::IRRADIANCE_VOLUME,
        !irradiance_volumes.is_empty(),
    );
    *level = found;
}

/// Forgets the levels of cameras that were despawned.
pub(super) fn forget_levels(
    pipelines: Option<ResMut<LightingPipelines>>,
    mut despawned: Extract<RemovedComponents<Camera>>,
) {
    let Some(mut pipelines) = pipelines else {
        return;
    };
    for camera in despawned.read() {
        pipelines.forget_level(camera.into());
    }
}

impl SceneFeatures<'_, '_> {
    /// The keys of views of a level: with what a view has `now`, all lights of the level, and each of these sets of features; with
    /// and without its light probes, which reach some views only.
    pub(crate) fn level_keys(
        &self,
        now: LightingKey,
        level: &LevelLights,
        features: &[PrewarmFeatures],
        settings: &LeanDeferred,
    ) -> Vec<LightingKey> {
        let mut keys = Vec::new();
        let sets = core::iter::once(PrewarmFeatures::empty()).chain(features.iter().copied());
        for level in sets.map(|features| level.with(features)) {
            for probes in [level.probes, MeshPipelineKey::empty()] {
                let key = self.level_key(now, LevelLights { probes, ..level }, settings);
                if !keys.contains(&key) {
                    keys.push(key);
                }
            }
        }
        keys
    }

    fn level_key(
        &self,
        now: LightingKey,
        level: LevelLights,
        settings: &LeanDeferred,
    ) -> LightingKey {
        let view = now.view | level.probes | level.of_camera;
        let clustered_lights = now.clustered_lights | level.lights.clustered;
        let light_layers = now.light_layers || level.has_light_layers;
        let mut targets = now.targets;
        if !light_layers {
            targets.remove(GBufferTargets::VISIBILITY_MASK);
        }
        LightingKey {
            view,
            clustered_lights,
            shadow_maps: now.shadow_maps | level.lights.shadow_maps,
            light_culling: self.light_culling(clustered_lights, level.count, settings),
            rect_lights: now.rect_lights || level.has_rect_lights,
            decals: now.decals || (level.has_decals && self.decals_are_usable()),
            debug_view: None,
            light_layers,
            targets,
            ..now
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn named_features_bring_what_they_need() {
        let level = LevelLights::default();
        assert_eq!(level.with(PrewarmFeatures::empty()), level);
        let with = level.with(PrewarmFeatures::SPOT_SHADOWS | PrewarmFeatures::FOG);
        assert_eq!(
            with.lights.clustered,
            ClusteredLights::ANY | ClusteredLights::SPOT
        );
        assert_eq!(with.lights.shadow_maps, ShadowMaps::SPOT);
        assert_eq!(with.of_camera, MeshPipelineKey::DISTANCE_FOG);
        let both = with.with(PrewarmFeatures::MANY_LIGHTS | PrewarmFeatures::ENVIRONMENT_MAPS);
        assert_eq!(both.lights, with.lights);
        assert_eq!(both.probes, MeshPipelineKey::ENVIRONMENT_MAP);
        assert_eq!(both.count, MANY_LIGHTS);
    }
}
