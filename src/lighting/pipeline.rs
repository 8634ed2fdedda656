//! Pipelines of the lighting pass.

use bevy::{
    asset::load_embedded_asset,
    pbr::MeshPipeline,
    platform::collections::HashMap,
    prelude::*,
    render::{
        render_resource::{
            CachedComputePipelineId, CachedPipelineState, ComputePipelineDescriptor, PipelineCache,
            Sampler, SamplerDescriptor,
        },
        renderer::{RenderAdapter, RenderDevice},
        sync_world::MainEntity,
    },
    shader::ShaderDefVal,
};

use super::{
    bevy::definitions::{of_mesh_pipeline, read_by_lighting},
    definitions::definitions,
    features::LightingKey,
    general::room,
    layouts::{LightingLayouts, bevys_keys, descriptors},
    placeholders::Placeholders,
    tile_list::{filling_layout, reading_layout},
};
use crate::gpu::{
    bind_group_cache::ResolvedLayout, layout_limits::excess, pipeline_watch::PipelineWatch,
};

/// Lighting pipelines by key, created by `init_lighting_pipelines`.
#[derive(Resource)]
pub(crate) struct LightingPipelines {
    pub(super) mesh_pipeline: MeshPipeline,
    shader: Handle<Shader>,
    by_key: HashMap<LightingKey, (CachedComputePipelineId, LightingLayouts)>,
    /// The key of the general pipelines of this device, if it can have any.
    pub(super) room: Option<LightingKey>,
    /// The keys of the level that each camera was prewarmed for last.
    levels: Vec<(MainEntity, LightingKey)>,
    /// Created with the first of these.
    pub(super) placeholders: Option<Placeholders>,
    pub(super) device: RenderDevice,
    /// Gathers texels of ambient occlusion.
    pub(super) nearest_sampler: Sampler,
    pub(super) filling_list: ResolvedLayout,
    pub(super) reading_list: ResolvedLayout,
}

pub(super) fn init_lighting_pipelines(
    mut commands: Commands,
    mesh_pipeline: Res<MeshPipeline>,
    asset_server: Res<AssetServer>,
    pipeline_cache: Res<PipelineCache>,
    (render_device, render_adapter): (Res<RenderDevice>, Res<RenderAdapter>),
) {
    commands.insert_resource(LightingPipelines {
        mesh_pipeline: mesh_pipeline.clone(),
        shader: load_embedded_asset!(asset_server.as_ref(), "lighting.wgsl"),
        by_key: HashMap::default(),
        room: room(&mesh_pipeline, &render_device, &render_adapter),
        levels: Vec::new(),
        placeholders: None,
        device: render_device.clone(),
        nearest_sampler: render_device.create_sampler(&SamplerDescriptor {
            label: Some("lean_deferred/lighting/nearest"),
            ..default()
        }),
        filling_list: ResolvedLayout::new(&pipeline_cache, filling_layout()),
        reading_list: ResolvedLayout::new(&pipeline_cache, reading_layout()),
    });
}

impl LightingPipelines {
    /// Returns the pipeline for `key`, which may still be compiling; `None` if it is withheld by the budget of `watch`.
    pub(crate) fn request(
        &mut self,
        pipeline_cache: &PipelineCache,
        watch: &PipelineWatch,
        key: LightingKey,
    ) -> Option<CachedComputePipelineId> {
        let is_requested = self.is_requested(key) || watch.budget.admits();
        is_requested.then(|| self.specialize(pipeline_cache, key))
    }

    /// True if the pipeline for `key` was requested.
    pub(crate) fn is_requested(&self, key: LightingKey) -> bool {
        self.by_key.contains_key(&key)
    }

    /// Number of the pipelines that were requested.
    pub(crate) fn requested(&self) -> usize {
        self.by_key.len()
    }

    /// True if a requested pipeline is still to be compiled.
    pub(crate) fn are_compiling(&self, pipeline_cache: &PipelineCache) -> bool {
        let mut ids = self.by_key.values().map(|(id, _)| *id);
        ids.any(|id| {
            let state = pipeline_cache.get_compute_pipeline_state(id);
            matches!(
                state,
                CachedPipelineState::Queued | CachedPipelineState::Creating(_)
            )
        })
    }

