//! The states that a view may have in this frame, and the best of them whose lighting is compiled.

use core::iter::once;

use bevy::render::render_resource::PipelineCache;

use super::inputs::RequestedViewItem;
use crate::{
    lighting::{LightingKey, LightingPipelines, ViewLighting},
    view::{ActiveLeanView, Demand, LightingIo},
};

/// The states of a view that is drawn in this `order`, the best first: with the `wanted` or `needed` demand or that of
/// its `last` state, and with the inputs and outputs of lighting that effects request or those of its `last` state.
pub(super) fn candidates(
    view: &RequestedViewItem,
    order: ActiveLeanView,
    [wanted, needed]: [Demand; 2],
    last: Option<&ActiveLeanView>,
) -> impl Iterator<Item = ActiveLeanView> + Clone {
    let io = LightingIo::asked(view.io);
    let held = last.map(|last| last.io).filter(|held| *held != io);
    let before = last.map_or(Demand::default(), ActiveLeanView::demand);
    // Lighting for lingering demands may never be compiled, so `needed` alone is a choice too.
    let demands = if before.contains(needed) {
        [wanted, before, needed]
    } else {
        [wanted, needed, before]
    };
    demands
        .into_iter()
        .flat_map(move |demand| once(io).chain(held).map(move |io| (demand, io)))
        .map(move |(demand, io)| {
            let view = ActiveLeanView { io, ..order };
            let Demand { targets, variants } = demand.on(&view);
            ActiveLeanView {
                targets,
                variants,
                ..view
            }
        })
}

/// Returns the first candidate whose pipelines are compiled, and sets those of `lighting` to them. If there is none,
/// returns the first one with stand-ins for its pipelines.
pub(super) fn best_compiled(
    mut candidates: impl Iterator<Item = (ActiveLeanView, LightingKey)> + Clone,
    lighting: &mut ViewLighting,
    pipelines: &mut LightingPipelines,
    cache: &PipelineCache,
) -> Option<ActiveLeanView> {
    let (best, key) = candidates
        .clone()
        .find(|(_, key)| specialize(*key, lighting, pipelines, cache))
        .or_else(|| candidates.find(|(_, key)| stand_in(*key, lighting, pipelines, cache)))?;
    lighting.parts = key.parts();
    Some(best)
}

/// Sets the pipelines of `lighting` to those for `key`, and tells if all are compiled. Queues missing ones.
fn specialize(
    key: LightingKey,
    lighting: &mut ViewLighting,
    pipelines: &mut LightingPipelines,
    cache: &PipelineCache,
) -> bool {
    let current = lighting.pipelines.iter().map(|(key, _)| *key);
    if !current.eq(key.dispatches()) {
        lighting.pipelines = key
            .dispatches()
            .map(|key| (key, pipelines.specialize(cache, key)))
            .collect();
    }
    let mut ids = lighting.pipelines.iter().map(|(_, id)| *id);
    ids.all(|id| cache.get_compute_pipeline(id).is_some())
}

/// Sets the pipelines of `lighting` to compiled ones that light a view with this `key` as well. False if there are none.
fn stand_in(
    key: LightingKey,
    lighting: &mut ViewLighting,
    pipelines: &LightingPipelines,
    cache: &PipelineCache,
) -> bool {
    let compiled = (key.stand_ins()).find_map(|key| pipelines.compiled(cache, key));
    let is_compiled = compiled.is_some();
    if let Some(compiled) = compiled {
        lighting.pipelines = compiled;
    }
    is_compiled
}
