//! Views that pipelines light beside those that they fit.

use bevy::pbr::MeshPipelineKey;

use super::{
    bevy::definitions::VIEW_FLAGS,
    features::{ClusteredLights, LightingKey, ShadowMaps},
};
use crate::{
    shader_library::reconstruction::position::ProjectionKind,
    view::{GBufferTargets, LightCulling, LightingIo, LightingVariants},
};

/// The filter of shadow maps, a setting of the camera. General pipelines have all of them.
const SHADOW_FILTER: MeshPipelineKey = MeshPipelineKey::SHADOW_FILTER_METHOD_RESERVED_BITS;

/// Ambient occlusion, and all settings of its filter and its application.
pub(super) const OCCLUSION: LightingIo = LightingIo::AMBIENT_OCCLUSION
    .union(LightingIo::OCCLUSION_FILTER)
    .union(LightingIo::OCCLUSION_MULTIBOUNCE)
    .union(LightingIo::OCCLUSION_OF_DIRECT_LIGHT);

/// Light that effects exchange with lighting. The light that scatters is [`LightingKey::scatters`].
pub(super) const EXCHANGED_LIGHT: LightingIo =
    LightingIo::DIFFUSE_LIGHT.union(LightingIo::INDIRECT);

impl LightingKey {
    /// The key of general pipelines with all parts.
    pub(super) fn with_all_parts() -> Self {
        Self {
            view: VIEW_FLAGS.into_iter().collect(),
            clustered_lights: ClusteredLights::all(),
            shadow_maps: ShadowMaps::all(),
            // For lighting, shaders for any projection are those for all.
            projection: ProjectionKind::Other,
            light_culling: LightCulling::PerPixel,
            rect_lights: true,
            decals: true,
            debug_view: None,
            io: EXCHANGED_LIGHT | OCCLUSION,
            scatters: true,
            light_layers: true,
            lightmaps: true,
            targets: GBufferTargets::LIT,
            is_general: true,
            lists: false,
            shaded: LightingVariants::all_special(),
        }
    }

    /// True if pipelines for this key light a view with the key `need` too: they skip what it does not need.
    pub(crate) fn lights(self, need: Self) -> bool {
        let has_occlusion = need.io.contains(LightingIo::AMBIENT_OCCLUSION);
        // General pipelines have all settings of cameras, and are for all projections.
        let has_settings = self.is_general
            || (self.projection.covers(need.projection)
                && self.view & SHADOW_FILTER == need.view & SHADOW_FILTER
                && (!has_occlusion || self.io & OCCLUSION == need.io & OCCLUSION));
        let parts = [
            (self.rect_lights, need.rect_lights),
            (self.decals, need.decals),
            (self.scatters, need.scatters),
            (self.light_layers, need.light_layers),
            (self.lightmaps, need.lightmaps),
        ];
        has_settings
            && self.debug_view == need.debug_view
            && self.view.contains(need.view - SHADOW_FILTER)
            && self.clustered_lights.contains(need.clustered_lights)
            && self.shadow_maps.contains(need.shadow_maps)
            && self.io.contains(need.io & (EXCHANGED_LIGHT | OCCLUSION))
            && self.targets.contains(need.targets)
            && self.shaded.contains(need.shaded)
            && parts.into_iter().all(|(has, needs)| has || !needs)
    }

    /// Number of its parts: of the pipelines that light a view, those with the fewest are the fastest.
    pub(super) fn size(self) -> u32 {
        let parts = [
            self.projection == ProjectionKind::Other,
            self.rect_lights,
            self.decals,
            self.scatters,
            self.light_layers,
            self.lightmaps,
        ];
        self.view.bits().count_ones()
            + self.clustered_lights.bits().count_ones()
            + self.shadow_maps.bits().count_ones()
            + self.io.bits().count_ones()
            + self.targets.bits().count_ones()
            + self.shaded.bits().count_ones()
            + parts.map(u32::from).iter().sum::<u32>()
    }

