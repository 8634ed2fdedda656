//! Looks up the pipeline that draws a mesh into the G-buffer, or specializes it.

use core::hash::BuildHasher;

use alloc::sync::Arc;

use bevy::{
    material::key::{ErasedMaterialPipelineKey, ErasedMeshPipelineKey},
    pbr::{MeshPipelineKey, PrepassPipeline, RenderMeshInstanceFlags, alpha_mode_pipeline_key},
    platform::{
        collections::{HashMap, HashSet},
        hash::FixedHasher,
    },
    prelude::*,
    render::{
        render_resource::{
            CachedPipelineState, CachedRenderPipelineId, PipelineCache, SpecializedMeshPipelines,
        },
        sync_world::MainEntity,
    },
};

use super::{
    lookup::{MeshLookup, MeshToQueue, RECENT_KINDS},
    pipeline::{GBufferPipelineKey, GBufferPipelineSpecializer},
    placement::MeshOutput,
    registration::MaterialShaders,
};
use crate::{
    gpu::{named::system_param, pipeline_watch::is_settled},
    view::GBufferTargets,
};

system_param! {
    /// The pipelines of the G-buffer, with what is needed to specialize them.
    pub(super) struct GBufferPipelines<'w, 's> {
        cache: Res<'w, PipelineCache>,
        prepass_pipeline: Res<'w, PrepassPipeline>,
        specialized: ResMut<'w, SpecializedMeshPipelines<GBufferPipelineSpecializer>>,
        /// Bevy's pipeline is a large struct of layouts: it is cloned when it changes, not per mesh.
        shared_prepass_pipeline: Local<'s, Option<Arc<PrepassPipeline>>>,
        /// Pipelines looked up in this frame; most meshes share theirs with many others.
        found: Local<'s, HashMap<PipelineQuery, GBufferPipeline>>,
        /// The last of these for each recent mesh kind.
        recent: Local<'s, Vec<Option<(PipelineQuery, GBufferPipeline)>>>,
        /// Hashes of all requested pipelines.
        requested: Local<'s, HashSet<u64>>,
        /// Errors that have been logged; each is logged once.
        reported: Local<'s, HashSet<String>>,
    }
}

/// Everything that determines the pipeline of a mesh. Material and layout are identified by address, which is valid for
/// one frame.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct PipelineQuery {
    material: usize,
    layout: usize,
    mesh_key: MeshPipelineKey,
    fragment_shader: AssetId<Shader>,
    output: MeshOutput,
}

/// State of the pipeline of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum GBufferPipeline {
    Ready(CachedRenderPipelineId),
    /// Not compiled yet; `None` if it is not requested yet.
    Pending(Option<CachedRenderPipelineId>),
    /// Compilation failed, and is retried if a shader changes; `None` if it never can succeed.
    Failed(Option<CachedRenderPipelineId>),
}

impl GBufferPipelines<'_, '_> {
    /// Call once per frame, before all other methods.
    pub(super) fn start_frame(&mut self) {
        self.found.clear();
        self.recent.clear();
        if self.are_of_another_device() {
            self.requested.clear();
        }
        if self.prepass_pipeline.is_changed() || self.shared_prepass_pipeline.is_none() {
            *self.shared_prepass_pipeline = Some(Arc::new(self.prepass_pipeline.clone()));
        }
    }

    /// True if the device was recreated, so that all known pipelines are invalid.
    pub(super) fn are_of_another_device(&self) -> bool {
        self.cache.is_added()
    }

    /// The pipeline that draws `mesh` with this `output`. Requests it if it is new.
    pub(super) fn get(
        &mut self,
        lookup: &MeshLookup,
        entity: MainEntity,
        mesh: &MeshToQueue,
        view_key: MeshPipelineKey,
        shaders: &MaterialShaders,
        output: MeshOutput,
    ) -> GBufferPipeline {
        let query = PipelineQuery {
            material: Arc::as_ptr(&mesh.material.properties).addr(),
            layout: Arc::as_ptr(&mesh.mesh.layout.0).addr(),
            mesh_key: mesh_key(lookup, entity, mesh, view_key, output),
            fragment_shader: shaders.fragment.id(),
            output,
        };
        if self.recent.is_empty() {
            self.recent.resize(RECENT_KINDS, None);
        }
        match self.recent[mesh.place] {
            Some((recent, pipeline)) if recent == query => return pipeline,
            _ => {}
        }
        let pipeline = match self.found.get(&query) {
            Some(found) => *found,
            None => {
                let key = pipeline_key(mesh, query.mesh_key, shaders, output);
                let pipeline = self.specialize(mesh, shaders, key);
                self.found.insert(query, pipeline);
                pipeline
            }
        };
        self.recent[mesh.place] = Some((query, pipeline));
        pipeline
    }

