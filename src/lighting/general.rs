//! General pipelines: they light a view until the pipelines that are compiled for it are there.
//!
//! They are compiled with all parts that the device has bindings for. A uniform tells them which parts the view needs
//! (`parts.rs`), and placeholders are bound for the rest (`placeholders.rs`).

use bevy::{
    pbr::{MeshPipeline, MeshPipelineKey},
    prelude::*,
    render::{
        render_resource::{PipelineCache, TextureUsages},
        renderer::{RenderAdapter, RenderDevice},
    },
};

use super::{
    bevy::definitions::VIEW_FLAGS,
    features::{ClusteredLights, LightingKey, ShadowMaps},
    layouts::descriptors,
    pipeline::LightingPipelines,
    placeholders::Placeholders,
    subsurface_light::{SUBSURFACE_LIGHT_FORMAT, SUBSURFACE_PICTURE_FORMAT},
    tile_list::filling_layout,
};
use crate::{
    gpu::layout_limits::excess,
    shader_library::reconstruction::position::ProjectionKind,
    view::{GBufferTargets, LightCulling, LightingIo, LightingVariants},
};

/// In the render world: the lighting pipelines that are compiled. Tests and benches measure one kind, and compile no other.
#[doc(hidden)]
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CompiledLighting {
    /// Those that fit the view, and general ones for the time until then.
    #[default]
    All,
    /// Those that fit the view.
    Fitting,
    /// General ones, for all views that they light.
    General,
}

/// How shadow maps are filtered: a setting of the camera by which general pipelines are compiled.
const SHADOW_FILTER: MeshPipelineKey = MeshPipelineKey::SHADOW_FILTER_METHOD_RESERVED_BITS;

/// How ambient occlusion is filtered and applied: another one.
const OCCLUSION: LightingIo = LightingIo::AMBIENT_OCCLUSION
    .union(LightingIo::OCCLUSION_FILTER)
    .union(LightingIo::OCCLUSION_MULTIBOUNCE)
    .union(LightingIo::OCCLUSION_OF_DIRECT_LIGHT);

/// Light that effects exchange with lighting. The light that scatters is [`LightingKey::scatters`].
const EXCHANGED_LIGHT: LightingIo = LightingIo::DIFFUSE_LIGHT.union(LightingIo::INDIRECT);

/// Drops a part of the general pipelines.
type DropPart = fn(&mut LightingKey);

/// Drops parts for which a device may lack bindings, in this order.
const DROPPED_PARTS: [DropPart; 7] = [
    |room| room.scatters = false,
    |room| room.view.remove(MeshPipelineKey::ATMOSPHERE),
    |room| {
        room.view
            .remove(MeshPipelineKey::SCREEN_SPACE_AMBIENT_OCCLUSION);
    },
    |room| room.rect_lights = false,
    |room| {
        room.light_layers = false;
        room.targets.remove(GBufferTargets::VISIBILITY_MASK);
    },
    |room| room.io.remove(EXCHANGED_LIGHT),
    |room| room.io.remove(OCCLUSION),
];

/// The parts of general pipelines on `device`. `None` if it cannot have such pipelines.
pub(super) fn room(
    mesh_pipeline: &MeshPipeline,
    device: &RenderDevice,
    adapter: &RenderAdapter,
) -> Option<LightingKey> {
    let can_store = |format| {
        let features = adapter.get_texture_format_features(format);
        features
            .allowed_usages
            .contains(TextureUsages::STORAGE_BINDING)
    };
    let all = LightingKey {
        decals: mesh_pipeline.clustered_decals_are_usable,
        scatters: can_store(SUBSURFACE_LIGHT_FORMAT) && can_store(SUBSURFACE_PICTURE_FORMAT),
        ..LightingKey::with_all_parts()
    };
    let limits = device.limits();
    let list = filling_layout();
    room_within(all, |key| {
        let layouts = descriptors(mesh_pipeline, key);
        let layouts = layouts.iter().chain([&list]);
        excess(layouts.flat_map(|layout| &layout.entries), &limits)
    })
}

/// Those parts of `room` for which `excess` tells that no binding is too many. Keeps parts whose bindings are not among
/// those.
fn room_within(mut room: LightingKey, excess: impl Fn(LightingKey) -> u32) -> Option<LightingKey> {
    for drop_part in DROPPED_PARTS {
        let before = excess(room);
        let mut smaller = room;
        drop_part(&mut smaller);
        if excess(smaller) < before {
            room = smaller;
        }
    }
    (excess(room) == 0).then_some(room)
}

