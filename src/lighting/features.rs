//! Selects the lighting pipeline of a view from its features.

use bevy::{
    camera::visibility::RenderLayers,
    light::EnvironmentMapLight,
    pbr::{
        ExtractedDirectionalLight, ExtractedPointLight, ExtractedRectLight, MeshPipeline,
        MeshPipelineKey, RenderViewLightProbes, decal::clustered::RenderClusteredDecals,
    },
    prelude::*,
};

use bitflags::bitflags;

use super::{bevy::definitions::VIEW_BITS, light_layers::LightLayers};
use crate::{
    gpu::{named::system_param, subgroups::Subgroups},
    shader_library::reconstruction::position::{ProjectionKind, projection_of},
    view::{
        ActiveLeanView, DebugView, GBufferTargets, LeanDebugView, LeanDeferred, LightCulling,
        LightingIo, LightingVariants,
    },
};

/// Pipeline key of lighting. Everything in it is compiled in or out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct LightingKey {
    /// The bits of Bevy's view key that matter to lighting.
    pub(super) view: MeshPipelineKey,
    /// The kinds of clustered lights in the scene.
    pub(super) clustered_lights: ClusteredLights,
    /// The kinds of lights of which some cast shadows with a shadow map.
    pub(super) shadow_maps: ShadowMaps,
    pub(super) projection: ProjectionKind,
    /// Never `Auto`.
    pub(super) light_culling: LightCulling,
    pub(super) rect_lights: bool,
    /// Decals, or lights with textures: they share a table.
    pub(super) decals: bool,
    /// The debug view that lighting draws.
    pub(super) debug_view: Option<DebugView>,
    pub(super) io: LightingIo,
    /// Some surfaces scatter light beneath them; lighting writes that light separately.
    pub(super) scatters: bool,
    /// Some light, decal or light probe has layers that exclude some meshes.
    pub(super) light_layers: bool,
    /// Some surfaces have lightmaps.
    pub(super) lightmaps: bool,
    /// The optional targets of the view that are read.
    pub(super) targets: GBufferTargets,
    /// The pipeline also lights views that need less, and reads what they need from the uniform.
    pub(super) is_general: bool,
    /// This dispatch over all tiles lists those with special surfaces.
    pub(super) lists: bool,
    /// The kinds of special surfaces that this dispatch lights, in the listed tiles. Empty for the dispatch over all
    /// tiles. In the key of a view: the kinds on that view.
    pub(super) shaded: LightingVariants,
}

/// Number of point and spot lights from which culling per tile is worth its cost. Figures: `docs/frame_times.md`.
pub(super) const MANY_LIGHTS: usize = 2048;

bitflags! {
    /// Kinds of point and spot lights.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub(crate) struct ClusteredLights: u8 {
        const ANY = 1 << 0;
        const SPOT = 1 << 1;
        /// Has a radius.
        const SPHERE = 1 << 2;
    }

    /// Kinds of lights that cast shadows with a shadow map.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub(crate) struct ShadowMaps: u8 {
        const DIRECTIONAL = 1 << 0;
        const POINT = 1 << 1;
        const SPOT = 1 << 2;
        /// Some of these lights have percentage-closer soft shadows (Bevy's feature `experimental_pbr_pcss`).
        const SOFT = 1 << 3;
        /// More than one directional light casts such shadows.
        const SEVERAL_DIRECTIONAL = 1 << 4;
        /// The kinds of lights.
        const OF_ANY_LIGHT = Self::DIRECTIONAL.bits() | Self::POINT.bits() | Self::SPOT.bits();
    }
}

/// The kinds of lights in the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SceneLights {
    pub(super) clustered: ClusteredLights,
    pub(super) shadow_maps: ShadowMaps,
}

impl LightingKey {
    /// The keys of all dispatches of a view with this key; the one over all tiles comes first.
    pub(crate) fn dispatches(self) -> impl Iterator<Item = Self> {
        let has_special = !self.shaded.is_empty();
        let over_all_tiles = Self {
            lists: has_special || self.is_general,
            shaded: LightingVariants::empty(),
            ..self
        };
        core::iter::once(over_all_tiles).chain(has_special.then_some(self))
    }

    pub(super) fn without_debug_view(self) -> Self {
        Self {
            debug_view: None,
            targets: self.targets & GBufferTargets::LIT,
            ..self
        }
    }

    /// Keys whose pipelines light the view as well, for frames in which those of this key are not compiled yet: for
    /// perspective views, those for any projection; with a debug view, those without.
    pub(crate) fn stand_ins(self) -> impl Iterator<Item = Self> {
        let is_perspective = self.projection == ProjectionKind::Perspective;
        let for_any_projection = is_perspective.then_some(Self {
            projection: ProjectionKind::Other,
            ..self
        });
        let without_debug_view = self.debug_view.map(|_| self.without_debug_view());
        for_any_projection.into_iter().chain(without_debug_view)
    }
}