    /// True if this pipeline was requested before.
    pub(super) fn knows(
        &self,
        lookup: &MeshLookup,
        entity: MainEntity,
        mesh: &MeshToQueue,
        view_key: MeshPipelineKey,
        shaders: &MaterialShaders,
        output: MeshOutput,
    ) -> bool {
        let mesh_key = mesh_key(lookup, entity, mesh, view_key, output);
        let key = pipeline_key(mesh, mesh_key, shaders, output);
        (self.requested).contains(&FixedHasher.hash_one((&mesh.mesh.layout, key)))
    }

    fn specialize(
        &mut self,
        mesh: &MeshToQueue,
        shaders: &MaterialShaders,
        key: GBufferPipelineKey,
    ) -> GBufferPipeline {
        let Some(pipeline) = self.shared_prepass_pipeline.clone() else {
            return GBufferPipeline::Pending(None);
        };
        let layout = &mesh.mesh.layout;
        (self.requested).insert(FixedHasher.hash_one((layout, &key)));
        let specializer = GBufferPipelineSpecializer {
            pipeline,
            properties: mesh.material.properties.clone(),
            fragment_shader: shaders.fragment.clone(),
            vertex: shaders.vertex.clone(),
        };
        match (self.specialized).specialize(&self.cache, &specializer, key, layout) {
            Ok(id) => self.state(id),
            Err(error) => {
                let message = error.to_string();
                if self.reported.insert(message.clone()) {
                    error!("Forward draws meshes whose G-buffer pipeline failed: {message}");
                }
                GBufferPipeline::Failed(None)
            }
        }
    }

    pub(super) fn state(&self, id: CachedRenderPipelineId) -> GBufferPipeline {
        match self.cache.get_render_pipeline_state(id) {
            CachedPipelineState::Ok(_) => GBufferPipeline::Ready(id),
            // Bevy has logged the error, and compiles again when a shader changes.
            state if is_settled(state) => GBufferPipeline::Failed(Some(id)),
            _ => GBufferPipeline::Pending(Some(id)),
        }
    }
}

fn pipeline_key(
    mesh: &MeshToQueue,
    mesh_key: MeshPipelineKey,
    shaders: &MaterialShaders,
    output: MeshOutput,
) -> GBufferPipelineKey {
    let key = ErasedMaterialPipelineKey {
        type_id: mesh.material_id.type_id(),
        mesh_key: ErasedMeshPipelineKey::new(mesh_key),
        material_key: mesh.material.properties.material_key.clone(),
    };
    (key, shaders.fragment.id(), output)
}

fn mesh_key(
    lookup: &MeshLookup,
    entity: MainEntity,
    mesh: &MeshToQueue,
    view_key: MeshPipelineKey,
    output: MeshOutput,
) -> MeshPipelineKey {
    // Views share pipelines: those for any projection, and without motion vectors unless the mesh writes its own.
    let mut key = (view_key & MeshPipelineKey::INVERT_CULLING)
        | MeshPipelineKey::VIEW_PROJECTION_NONSTANDARD
        | MeshPipelineKey::from_msaa_samples(1)
        | MeshPipelineKey::DEFERRED_PREPASS
        | MeshPipelineKey::from_bits_retain(mesh.mesh.key_bits.bits())
        | alpha_mode_pipeline_key(mesh.material.properties.alpha_mode, &Msaa::Off);
    if lookup
        .visibility_ranges
        .entity_has_crossfading_visibility_ranges(entity)
    {
        key |= MeshPipelineKey::VISIBILITY_RANGE_DITHER;
    }
    if let Some(lightmap) = lookup.lightmapped_meshes.key(entity) {
        key |= lightmap;
    }
    if output.targets.contains(GBufferTargets::MOTION) {
        key |= MeshPipelineKey::MOTION_VECTOR_PREPASS;
        let flags = mesh.instance.flags();
        key.set(
            MeshPipelineKey::HAS_PREVIOUS_SKIN,
            flags.contains(RenderMeshInstanceFlags::HAS_PREVIOUS_SKIN),
        );
        key.set(
            MeshPipelineKey::HAS_PREVIOUS_MORPH,
            flags.contains(RenderMeshInstanceFlags::HAS_PREVIOUS_MORPH),
        );
    }
    key
}