impl LightingKey {
    fn with_all_parts() -> Self {
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
            io: EXCHANGED_LIGHT | LightingIo::AMBIENT_OCCLUSION,
            scatters: true,
            light_layers: true,
            targets: GBufferTargets::LIT,
            is_general: true,
            lists: false,
            shaded: LightingVariants::of_lighting(),
        }
    }

    /// True if pipelines that fit a view with this key light one with the key `need` alike: what that has less of are lights,
    /// decals, and words of optional targets, which come to nothing by themselves.
    pub(crate) fn includes(self, need: Self) -> bool {
        let has_shadows = |key: Self| key.shadow_maps.intersects(ShadowMaps::OF_ANY_LIGHT);
        let reduced = Self {
            clustered_lights: need.clustered_lights,
            shadow_maps: need.shadow_maps,
            light_culling: need.light_culling,
            rect_lights: need.rect_lights,
            decals: need.decals,
            targets: need.targets,
            shaded: need.shaded,
            ..self
        };
        reduced == need
            && has_shadows(self) == has_shadows(need)
            && self.clustered_lights.contains(need.clustered_lights)
            && self.shadow_maps.contains(need.shadow_maps)
            && (self.rect_lights || !need.rect_lights)
            && (self.decals || !need.decals)
            && self.targets.contains(need.targets)
            && self.shaded.contains(need.shaded)
    }

    /// This general key for a camera with the settings in `need`.
    fn with_settings_of(self, need: Self) -> Self {
        let occlusion = if self.io.contains(LightingIo::AMBIENT_OCCLUSION) {
            need.io & OCCLUSION
        } else {
            LightingIo::empty()
        };
        Self {
            view: self.view | (need.view & SHADOW_FILTER),
            io: (self.io - OCCLUSION) | occlusion,
            ..self
        }
    }

    /// This general key for the dispatches of a view with the key `need`.
    fn with_dispatches_of(self, need: Self) -> Self {
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

    /// True if general pipelines with this key light a view with the key `need`.
    fn covers(self, need: Self) -> bool {
        let has_shadows = need.shadow_maps.intersects(ShadowMaps::OF_ANY_LIGHT);
        let has_occlusion = need.io.contains(LightingIo::AMBIENT_OCCLUSION);
        let filter = |key: Self| key.view & SHADOW_FILTER;
        let parts = [
            (self.rect_lights, need.rect_lights),
            (self.decals, need.decals),
            (self.scatters, need.scatters),
            (self.light_layers, need.light_layers),
        ];
        need.debug_view.is_none()
            && self.view.contains(need.view - SHADOW_FILTER)
            && (!has_shadows || filter(self) == filter(need))
            && self.clustered_lights.contains(need.clustered_lights)
            && self.shadow_maps.contains(need.shadow_maps)
            && self.io.contains(need.io & EXCHANGED_LIGHT)
            && (!has_occlusion || self.io & OCCLUSION == need.io & OCCLUSION)
            && self.targets.contains(need.targets)
            && self.shaded.contains(need.shaded)
            && parts.into_iter().all(|(has, needs)| has || !needs)
    }
}

impl LightingPipelines {
    /// True if there are placeholders for what a view lost.
    pub(crate) fn have_placeholders(&self) -> bool {
        self.placeholders.is_some()
    }

    /// True if general pipelines can light a view with the key `need` on this device.
    pub(crate) fn have_room_for(&self, need: LightingKey) -> bool {
        let room = self.room.map(|room| room.with_settings_of(need));
        room.is_some_and(|general| general.covers(need))
    }

    /// Queues general pipelines for a view with the key `need`, unless there are some, or the device has no room for them.
    pub(crate) fn request_general(&mut self, pipeline_cache: &PipelineCache, need: LightingKey) {
        let need = need.without_debug_view();
        let is_known = self.general.iter().any(|general| general.covers(need));
        let Some(room) = self.room.filter(|_| !is_known) else {
            return;
        };
        let general = room.with_settings_of(need);
        if !general.covers(need) {
            return;
        }
        let device = &self.device;
        self.placeholders
            .get_or_insert_with(|| Placeholders::new(device, room));
        self.general.push(general);
        for key in general.dispatches() {
            self.specialize(pipeline_cache, key);
        }
    }

    /// The keys of general pipelines that light a view with the key `need`. They may still be compiling.
    pub(crate) fn general_for(&self, need: LightingKey) -> impl Iterator<Item = LightingKey> {
        let general = self.general.iter().filter(move |key| key.covers(need));
        general.map(move |key| key.with_dispatches_of(need))
    }

