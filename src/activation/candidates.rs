//! The states that a view may have in this frame, and the best of them whose lighting is compiled.

use core::iter::once;

use bevy::render::{
    render_resource::{CachedComputePipelineId, PipelineCache},
    sync_world::MainEntity,
};

use super::inputs::RequestedViewItem;
use crate::{
    gbuffer::WantedDemand,
    gpu::pipeline_watch::PipelineWatch,
    lighting::{CompiledLighting, LightingKey, LightingPipelines, ViewLighting},
    view::{ActiveLeanView, Demand, LightingIo},
};

/// The states of a view that is drawn in this `order`, the best first: with the wanted or needed demand or that of its
/// last state, and with the inputs and outputs of lighting that effects request or those of its last state.
pub(super) fn candidates(
    view: &RequestedViewItem,
    order: ActiveLeanView,
    wanted: WantedDemand,
) -> impl Iterator<Item = ActiveLeanView> + Clone {
    let io = LightingIo::asked(view.io);
    let held = (wanted.last.map(|last| last.io)).filter(|held| *held != io);
    let before = (wanted.last).map_or(Demand::default(), |last| last.demand());
    // Lighting for lingering demands may never be compiled, so what is needed alone is a choice too.
    let [lingering, needed] = wanted.demands;
    let demands = if before.contains(needed) {
        [lingering, before, needed]
    } else {
        [lingering, needed, before]
    };
    demands
        .into_iter()
        .flat_map(move |demand| once(io).chain(held).map(move |io| (demand, io)))
        .map(move |(demand, io)| state(order, wanted, demand, io))
}

/// The state of a view once it has the targets for which it waits, if any.
pub(super) fn next_state(
    view: &RequestedViewItem,
    order: ActiveLeanView,
    wanted: WantedDemand,
) -> Option<ActiveLeanView> {
    let io = LightingIo::asked(view.io);
    (wanted.next).map(|demand| state(order, wanted, demand, io))
}

fn state(
    order: ActiveLeanView,
    wanted: WantedDemand,
    demand: Demand,
    io: LightingIo,
) -> ActiveLeanView {
    let view = wanted.view(ActiveLeanView { io, ..order }, demand.targets);
    ActiveLeanView {
        variants: demand.on(&view).variants,
        ..view
    }
}

/// Lean frames of a view in which pipelines that fit it are compiled even if each delays a frame: its scene appears in
/// them.
const FIRST_FRAMES: u32 = 30;

/// Selects the lighting pipelines of views, and queues missing ones.
pub(super) struct PipelineSelection<'a> {
    pub(super) pipelines: &'a mut LightingPipelines,
    pub(super) cache: &'a mut PipelineCache,
    pub(super) compiled: CompiledLighting,
    /// Tells if a pipeline that is queued causes no long frame.
    pub(super) watch: &'a PipelineWatch,
    /// The camera is prewarmed: nothing is compiled that fits its loading screen.
    pub(super) is_prewarmed: bool,
}