    /// This general key for the dispatches of a view with the key `need`.
    pub(super) fn with_dispatches_of(self, need: Self) -> Self {
        let has_special = !need.shaded.is_empty();
        Self {
            shaded: if has_special {
                self.shaded
            } else {
                LightingVariants::empty()
            },
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{lighting::parts::LightingParts, view::DebugView};

    fn room() -> LightingKey {
        LightingKey::with_all_parts()
    }

    /// A view with a sun and its shadows.
    fn sun() -> LightingKey {
        LightingKey {
            view: MeshPipelineKey::SHADOW_FILTER_METHOD_GAUSSIAN,
            clustered_lights: ClusteredLights::empty(),
            shadow_maps: ShadowMaps::DIRECTIONAL,
            projection: ProjectionKind::Perspective,
            rect_lights: false,
            decals: false,
            io: LightingIo::empty(),
            scatters: false,
            light_layers: false,
            lightmaps: false,
            targets: GBufferTargets::empty(),
            is_general: false,
            shaded: LightingVariants::empty(),
            ..room()
        }
    }

    #[test]
    fn general_pipelines_light_views_that_need_less() {
        let needs = [
            sun(),
            LightingKey {
                view: sun().view | MeshPipelineKey::DISTANCE_FOG,
                clustered_lights: ClusteredLights::all(),
                shadow_maps: ShadowMaps::all(),
                projection: ProjectionKind::Orthographic,
                light_culling: LightCulling::SharedMemory,
                rect_lights: true,
                scatters: true,
                lightmaps: true,
                shaded: LightingVariants::all_special(),
                ..sun()
            },
            LightingKey {
                io: OCCLUSION | LightingIo::INDIRECT_SPECULAR,
                ..sun()
            },
        ];
        for need in needs {
            assert!(room().lights(need), "{need:?}");
        }
        let without_decals = LightingKey {
            decals: false,
            ..room()
        };
        let decals = LightingKey {
            decals: true,
            ..sun()
        };
        assert!(!without_decals.lights(decals));
    }

    #[test]
    fn general_pipelines_have_all_settings_of_cameras() {
        let other_settings = LightingKey {
            view: MeshPipelineKey::SHADOW_FILTER_METHOD_TEMPORAL,
            io: LightingIo::AMBIENT_OCCLUSION | LightingIo::OCCLUSION_HALF,
            ..sun()
        };
        assert!(room().lights(other_settings));
        let parts = other_settings.parts();
        assert!(parts.contains(LightingParts::TEMPORAL_SHADOWS | LightingParts::OCCLUSION_HALF));
        assert!(!parts.intersects(LightingParts::GAUSSIAN_SHADOWS | LightingParts::OCCLUSION_WIDE));

        let shown = LightingKey {
            debug_view: Some(DebugView::Normal),
            ..sun()
        };
        assert!(!room().lights(shown));
    }

    #[test]
    fn pipelines_go_on_for_views_that_lost_lights_or_surfaces() {
        let more = LightingKey {
            clustered_lights: ClusteredLights::all(),
            shadow_maps: ShadowMaps::DIRECTIONAL | ShadowMaps::SPOT,
            light_culling: LightCulling::SharedMemory,
            rect_lights: true,
            decals: true,
            lightmaps: true,
            targets: GBufferTargets::EMISSIVE,
            shaded: LightingVariants::all_special(),
            ..sun()
        };
        assert!(more.lights(sun()));
        assert!(more.size() > sun().size());
        assert!(!sun().lights(more));
    }

    #[test]
    fn pipelines_go_on_for_views_that_lost_other_parts() {
        let no_shadows = LightingKey {
            shadow_maps: ShadowMaps::empty(),
            ..sun()
        };
        assert!(sun().lights(no_shadows));
        let more = [
            LightingKey {
                view: sun().view | MeshPipelineKey::DISTANCE_FOG,
                ..sun()
            },
            LightingKey {
                io: OCCLUSION | LightingIo::INDIRECT_DIFFUSE,
                ..sun()
            },
            LightingKey {
                light_layers: true,
                ..sun()
            },
            LightingKey {
                scatters: true,
                ..sun()
            },
        ];
        for more in more {
            assert!(more.lights(sun()) && more.size() > sun().size(), "{more:?}");
            assert!(!sun().lights(more), "{more:?}");
        }
    }

    /// These are compiled in, and are no bits of the uniform.
    #[test]
    fn pipelines_that_fit_have_the_settings_of_one_camera() {
        let occluded = |settings| LightingKey {
            io: LightingIo::AMBIENT_OCCLUSION | settings,
            ..sun()
        };
        let [narrow, wide] = [LightingIo::empty(), LightingIo::OCCLUSION_WIDE].map(occluded);
        assert!(!narrow.lights(wide) && !wide.lights(narrow));
        assert!(wide.lights(sun()));
        let filtered = LightingKey {
            view: MeshPipelineKey::SHADOW_FILTER_METHOD_TEMPORAL,
            ..sun()
        };
        assert!(!filtered.lights(sun()) && !sun().lights(filtered));
        let [orthographic, any] =
            [ProjectionKind::Orthographic, ProjectionKind::Other].map(|projection| LightingKey {
                projection,
                ..sun()
            });
        assert!(!sun().lights(orthographic) && !any.lights(orthographic));
        assert!(any.lights(sun()));
    }

    #[test]
    fn lightmaps_are_lit_by_all_dispatches() {
        let lightmapped = LightingKey {
            lightmaps: true,
            shaded: LightingVariants::all_special(),
            ..sun()
        };
        assert!(lightmapped.dispatches().all(|key| key.lightmaps));
        assert!(room().dispatches().all(|key| key.lightmaps));
        assert!(!sun().lights(LightingKey {
            lightmaps: true,
            ..sun()
        }));
    }

    #[test]
    fn views_without_special_surfaces_have_one_dispatch() {
        let special = LightingKey {
            shaded: LightingVariants::all_special(),
            ..sun()
        };
        let general = room();
        let all: Vec<LightingKey> = general.dispatches().collect();
        let of = |need| general.with_dispatches_of(need).dispatches();
        assert!(of(sun()).eq(all[..1].iter().copied()));
        assert!(of(special).eq(all));
    }
}