system_param! {
    /// The features of the scene, which all views share.
    pub(crate) struct SceneFeatures<'w, 's> {
        point_lights: Query<'w, 's, &'static ExtractedPointLight>,
        directional_lights: Query<'w, 's, &'static ExtractedDirectionalLight>,
        rect_lights: Query<'w, 's, (), With<ExtractedRectLight>>,
        decals: Option<Res<'w, RenderClusteredDecals>>,
        mesh_pipeline: Option<Res<'w, MeshPipeline>>,
        light_layers: Res<'w, LightLayers>,
        subgroups: Res<'w, Subgroups>,
    }
}

impl SceneFeatures<'_, '_> {
    /// True if a view with these settings and layers must test the layers of lights.
    pub(crate) fn has_light_layers(
        &self,
        settings: &LeanDeferred,
        view_layers: Option<&RenderLayers>,
    ) -> bool {
        settings.light_layers && self.light_layers.matter_to(view_layers.unwrap_or_default())
    }

    /// Collects the kinds of lights. Iterates over all lights: call once per frame.
    pub(crate) fn lights(&self) -> SceneLights {
        let mut lights = SceneLights::default();
        for light in &self.point_lights {
            lights.clustered |= ClusteredLights::ANY;
            let mut shadow_maps = ShadowMaps::POINT;
            if light.spot_light_angles.is_some() {
                lights.clustered |= ClusteredLights::SPOT;
                shadow_maps = ShadowMaps::SPOT;
            }
            if light.radius != 0.0 {
                lights.clustered |= ClusteredLights::SPHERE;
            }
            if light.shadow_maps_enabled {
                lights.shadow_maps |= shadow_maps;
                if light.soft_shadows_enabled {
                    lights.shadow_maps |= ShadowMaps::SOFT;
                }
            }
        }
        for light in &self.directional_lights {
            if light.shadow_maps_enabled {
                if lights.shadow_maps.contains(ShadowMaps::DIRECTIONAL) {
                    lights.shadow_maps |= ShadowMaps::SEVERAL_DIRECTIONAL;
                }
                lights.shadow_maps |= ShadowMaps::DIRECTIONAL;
                if light.soft_shadow_size.is_some() {
                    lights.shadow_maps |= ShadowMaps::SOFT;
                }
            }
        }
        lights
    }

    /// The culling of at least `count` lights of these kinds.
    pub(super) fn light_culling(
        &self,
        kinds: ClusteredLights,
        count: usize,
        settings: &LeanDeferred,
    ) -> LightCulling {
        let count = || count.max(self.point_lights.iter().len());
        match settings.advanced.light_culling {
            _ if kinds.is_empty() => LightCulling::PerPixel,
            LightCulling::Auto if count() >= MANY_LIGHTS => LightCulling::SharedMemory,
            LightCulling::Auto => LightCulling::PerPixel,
            LightCulling::Subgroup if !self.subgroups.exist() => LightCulling::SharedMemory,
            culling => culling,
        }
    }

    pub(super) fn decals_are_usable(&self) -> bool {
        let pipeline = self.mesh_pipeline.as_ref();
        pipeline.is_some_and(|pipeline| pipeline.clustered_decals_are_usable)
    }

    /// The key for a view with Bevy's `view_key` and this projection, in a scene with these `lights`.
    pub(crate) fn key(
        &self,
        lights: SceneLights,
        view_key: MeshPipelineKey,
        clip_from_view: Mat4,
        settings: &LeanDeferred,
        debug_view: Option<&LeanDebugView>,
        order: &ActiveLeanView,
    ) -> LightingKey {
        let debug_view = debug_view
            .map(|view| view.shows)
            .filter(|view| view.is_of_lighting());
        let mut read_targets = GBufferTargets::LIT;
        if debug_view == Some(DebugView::Motion) {
            read_targets |= GBufferTargets::MOTION;
        }
        LightingKey {
            view: view_key & VIEW_BITS,
            clustered_lights: lights.clustered,
            shadow_maps: lights.shadow_maps,
            projection: projection_of(clip_from_view),
            light_culling: self.light_culling(lights.clustered, 0, settings),
            rect_lights: !self.rect_lights.is_empty(),
            decals: self.decals_are_usable() && self.decals.as_ref().is_some_and(|d| !d.is_empty()),
            debug_view,
            io: order.io,
            scatters: order.scatters(),
            light_layers: order.has_light_layers,
            lightmaps: order.variants.contains(LightingVariants::LIGHTMAPPED),
            targets: order.targets & read_targets,
            is_general: false,
            lists: false,
            shaded: order.variants.special(),
        }
    }
}

/// The reflection probes and environment maps of a view.
pub(super) type ViewEnvironmentMaps = RenderViewLightProbes<EnvironmentMapLight>;