impl PipelineSelection<'_> {
    /// Returns the first candidate with compiled pipelines, and sets those of `lighting` to them. If there is none, returns
    /// the first one with stand-ins for its pipelines.
    ///
    /// If Bevy compiles within the frame, requested pipelines are compiled when this returns: otherwise forward would draw the view in
    /// this frame, by pipelines that have to be compiled too.
    pub(super) fn best(
        &mut self,
        candidates: impl Iterator<Item = (ActiveLeanView, LightingKey)> + Clone,
        lighting: &mut ViewLighting,
    ) -> Option<ActiveLeanView> {
        let requested = self.pipelines.requested();
        let best = self.best_compiled(candidates.clone(), lighting);
        if best.is_some() || self.pipelines.requested() == requested {
            return best;
        }
        self.cache.process_queue();
        self.best_compiled(candidates, lighting)
    }

    fn best_compiled(
        &mut self,
        mut candidates: impl Iterator<Item = (ActiveLeanView, LightingKey)> + Clone,
        lighting: &mut ViewLighting,
    ) -> Option<ActiveLeanView> {
        let found = candidates
            .clone()
            .find(|(_, key)| self.is_lit(*key, lighting))
            .or_else(|| {
                let mut candidates = candidates.clone();
                candidates.find(|(_, key)| self.stands_in(*key, lighting))
            });
        // After the pipelines that fit, which are of use for longer.
        if self.may_be_general()
            && let Some((_, wanted)) = candidates.next()
        {
            self.pipelines
                .request_general(self.cache, self.watch, wanted);
        }
        let (best, key) = found?;
        lighting.parts = key.parts();
        lighting.frames = if self.is_prewarmed {
            FIRST_FRAMES
        } else {
            lighting.frames.saturating_add(1)
        };
        Some(best)
    }

    /// Sets the pipelines of `lighting` to those that fit `key`, or else to the closest ones that light the view too, or else to general
    /// ones. Tells if they are compiled. Queues missing ones that fit, unless a prewarmed level has the view, or others light it and each
    /// new one delays the frame.
    fn is_lit(&mut self, key: LightingKey, lighting: &mut ViewLighting) -> bool {
        let may_fit = self.may_fit(key);
        if may_fit && self.are_set(key, lighting) {
            return true;
        }
        let is_lit = self.may_be_general() && self.others_are_set(key, may_fit, lighting);
        if may_fit
            && !(is_lit && self.has_level_for(key))
            && self.may_request(key, is_lit, lighting)
            && let Some(queued) = self.request_fitting(key, is_lit)
        {
            lighting.pipelines = queued;
        }
        is_lit
    }

    /// Sets the pipelines of `lighting` to others than those that fit `key`: the closest ones, if some that fit may be used, or general
    /// ones. False if none are compiled.
    fn others_are_set(&self, key: LightingKey, may_fit: bool, lighting: &mut ViewLighting) -> bool {
        let may_be_closest = may_fit && self.pipelines.have_placeholders();
        let closest = may_be_closest.then(|| self.pipelines.closest(self.cache, key));
        let mut others = closest.flatten().into_iter();
        others.any(|key| self.are_set(key, lighting))
            || (self.pipelines.general_for(key)).is_some_and(|key| self.are_set(key, lighting))
    }

    /// Queues the pipelines that fit `key`, the next state of a view with this `lighting`, unless others may light it and each new one
    /// delays the frame, or a prewarmed level has it.
    pub(super) fn request(&mut self, key: LightingKey, lighting: &ViewLighting) {
        let is_lit = self.may_be_general();
        if self.may_fit(key) && !self.has_level_for(key) && self.may_request(key, is_lit, lighting)
        {
            self.request_fitting(key, is_lit);
        }
    }

    /// Queues the pipelines that fit `key`, and returns them unless some are withheld, or others light the view: then they are queued
    /// one at a time. A frame for which Bevy waits for a pipeline of its own, as with the first camera drawn over another one, waits for
    /// those queued before.
    fn request_fitting(
        &mut self,
        key: LightingKey,
        is_lit: bool,
    ) -> Option<Vec<(LightingKey, CachedComputePipelineId)>> {
        if is_lit {
            self.request_next(key);
            return None;
        }
        let mut pipelines = key.dispatches();
        pipelines.try_fold(Vec::new(), |mut queued, key| {
            queued.push((key, self.pipelines.request(self.cache, self.watch, key)?));
            Some(queued)
        })
    }

    /// Queues one of the pipelines that fit `key`, once no other of lighting is still to be compiled.
    fn request_next(&mut self, key: LightingKey) {
        let mut missing = key
            .dispatches()
            .filter(|key| !self.pipelines.is_requested(*key));
        if let Some(missing) = missing.next()
            && !self.pipelines.are_compiling(self.cache)
        {
            self.pipelines.request(self.cache, self.watch, missing);
        }
    }

    /// Queues the pipelines that fit these levels of a `camera`, if they may be requested now. Returns the number of missing ones that
    /// may not.
    pub(super) fn prewarm(
        &mut self,
        camera: MainEntity,
        levels: Vec<LightingKey>,
        is_now: bool,
    ) -> usize {
        let mut awaited = 0;
        for level in levels {
            if !self.may_fit(level) {
                continue;
            }
            let missing = level
                .dispatches()
                .filter(|key| !self.pipelines.is_requested(*key));
            let missing: Vec<LightingKey> = missing.collect();
            // No view may need all that a level has.
            if !missing.is_empty() && !self.pipelines.can_bind(level) {
                continue;
            }
            if is_now {
                self.pipelines.add_level(camera, level);
                for key in missing {
                    self.pipelines.request(self.cache, self.watch, key);
                }
            } else {
                awaited += missing.len();
            }
        }
        awaited
    }

    /// Tells if pipelines that fit `key` may be queued, for a view that others light or not.
    fn may_request(&self, key: LightingKey, is_lit: bool, lighting: &ViewLighting) -> bool {
        if self.is_prewarmed && self.may_be_general() && self.pipelines.have_room_for(key) {
            return false;
        }
        !is_lit || self.watch.compiles_in_background() || lighting.frames < FIRST_FRAMES
    }

    fn has_level_for(&self, key: LightingKey) -> bool {
        self.pipelines.have_level_for(self.cache, key)
    }

    fn may_fit(&self, key: LightingKey) -> bool {
        self.compiled != CompiledLighting::General || !self.pipelines.have_room_for(key)
    }

    fn are_compiled(&self, lighting: &ViewLighting) -> bool {
        let mut ids = lighting.pipelines.iter().map(|(_, id)| *id);
        ids.all(|id| self.cache.get_compute_pipeline(id).is_some())
    }

    /// Sets the pipelines of `lighting` to compiled ones that light a view with this `key` as well. False if there are none.
    fn stands_in(&self, key: LightingKey, lighting: &mut ViewLighting) -> bool {
        let general = self.pipelines.general_like(key);
        (key.stand_ins()
            .chain(general.filter(|_| self.may_be_general())))
        .any(|key| self.are_set(key, lighting))
    }

    fn may_be_general(&self) -> bool {
        self.compiled != CompiledLighting::Fitting
    }

    /// Sets the pipelines of `lighting` to those for `key` if all are compiled.
    fn are_set(&self, key: LightingKey, lighting: &mut ViewLighting) -> bool {
        let current = lighting.pipelines.iter().map(|(key, _)| *key);
        if current.eq(key.dispatches()) {
            return self.are_compiled(lighting);
        }
        let compiled = self.pipelines.compiled(self.cache, key);
        let is_compiled = compiled.is_some();
        if let Some(compiled) = compiled {
            lighting.pipelines = compiled;
        }
        is_compiled
    }
}
