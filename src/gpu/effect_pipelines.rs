//! Compute passes of effects: an effect's passes are one table, from which its layouts, pipelines and dispatches follow.
//!
//! While the pipelines for new settings compile, compiled ones of another key stand in for them.

use core::{array, hash::Hash, iter};

use bevy::{
    platform::collections::HashMap,
    prelude::*,
    render::render_resource::{
        BindGroup, BindGroupLayoutDescriptor, BindGroupLayoutEntryBuilder, CachedComputePipelineId,
        ComputePipelineDescriptor, PipelineCache, ShaderStages,
    },
    shader::ShaderDefVal,
};

use super::{
    bind_group_cache::ResolvedLayout, bindings::layout, pipeline_watch::PipelineWatch,
    shader_defs::name_of, timed::Dispatch,
};

/// A compute pass of an effect.
pub struct ComputePass {
    /// Label of its layout, its pipeline and its GPU time.
    pub label: &'static str,
    pub(crate) shader: fn(&AssetServer) -> Handle<Shader>,
    pub(crate) entry: &'static str,
    /// Shader definitions that it is always compiled with.
    pub defs: &'static [&'static str],
    /// Names of the key's shader definitions that it is compiled with. Keys that differ in others share its pipeline.
    pub key_defs: &'static [&'static str],
    /// Numbers of the bindings.
    pub(crate) reads: &'static [u32],
    pub(crate) writes: &'static [u32],
}

impl ComputePass {
    /// The layout of its bind group. `kind` is that of a binding.
    pub(crate) fn layout(
        &self,
        kind: impl Fn(u32) -> Option<BindGroupLayoutEntryBuilder>,
    ) -> BindGroupLayoutDescriptor {
        let bindings = self.reads.iter().chain(self.writes);
        let entries = bindings.filter_map(|binding| Some((*binding, kind(*binding)?)));
        layout(self.label, ShaderStages::COMPUTE, entries)
    }
}

/// Key that the passes of an effect are compiled by.
pub(crate) trait EffectKey: Copy + Eq + Hash + Send + Sync + 'static {
    /// Shader definitions. A pass has those that its table names.
    fn shader_defs(self) -> Vec<ShaderDefVal> {
        Vec::new()
    }

    /// True if its pipelines can stand in for those of `wanted` until they are compiled.
    fn stands_in_for(self, _wanted: Self) -> bool {
        true
    }
}

/// Pipelines of an effect's passes by key, and the layouts that all keys share. Belongs to one device.
#[derive(Resource)]
pub(crate) struct EffectPipelines<K: EffectKey> {
    passes: &'static [ComputePass],
    /// The kind of a binding.
    kind: fn(u32) -> Option<BindGroupLayoutEntryBuilder>,
    shaders: Vec<Handle<Shader>>,
    /// Of the bind groups, by pass. Empty until a key is specialized.
    layouts: Vec<ResolvedLayout>,
    by_key: HashMap<K, Vec<CachedComputePipelineId>>,
    /// By the number of the pass, and its definitions.
    by_defs: HashMap<(usize, Vec<ShaderDefVal>), CachedComputePipelineId>,
}

impl<K: EffectKey> EffectPipelines<K> {
    pub(crate) fn new(
        asset_server: &AssetServer,
        passes: &'static [ComputePass],
        kind: fn(u32) -> Option<BindGroupLayoutEntryBuilder>,
    ) -> Self {
        let shaders = passes.iter().map(|pass| (pass.shader)(asset_server));
        Self {
            passes,
            kind,
            shaders: shaders.collect(),
            layouts: Vec::new(),
            by_key: HashMap::default(),
            by_defs: HashMap::default(),
        }
    }

    /// Requests the pipelines for `key`, as far as the budget of `watch` admits. Returns the layouts of the passes' bind groups,
    /// in their order.
    pub(crate) fn specialize(
        &mut self,
        cache: &PipelineCache,
        watch: &PipelineWatch,
        key: K,
    ) -> &[ResolvedLayout] {
        if self.layouts.is_empty() {
            let layout = |pass: &ComputePass| ResolvedLayout::new(cache, pass.layout(self.kind));
            self.layouts = self.passes.iter().map(layout).collect();
        }
        if !self.by_key.contains_key(&key) {
            let defs = key.shader_defs();
            let passes = 0..self.passes.len();
            let pipelines = passes.map(|number| self.request(cache, watch, number, &defs));
            // All are tried, so that those of the rest count as withheld.
            let pipelines: Vec<_> = pipelines.collect();
            if let Some(pipelines) = pipelines.into_iter().collect() {
                self.by_key.insert(key, pipelines);
            }
        }
        &self.layouts
    }