    /// As [`general_for`](Self::general_for), without the debug view, and with shadows filtered in any way: for frames in
    /// which there is nothing better.
    pub(crate) fn general_like(&self, need: LightingKey) -> impl Iterator<Item = LightingKey> {
        let need = need.without_debug_view();
        self.general.iter().filter_map(move |key| {
            let need = LightingKey {
                view: (need.view - SHADOW_FILTER) | (key.view & SHADOW_FILTER),
                ..need
            };
            key.covers(need).then(|| key.with_dispatches_of(need))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::DebugView;

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
            targets: GBufferTargets::empty(),
            is_general: false,
            shaded: LightingVariants::empty(),
            ..room()
        }
    }

    /// Bindings of the parts in [`DROPPED_PARTS`], one each.
    fn bindings(key: LightingKey) -> u32 {
        let has = [
            key.scatters,
            key.view.contains(MeshPipelineKey::ATMOSPHERE),
            (key.view).contains(MeshPipelineKey::SCREEN_SPACE_AMBIENT_OCCLUSION),
            key.rect_lights,
            key.light_layers,
            key.io.contains(EXCHANGED_LIGHT),
            key.io.contains(LightingIo::AMBIENT_OCCLUSION),
        ];
        has.into_iter().map(u32::from).sum()
    }

    #[test]
    fn parts_are_dropped_in_order_until_the_rest_fits() {
        let mut expected = room();
        for (limit, drop_part) in (0..DROPPED_PARTS.len() as u32).rev().zip(DROPPED_PARTS) {
            drop_part(&mut expected);
            let found = room_within(room(), |key| bindings(key).saturating_sub(limit));
            assert_eq!(found, Some(expected), "{limit} bindings");
        }
        // Those of the base do not fit.
        assert_eq!(room_within(room(), |_| 1), None);
    }

    /// On a device with few textures but many buffers, parts that only take buffers stay.
    #[test]
    fn parts_that_do_not_help_are_kept() {
        let found = room_within(room(), |key| u32::from(key.rect_lights));
        let expected = LightingKey {
            rect_lights: false,
            ..room()
        };
        assert_eq!(found, Some(expected));
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
                shaded: LightingVariants::of_lighting(),
                ..sun()
            },
            LightingKey {
                io: OCCLUSION | LightingIo::INDIRECT_SPECULAR,
                ..sun()
            },
        ];
        for need in needs {
            assert!(room().with_settings_of(need).covers(need), "{need:?}");
        }
        let without_decals = LightingKey {
            decals: false,
            ..room()
        };
        let decals = LightingKey {
            decals: true,
            ..sun()
        };
        assert!(!without_decals.with_settings_of(decals).covers(decals));
    }

    #[test]
    fn settings_of_cameras_are_not_mixed_up() {
        let general = room().with_settings_of(sun());
        let other_filter = LightingKey {
            view: MeshPipelineKey::SHADOW_FILTER_METHOD_TEMPORAL,
            ..sun()
        };
        assert!(!general.covers(other_filter));
        let without_shadows = LightingKey {
            shadow_maps: ShadowMaps::empty(),
            ..other_filter
        };
        assert!(general.covers(without_shadows));

        let occluded = |filter| LightingKey {
            io: LightingIo::AMBIENT_OCCLUSION | filter,
            ..sun()
        };
        let half = occluded(LightingIo::OCCLUSION_HALF);
        assert!(!general.covers(half));
        let general = room().with_settings_of(half);
        assert!(general.covers(half));
        assert!(!general.covers(occluded(LightingIo::OCCLUSION_WIDE)));
        // Occlusion that is gone needs no other pipeline.
        assert!(general.covers(sun()));

        let shown = LightingKey {
            debug_view: Some(DebugView::Normal),
            ..sun()
        };
        assert!(!general.covers(shown));
    }

    #[test]
    fn pipelines_go_on_for_views_that_lost_lights_or_surfaces() {
        let more = LightingKey {
            clustered_lights: ClusteredLights::all(),
            shadow_maps: ShadowMaps::DIRECTIONAL | ShadowMaps::SPOT,
            light_culling: LightCulling::SharedMemory,
            rect_lights: true,
            decals: true,
            targets: GBufferTargets::EMISSIVE,
            shaded: LightingVariants::of_lighting(),
            ..sun()
        };
        assert!(more.includes(sun()));
        assert!(!sun().includes(more));
        assert_eq!(LightingKey::of_view(more.dispatches()), Some(more));
        let others = [
            // The bias of shadows takes another normal.
            LightingKey {
                shadow_maps: ShadowMaps::empty(),
                ..sun()
            },
            // Without their own bits, these parts would remain.
            LightingKey {
                view: sun().view | MeshPipelineKey::DISTANCE_FOG,
                ..sun()
            },
            LightingKey {
                io: LightingIo::INDIRECT_DIFFUSE,
                ..sun()
            },
            LightingKey {
                light_layers: true,
                ..sun()
            },
        ];
        for other in others {
            assert!(!more.includes(other), "{other:?}");
            assert!(
                !LightingKey {
                    decals: true,
                    ..other
                }
                .includes(sun())
            );
        }
    }

    #[test]
    fn views_without_special_surfaces_have_one_dispatch() {
        let special = LightingKey {
            shaded: LightingVariants::of_lighting(),
            ..sun()
        };
        let general = room();
        let all: Vec<LightingKey> = general.dispatches().collect();
        let of = |need| general.with_dispatches_of(need).dispatches();
        assert!(of(sun()).eq(all[..1].iter().copied()));
        assert!(of(special).eq(all));
    }
}
