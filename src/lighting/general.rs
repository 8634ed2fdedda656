//! General pipelines: they light a view until the pipelines that are compiled for it are there.
//!
//! They are compiled with all parts that the device has bindings for, and with all settings of cameras.

use bevy::{
    pbr::{MeshPipeline, MeshPipelineKey},
    prelude::*,
    render::{
        render_resource::{PipelineCache, TextureUsages},
        renderer::{RenderAdapter, RenderDevice},
    },
};

use super::{
    coverage::{EXCHANGED_LIGHT, OCCLUSION},
    features::LightingKey,
    layouts::descriptors,
    pipeline::LightingPipelines,
    placeholders::Placeholders,
    subsurface_light::{SUBSURFACE_LIGHT_FORMAT, SUBSURFACE_PICTURE_FORMAT},
    tile_list::filling_layout,
};
use crate::{
    gpu::{layout_limits::excess, pipeline_watch::PipelineWatch},
    view::GBufferTargets,
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

impl LightingPipelines {
    /// True if there are placeholders for what a view lost.
    pub(crate) fn have_placeholders(&self) -> bool {
        self.placeholders.is_some()
    }

    /// True if general pipelines can light a view with the key `need` on this device.
    pub(crate) fn have_room_for(&self, need: LightingKey) -> bool {
        self.room.is_some_and(|general| general.lights(need))
    }

    /// Queues the general pipelines, as far as the budget of `watch` admits, unless they are queued or light no view with the key
    /// `need`.
    pub(crate) fn request_general(
        &mut self,
        pipeline_cache: &PipelineCache,
        watch: &PipelineWatch,
        need: LightingKey,
    ) {
        let need = need.without_debug_view();
        let Some(general) = self.room.filter(|general| general.lights(need)) else {
            return;
        };
        let device = &self.device;
        self.placeholders
            .get_or_insert_with(|| Placeholders::new(device, general));
        for key in general.dispatches() {
            self.request(pipeline_cache, watch, key);
        }
    }

    /// The key of the general pipelines that light a view with the key `need`, if they do. They may still be compiling.
    pub(crate) fn general_for(&self, need: LightingKey) -> Option<LightingKey> {
        let general = self.room.filter(|general| general.lights(need));
        general.map(|key| key.with_dispatches_of(need))
    }

    /// As [`general_for`](Self::general_for), without the debug view: for frames in which there is nothing better.
    pub(crate) fn general_like(&self, need: LightingKey) -> Option<LightingKey> {
        self.general_for(need.without_debug_view())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::LightingIo;

    fn room() -> LightingKey {
        LightingKey::with_all_parts()
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
}
