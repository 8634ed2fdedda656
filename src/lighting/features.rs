//! What a view has to be lit with.

use bevy::{
    camera::visibility::RenderLayers,
    ecs::system::SystemParam,
    light::EnvironmentMapLight,
    pbr::{
        ExtractedDirectionalLight, ExtractedPointLight, ExtractedRectLight, MeshPipeline,
        MeshPipelineKey, RenderViewLightProbes, decal::clustered::RenderClusteredDecals,
    },
    prelude::*,
};

use super::light_layers::LightLayers;
use crate::{
    ambient_occlusion::{FilterKey, LeanAmbientOcclusion, OcclusionPipelines},
    view::{
        ActiveLeanView, Demand, GBufferChannel, GBufferTargets, GeometricNormal, LeanDeferred,
        LightingVariant, LightingVariants,
    },
};

/// Which lighting pipeline a view needs. Everything in it is compiled in or out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct LightingKey {
    /// The bits of Bevy's view key that matter to lighting.
    pub(super) view: MeshPipelineKey,
    /// Some light casts shadows with a shadow map; then this finds the geometric normal.
    pub(super) shadow_maps: Option<GeometricNormal>,
    pub(super) rect_lights: bool,
    /// Decals, or lights with textures: they share a table.
    pub(super) decals: bool,
    pub(super) debug_view: Option<GBufferChannel>,
    /// Pixels without geometry are known by their depth, not by the cleared G-buffer.
    pub(super) depth_tells_geometry: bool,
    pub(super) occlusion: Option<OcclusionKey>,
    /// Some light, decal or light probe has layers that keep it from some meshes.
    pub(super) light_layers: bool,
    /// The optional targets that the view has, as far as they are read.
    pub(super) targets: GBufferTargets,
    /// The kinds of special surfaces that the view has: the plain variant lists their tiles.
    pub(super) listed: LightingVariants,
    /// The kind of surface that is lit.
    pub(super) variant: LightingVariant,
}

impl LightingKey {
    /// The keys of all dispatches, the plain one first.
    pub(crate) fn variants(self) -> impl Iterator<Item = Self> {
        core::iter::once(LightingVariant::PLAIN)
            .chain(self.listed.each())
            .map(move |variant| Self { variant, ..self })
    }
}

/// How lighting applies ambient occlusion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct OcclusionKey {
    pub(super) filter: FilterKey,
    pub(super) multibounce: bool,
    pub(super) direct_light: bool,
    pub(super) debug_view: bool,
}

impl OcclusionKey {
    fn new(settings: &LeanAmbientOcclusion) -> Option<Self> {
        settings.is_for_lighting().then(|| Self {
            filter: settings.into(),
            multibounce: settings.multibounce,
            direct_light: settings.direct_light_affect > 0.0 && !settings.debug_view,
            debug_view: settings.debug_view,
        })
    }
}

/// The bits of Bevy's view key that the lighting shader is compiled by. The rest is about how meshes are rasterised,
/// or about passes after lighting.
const VIEW_BITS: MeshPipelineKey = MeshPipelineKey::ENVIRONMENT_MAP
    .union(MeshPipelineKey::IRRADIANCE_VOLUME)
    .union(MeshPipelineKey::SCREEN_SPACE_AMBIENT_OCCLUSION)
    .union(MeshPipelineKey::CONTACT_SHADOWS)
    .union(MeshPipelineKey::DISTANCE_FOG)
    .union(MeshPipelineKey::ATMOSPHERE)
    .union(MeshPipelineKey::TEMPORAL_JITTER)
    .union(MeshPipelineKey::SHADOW_FILTER_METHOD_RESERVED_BITS)
    .union(MeshPipelineKey::VIEW_PROJECTION_RESERVED_BITS)
    .union(MeshPipelineKey::MSAA_RESERVED_BITS);

/// What the scene has, whichever view looks at it.
#[derive(SystemParam)]
pub(crate) struct SceneFeatures<'w, 's> {
    point_lights: Query<'w, 's, &'static ExtractedPointLight>,
    directional_lights: Query<'w, 's, &'static ExtractedDirectionalLight>,
    rect_lights: Query<'w, 's, (), With<ExtractedRectLight>>,
    decals: Option<Res<'w, RenderClusteredDecals>>,
    mesh_pipeline: Option<Res<'w, MeshPipeline>>,
    occlusion_pipelines: Option<Res<'w, OcclusionPipelines>>,
    light_layers: Res<'w, LightLayers>,
}

impl SceneFeatures<'_, '_> {
    /// Whether a light asks for percentage-closer soft shadows (Bevy's feature `experimental_pbr_pcss`). They take
    /// derivatives of the shadow's coordinates, which compute shaders do not have.
    pub(crate) fn has_soft_shadows(&self) -> bool {
        self.point_lights
            .iter()
            .any(|light| light.shadow_maps_enabled && light.soft_shadows_enabled)
            || self
                .directional_lights
                .iter()
                .any(|light| light.shadow_maps_enabled && light.soft_shadow_size.is_some())
    }

    /// Whether a view with these settings and layers tells lights by their layers.
    pub(crate) fn has_light_layers(
        &self,
        settings: &LeanDeferred,
        view_layers: Option<&RenderLayers>,
    ) -> bool {
        settings.light_layers && self.light_layers.matter_to(view_layers.unwrap_or_default())
    }

    /// The key for a view with Bevy's `view_key`.
    pub(crate) fn key(
        &self,
        view_key: MeshPipelineKey,
        settings: &LeanDeferred,
        occlusion: Option<&LeanAmbientOcclusion>,
        order: &ActiveLeanView,
        demand: Demand,
    ) -> LightingKey {
        let shadow_maps = self.point_lights.iter().any(|l| l.shadow_maps_enabled)
            || self
                .directional_lights
                .iter()
                .any(|l| l.shadow_maps_enabled);
        let contact_shadows = view_key.contains(MeshPipelineKey::CONTACT_SHADOWS);
        let decals_usable = self
            .mesh_pipeline
            .as_ref()
            .is_some_and(|pipeline| pipeline.clustered_decals_are_usable);
        let shows_normal = settings.debug_view == Some(GBufferChannel::GeometricNormal);
        let mut read_targets = GBufferTargets::LIT;
        if settings.debug_view == Some(GBufferChannel::Motion) {
            read_targets |= GBufferTargets::MOTION;
        }
        LightingKey {
            view: view_key & VIEW_BITS,
            shadow_maps: (shadow_maps || contact_shadows || shows_normal)
                .then_some(settings.geometric_normal),
            rect_lights: !self.rect_lights.is_empty(),
            decals: decals_usable && self.decals.as_ref().is_some_and(|d| !d.is_empty()),
            debug_view: settings.debug_view,
            depth_tells_geometry: order.depth_tells_geometry,
            occlusion: occlusion
                .filter(|_| self.occlusion_pipelines.is_some() && settings.debug_view.is_none())
                .and_then(OcclusionKey::new),
            light_layers: order.has_light_layers && settings.debug_view.is_none(),
            targets: demand.targets & read_targets,
            // Channels are shown for all surfaces alike.
            listed: if settings.debug_view.is_some() {
                LightingVariants::empty()
            } else {
                demand.variants
            },
            variant: LightingVariant::PLAIN,
        }
    }
}

/// The reflection probes and environment maps of a view.
pub(super) type ViewEnvironmentMaps = RenderViewLightProbes<EnvironmentMapLight>;