    /// True if the device has bindings for all dispatches of a view with `key`.
    pub(crate) fn can_bind(&self, key: LightingKey) -> bool {
        let limits = self.device.limits();
        let lists = [filling_layout(), reading_layout()];
        key.dispatches().all(|key| {
            let groups = descriptors(&self.mesh_pipeline, key);
            let list = if !key.shaded.is_empty() {
                Some(&lists[1])
            } else {
                key.lists.then_some(&lists[0])
            };
            let layouts = groups.iter().chain(list);
            excess(layouts.flat_map(|layout| &layout.entries), &limits) == 0
        })
    }

    /// Records `key` as that of a level for which `camera` is prewarmed: views that its pipelines light request none of their own.
    pub(crate) fn add_level(&mut self, camera: MainEntity, key: LightingKey) {
        if !self.levels.contains(&(camera, key)) {
            self.levels.push((camera, key));
        }
    }

    /// Forgets the level of `camera`. Its pipelines stay, for views that they fit.
    pub(crate) fn forget_level(&mut self, camera: MainEntity) {
        self.levels.retain(|(other, _)| *other != camera);
    }

    /// True if pipelines that fit a prewarmed level are compiled, and light a view with the key `need`.
    pub(crate) fn have_level_for(&self, pipeline_cache: &PipelineCache, need: LightingKey) -> bool {
        let mut levels = self.levels.iter().map(|(_, key)| *key);
        levels.any(|level| level.lights(need) && self.compiled(pipeline_cache, level).is_some())
    }

    /// The key of the smallest compiled pipelines that fit some view or level, and light one with the key `need` too.
    pub(crate) fn closest(
        &self,
        pipeline_cache: &PipelineCache,
        need: LightingKey,
    ) -> Option<LightingKey> {
        let room = self.room?;
        // Keys of views, not those of their dispatches over all tiles.
        let of_views = self.by_key.keys().copied().filter(|key| !key.lists);
        of_views
            .filter(|key| !key.is_general && key.lights(need))
            // There are placeholders for what general pipelines have.
            .filter(|key| room.scatters || key.scatters == need.scatters)
            .filter(|key| self.compiled(pipeline_cache, *key).is_some())
            .min_by_key(|key| key.size())
    }

    /// Returns the pipeline for `key`, which may still be compiling.
    pub(crate) fn specialize(
        &mut self,
        pipeline_cache: &PipelineCache,
        key: LightingKey,
    ) -> CachedComputePipelineId {
        if let Some((id, _)) = self.by_key.get(&key) {
            return *id;
        }
        let list = if !key.shaded.is_empty() {
            Some(self.reading_list.clone())
        } else {
            key.lists.then(|| self.filling_list.clone())
        };
        let groups = descriptors(&self.mesh_pipeline, key);
        let layouts = LightingLayouts::new(pipeline_cache, groups, key, list);
        let id = pipeline_cache.queue_compute_pipeline(ComputePipelineDescriptor {
            label: Some("lean_deferred/lighting".into()),
            layout: [&layouts.view, &layouts.arrays, &layouts.targets]
                .into_iter()
                .chain(&layouts.list)
                .map(|layout| layout.descriptor().clone())
                .collect(),
            shader: self.shader.clone(),
            shader_defs: self.shader_defs(key, &layouts),
            entry_point: Some("main".into()),
            ..default()
        });
        self.by_key.insert(key, (id, layouts));
        id
    }

    /// Returns the pipelines of all dispatches for `key` if they are compiled. Does not queue missing ones.
    pub(crate) fn compiled(
        &self,
        pipeline_cache: &PipelineCache,
        key: LightingKey,
    ) -> Option<Vec<(LightingKey, CachedComputePipelineId)>> {
        key.dispatches()
            .map(|key| {
                let (id, _) = self.by_key.get(&key)?;
                pipeline_cache.get_compute_pipeline(*id)?;
                Some((key, *id))
            })
            .collect()
    }

    pub(super) fn layouts_of(&self, key: LightingKey) -> Option<&LightingLayouts> {
        self.by_key.get(&key).map(|(_, layouts)| layouts)
    }

    /// The definitions of shaders of the pipeline for `key`.
    pub(super) fn shader_defs(
        &self,
        key: LightingKey,
        layouts: &LightingLayouts,
    ) -> Vec<ShaderDefVal> {
        let mut bevys: Vec<ShaderDefVal> = Vec::new();
        for key in bevys_keys(key) {
            for definition in of_mesh_pipeline(&self.mesh_pipeline, key) {
                if !bevys.contains(&definition) {
                    bevys.push(definition);
                }
            }
        }
        let bevys = read_by_lighting(bevys, |binding| layouts.has_binding(binding));
        definitions(key, bevys)
    }
}