    /// The pipeline of a pass for a key with these definitions; `None` if it is withheld.
    fn request(
        &mut self,
        cache: &PipelineCache,
        watch: &PipelineWatch,
        number: usize,
        defs: &[ShaderDefVal],
    ) -> Option<CachedComputePipelineId> {
        let pass = &self.passes[number];
        let of_key = defs
            .iter()
            .filter(|def| pass.key_defs.contains(&name_of(def)));
        let of_pass = pass.defs.iter().map(|name| ShaderDefVal::from(*name));
        let shader_defs: Vec<ShaderDefVal> = of_pass.chain(of_key.cloned()).collect();
        let key = (number, shader_defs.clone());
        if let Some(pipeline) = self.by_defs.get(&key) {
            return Some(*pipeline);
        }
        if !watch.budget.admits() {
            return None;
        }
        let pipeline = cache.queue_compute_pipeline(ComputePipelineDescriptor {
            label: Some(pass.label.into()),
            layout: vec![self.layouts[number].descriptor().clone()],
            shader: self.shaders[number].clone(),
            shader_defs,
            entry_point: Some(pass.entry.into()),
            ..default()
        });
        self.by_defs.insert(key, pipeline);
        Some(pipeline)
    }

    /// Layouts of the passes' bind groups, in their order; empty until a key is specialized.
    pub(crate) fn layouts(&self) -> &[ResolvedLayout] {
        &self.layouts
    }

    fn of(&self, key: K) -> &[CachedComputePipelineId] {
        let pipelines = self.by_key.get(&key);
        pipelines.map(Vec::as_slice).unwrap_or_default()
    }

    fn are_compiled(&self, cache: &PipelineCache, key: K) -> bool {
        let is_compiled = |id: &CachedComputePipelineId| cache.get_compute_pipeline(*id).is_some();
        let pipelines = self.by_key.get(&key);
        pipelines.is_some_and(|pipelines| pipelines.iter().all(is_compiled))
    }

    /// The key of a view's pipelines in this frame: `wanted` once they are compiled; until then the `current` one, or any other
    /// compiled one, that can stand in. `None` while there is none.
    pub(crate) fn compiled_key(
        &mut self,
        cache: &PipelineCache,
        watch: &PipelineWatch,
        wanted: K,
        current: Option<K>,
    ) -> Option<K> {
        self.specialize(cache, watch, wanted);
        let stand_ins = current.into_iter().chain(self.by_key.keys().copied());
        let stand_ins = stand_ins.filter(|key| key.stands_in_for(wanted));
        iter::once(wanted)
            .chain(stand_ins)
            .find(|key| self.are_compiled(cache, *key))
    }

    /// The reason that pipelines for `key` cannot be compiled.
    pub(crate) fn failure<'w>(&self, watch: &'w PipelineWatch, key: K) -> Option<&'w str> {
        watch.failure(self.of(key).iter().map(|pipeline| pipeline.id()))
    }

    /// The dispatch of each pass, from its bind group, dynamic offsets and workgroups; `None` if its pipeline or bind group
    /// is missing.
    pub(crate) fn dispatches<'a, const PASSES: usize>(
        &self,
        cache: &'a PipelineCache,
        key: K,
        of_pass: impl Fn(usize) -> (Option<&'a BindGroup>, &'a [u32], UVec2),
    ) -> [Option<Dispatch<'a>>; PASSES] {
        let pipelines = self.of(key);
        array::from_fn(|pass| {
            let (group, offsets, workgroups) = of_pass(pass);
            Some(Dispatch {
                label: self.passes.get(pass)?.label,
                pipeline: cache.get_compute_pipeline(*pipelines.get(pass)?)?,
                group: group?,
                offsets,
                workgroups,
            })
        })
    }
}
