//! Compute passes of effects: an effect's passes are one table, from which its layouts, pipelines and dispatches follow.
//!
//! An effect keeps until compiled: it goes on with the pipelines it has until those for new settings are compiled.

use core::{array, hash::Hash};

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
    timed::Dispatch,
};

/// A compute pass of an effect.
pub(crate) struct ComputePass {
    /// Label of its layout, its pipeline and its GPU time.
    pub(crate) label: &'static str,
    pub(crate) shader: fn(&AssetServer) -> Handle<Shader>,
    pub(crate) entry: &'static str,
    /// Shader definitions in addition to those of the key. [`EffectKey::keeps_def`] may leave some out.
    pub(crate) defs: &'static [&'static str],
    /// Numbers of the bindings. Those of no kind for the key are not bound.
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
    /// Shader definitions of all passes.
    fn shader_defs(self) -> Vec<ShaderDefVal> {
        Vec::new()
    }

    /// True if passes with the definition `name` in their table are compiled with it.
    fn keeps_def(self, _name: &str) -> bool {
        true
    }

    /// True if its pipelines can stand in for those of `wanted` until they are compiled.
    fn stands_in_for(self, _wanted: Self) -> bool {
        true
    }
}

/// Pipelines of an effect's passes by key. Belongs to one device.
#[derive(Resource)]
pub(crate) struct EffectPipelines<K: EffectKey> {
    passes: &'static [ComputePass],
    /// The kind of a binding; `None` if shaders of the key do not have it.
    kind: fn(K, u32) -> Option<BindGroupLayoutEntryBuilder>,
    shaders: Vec<Handle<Shader>>,
    by_key: HashMap<K, Vec<PassPipeline>>,
}

/// The pipeline of a pass for a key, and the layout of its bind group.
pub(crate) struct PassPipeline {
    id: CachedComputePipelineId,
    pub(crate) layout: ResolvedLayout,
}

impl<K: EffectKey> EffectPipelines<K> {
    pub(crate) fn new(
        asset_server: &AssetServer,
        passes: &'static [ComputePass],
        kind: fn(K, u32) -> Option<BindGroupLayoutEntryBuilder>,
    ) -> Self {
        let shaders = passes.iter().map(|pass| (pass.shader)(asset_server));
        Self {
            passes,
            kind,
            shaders: shaders.collect(),
            by_key: HashMap::default(),
        }
    }

    /// Pipelines for `key`, in the order of the passes; they may still be compiling.
    pub(crate) fn specialize(&mut self, cache: &PipelineCache, key: K) -> &[PassPipeline] {
        let (passes, kind, shaders) = (self.passes, self.kind, &self.shaders);
        self.by_key.entry(key).or_insert_with(|| {
            let queue = |(pass, shader): (&ComputePass, &Handle<Shader>)| {
                let layout = ResolvedLayout::new(cache, pass.layout(|binding| kind(key, binding)));
                let of_pass = pass.defs.iter().copied();
                let of_pass = of_pass.filter(|name| key.keeps_def(name));
                let defs = key.shader_defs().into_iter();
                let id = cache.queue_compute_pipeline(ComputePipelineDescriptor {
                    label: Some(pass.label.into()),
                    layout: vec![layout.descriptor().clone()],
                    shader: shader.clone(),
                    shader_defs: defs.chain(of_pass.map(ShaderDefVal::from)).collect(),
                    entry_point: Some(pass.entry.into()),
                    ..default()
                });
                PassPipeline { id, layout }
            };
            passes.iter().zip(shaders).map(queue).collect()
        })
    }

    /// As [`specialize`](Self::specialize); empty for a key that has not been specialized.
    pub(crate) fn of(&self, key: K) -> &[PassPipeline] {
        let pipelines = self.by_key.get(&key);
        pipelines.map(Vec::as_slice).unwrap_or_default()
    }

    fn are_compiled(&self, cache: &PipelineCache, key: K) -> bool {
        let is_compiled = |pass: &PassPipeline| cache.get_compute_pipeline(pass.id).is_some();
        let pipelines = self.by_key.get(&key);
        pipelines.is_some_and(|pipelines| pipelines.iter().all(is_compiled))
    }

    /// The state of a view in this frame: `wanted` once its pipelines are compiled, and until then the `current` one, if that
    /// can stand in.
    pub(crate) fn keep_until_compiled<A>(
        &mut self,
        cache: &PipelineCache,
        wanted: A,
        current: Option<A>,
        key_of: impl Fn(&A) -> K,
    ) -> Option<A> {
        let key = key_of(&wanted);
        self.specialize(cache, key);
        let stand_in = current.filter(|current| key_of(current).stands_in_for(key));
        [Some(wanted), stand_in]
            .into_iter()
            .flatten()
            .find(|active| self.are_compiled(cache, key_of(active)))
    }

    /// The reason that pipelines for `key` cannot be compiled.
    pub(crate) fn failure<'w>(&self, watch: &'w PipelineWatch, key: K) -> Option<&'w str> {
        watch.failure(self.of(key).iter().map(|pass| pass.id.id()))
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
                pipeline: cache.get_compute_pipeline(pipelines.get(pass)?.id)?,
                group: group?,
                offsets,
                workgroups,
            })
        })
    }
}
