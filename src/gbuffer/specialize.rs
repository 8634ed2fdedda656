//! Looks up the pipeline that draws a mesh into the G-buffer, or specializes it.

use core::hash::BuildHasher;

use alloc::sync::Arc;

use bevy::{
    material::{
        RenderPhaseType,
        key::{ErasedMaterialPipelineKey, ErasedMeshPipelineKey},
    },
    pbr::{
        DeferredVertexShader, MeshPipelineKey, PrepassPipeline, RenderMeshInstanceFlags,
        alpha_mode_pipeline_key,
    },
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
    lookup::{MeshKind, MeshLookup, MeshToQueue, RECENT_KINDS},
    masked::{DrawnPart, MaskedPipelines},
    pipeline::{GBufferPipelineKey, GBufferPipelineSpecializer},
    placement::MeshOutput,
    registration::MaterialShaders,
};
use crate::{
    gpu::{
        named::system_param,
        pipeline_watch::{PipelineWatch, is_settled},
    },
    view::GBufferTargets,
};

system_param! {
    /// The pipelines of the G-buffer, with what is needed to specialize them.
    pub(super) struct GBufferPipelines<'w, 's> {
        cache: ResMut<'w, PipelineCache>,
        prepass_pipeline: Res<'w, PrepassPipeline>,
        specialized: ResMut<'w, SpecializedMeshPipelines<GBufferPipelineSpecializer>>,
        /// Bevy's pipeline is a large struct of layouts: it is cloned when it changes, not per mesh.
        shared_prepass_pipeline: Local<'s, Option<Arc<PrepassPipeline>>>,
        /// Pipelines looked up in this frame; most meshes share theirs with many others.
        found: Local<'s, HashMap<PipelineQuery, GBufferPipeline>>,
        /// The last of these for each recent mesh kind.
        recent: Local<'s, Vec<Option<(PipelineQuery, GBufferPipeline)>>>,
        requested: ResMut<'w, RequestedPipelines>,
        masked: ResMut<'w, MaskedPipelines>,
        watch: Res<'w, PipelineWatch>,
        /// Errors that have been logged; each is logged once.
        reported: Local<'s, HashSet<String>>,
    }
}

/// Hashes of the pipelines that were requested, and of those that were withheld in this frame.
#[derive(Resource, Default)]
pub(super) struct RequestedPipelines {
    all: HashSet<u64>,
    withheld: HashSet<u64>,
}

impl RequestedPipelines {
    /// True if the pipeline is requested, or may be: within the budget of the frame.
    fn admit(&mut self, pipeline: u64, watch: &PipelineWatch) -> bool {
        if self.all.contains(&pipeline) {
            return true;
        }
        if self.withheld.contains(&pipeline) {
            return false;
        }
        let is_admitted = watch.budget.admits();
        let set = if is_admitted {
            &mut self.all
        } else {
            &mut self.withheld
        };
        set.insert(pipeline);
        is_admitted
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

/// The parts of a mesh that determine its pipelines on a view: material and layout by address, and the bits of mesh and instance.
pub(super) type MeshKindKey = (usize, usize, MeshPipelineKey);

/// Returns the kind of a mesh. Valid for one frame.
pub(super) fn kind_key(lookup: &MeshLookup, entity: MainEntity, mesh: &MeshToQueue) -> MeshKindKey {
    let key = MeshPipelineKey::from_bits_retain(mesh.mesh.key_bits.bits());
    (
        Arc::as_ptr(&mesh.material.properties).addr(),
        Arc::as_ptr(&mesh.mesh.layout.0).addr(),
        key | instance_key(lookup, entity, mesh),
    )
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
    /// Call once per frame, before all systems that have these pipelines.
    pub(super) fn start_frame(&mut self) {
        self.requested.withheld.clear();
        if self.are_of_another_device() {
            self.requested.all.clear();
            self.masked.clear();
        }
        self.start();
    }

    /// Call once per frame and system, before all other methods.
    pub(super) fn start(&mut self) {
        self.found.clear();
        self.recent.clear();
        if self.prepass_pipeline.is_changed() || self.shared_prepass_pipeline.is_none() {
            *self.shared_prepass_pipeline = Some(Arc::new(self.prepass_pipeline.clone()));
        }
    }

    pub(super) fn compile_in_background(&self) -> bool {
        self.watch.compiles_in_background()
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
        let instance = instance_key(lookup, entity, mesh);
        let query = query(mesh, instance, view_key, shaders, output);
        if self.recent.is_empty() {
            self.recent.resize(RECENT_KINDS, None);
        }
        match self.recent[mesh.place] {
            Some((recent, pipeline)) if recent == query => return pipeline,
            _ => {}
        }
        let pipeline = self.find(mesh, shaders, query);
        self.recent[mesh.place] = Some((query, pipeline));
        pipeline
    }

    /// As [`get`](Self::get), for an instance with these key bits that need not exist yet.
    pub(super) fn get_for(
        &mut self,
        mesh: &MeshKind,
        instance: MeshPipelineKey,
        view_key: MeshPipelineKey,
        shaders: &MaterialShaders,
        output: MeshOutput,
    ) -> GBufferPipeline {
        let query = query(mesh, instance, view_key, shaders, output);
        self.find(mesh, shaders, query)
    }

    fn find(
        &mut self,
        mesh: &MeshKind,
        shaders: &MaterialShaders,
        query: PipelineQuery,
    ) -> GBufferPipeline {
        if let Some(found) = self.found.get(&query) {
            return *found;
        }
        let key = self.pipeline_key(mesh, query.mesh_key, shaders, query.output);
        let pipeline = self.specialize(mesh, shaders, key);
        self.found.insert(query, pipeline);
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
        let instance = instance_key(lookup, entity, mesh);
        let mesh_key = mesh_key(mesh, instance, view_key, output);
        let key = self.pipeline_key(mesh, mesh_key, shaders, output);
        (self.requested.all).contains(&FixedHasher.hash_one((&mesh.mesh.layout, key)))
    }

    fn specialize(
        &mut self,
        mesh: &MeshKind,
        shaders: &MaterialShaders,
        key: GBufferPipelineKey,
    ) -> GBufferPipeline {
        let Some(pipeline) = self.shared_prepass_pipeline.clone() else {
            return GBufferPipeline::Pending(None);
        };
        let layout = &mesh.mesh.layout;
        let hash = FixedHasher.hash_one((layout, &key));
        let is_new = !self.requested.all.contains(&hash);
        if !self.requested.admit(hash, &self.watch) {
            return GBufferPipeline::Pending(None);
        }
        let mut specializer = GBufferPipelineSpecializer {
            pipeline,
            properties: mesh.material.properties.clone(),
            fragment_shader: shaders.fragment.clone(),
            vertex: shaders.vertex.clone(),
        };
        let depth_shader = (shaders.masked_depth.as_ref()).filter(|_| key.3 == DrawnPart::AtDepth);
        let depth = depth_shader.map(|shader| {
            let key = (key.0.clone(), shader.id(), key.2, DrawnPart::Depth);
            (key, shader.clone())
        });
        let mut specialized = (self.specialized).specialize(&self.cache, &specializer, key, layout);
        if let (Some((key, shader)), Ok(targets)) = (depth, &specialized) {
            let targets = *targets;
            specializer.fragment_shader = shader;
            let depth = (self.specialized).specialize(&self.cache, &specializer, key, layout);
            specialized = depth.map(|depth| {
                self.masked.insert(targets, depth);
                targets
            });
        }
        match specialized {
            Ok(id) => {
                // If Bevy compiles within the frame, it does so now: otherwise forward would draw the mesh in this frame,
                // by a pipeline that has to be compiled too.
                if is_new && !self.compile_in_background() {
                    self.cache.process_queue();
                }
                self.state(id)
            }
            Err(error) => {
                let message = error.to_string();
                if self.reported.insert(message.clone()) {
                    error!("Forward draws meshes whose G-buffer pipeline failed: {message}");
                }
                GBufferPipeline::Failed(None)
            }
        }
    }

    fn pipeline_key(
        &self,
        mesh: &MeshKind,
        mesh_key: MeshPipelineKey,
        shaders: &MaterialShaders,
        output: MeshOutput,
    ) -> GBufferPipelineKey {
        let properties = &mesh.material.properties;
        let is_bevys_vertex_stage =
            shaders.vertex.is_none() && properties.get_shader(DeferredVertexShader).is_none();
        let is_masked = matches!(properties.render_phase_type, RenderPhaseType::AlphaMask);
        let depth_first = is_masked
            && self.masked.are_in_use()
            && shaders.masked_depth.is_some()
            && is_bevys_vertex_stage;
        let part = if depth_first {
            DrawnPart::AtDepth
        } else {
            DrawnPart::Whole
        };
        let key = material_pipeline_key(mesh, mesh_key);
        (key, shaders.fragment.id(), output, part)
    }

    /// State of the pipeline, and of the one that draws depth before it.
    pub(super) fn state(&self, id: CachedRenderPipelineId) -> GBufferPipeline {
        let all = core::iter::once(id).chain(self.masked.depth(id));
        let mut state = GBufferPipeline::Ready(id);
        for part in all {
            match self.cache.get_render_pipeline_state(part) {
                CachedPipelineState::Ok(_) => {}
                // Bevy has logged the error, and compiles again when a shader changes.
                part if is_settled(part) => return GBufferPipeline::Failed(Some(id)),
                _ => state = GBufferPipeline::Pending(Some(id)),
            }
        }
        state
    }
}

fn query(
    mesh: &MeshKind,
    instance: MeshPipelineKey,
    view_key: MeshPipelineKey,
    shaders: &MaterialShaders,
    output: MeshOutput,
) -> PipelineQuery {
    PipelineQuery {
        material: Arc::as_ptr(&mesh.material.properties).addr(),
        layout: Arc::as_ptr(&mesh.mesh.layout.0).addr(),
        mesh_key: mesh_key(mesh, instance, view_key, output),
        fragment_shader: shaders.fragment.id(),
        output,
    }
}

/// Bevy's key of a pipeline for meshes of this material.
pub(super) fn material_pipeline_key(
    mesh: &MeshKind,
    mesh_key: MeshPipelineKey,
) -> ErasedMaterialPipelineKey {
    ErasedMaterialPipelineKey {
        type_id: mesh.material_id.type_id(),
        mesh_key: ErasedMeshPipelineKey::new(mesh_key),
        material_key: mesh.material.properties.material_key.clone(),
    }
}

/// Key bits of instances that have a previous skin or morph. Only pipelines that write motion have them.
pub(super) const PREVIOUS: MeshPipelineKey =
    MeshPipelineKey::HAS_PREVIOUS_SKIN.union(MeshPipelineKey::HAS_PREVIOUS_MORPH);

/// Key bits of an instance beside those of its mesh and material.
pub(super) fn instance_key(
    lookup: &MeshLookup,
    entity: MainEntity,
    mesh: &MeshToQueue,
) -> MeshPipelineKey {
    let mut key = MeshPipelineKey::empty();
    if lookup
        .visibility_ranges
        .entity_has_crossfading_visibility_ranges(entity)
    {
        key |= MeshPipelineKey::VISIBILITY_RANGE_DITHER;
    }
    if let Some(lightmap) = lookup.lightmapped_meshes.key(entity) {
        key |= lightmap;
    }
    let flags = mesh.instance.flags();
    key.set(
        MeshPipelineKey::HAS_PREVIOUS_SKIN,
        flags.contains(RenderMeshInstanceFlags::HAS_PREVIOUS_SKIN),
    );
    key.set(
        MeshPipelineKey::HAS_PREVIOUS_MORPH,
        flags.contains(RenderMeshInstanceFlags::HAS_PREVIOUS_MORPH),
    );
    key
}

fn mesh_key(
    mesh: &MeshKind,
    instance: MeshPipelineKey,
    view_key: MeshPipelineKey,
    output: MeshOutput,
) -> MeshPipelineKey {
    // Views share pipelines: those for any projection, and without motion vectors unless the mesh writes its own.
    let key = (view_key & MeshPipelineKey::INVERT_CULLING)
        | MeshPipelineKey::VIEW_PROJECTION_NONSTANDARD
        | MeshPipelineKey::from_msaa_samples(1)
        | MeshPipelineKey::DEFERRED_PREPASS
        | MeshPipelineKey::from_bits_retain(mesh.mesh.key_bits.bits())
        | alpha_mode_pipeline_key(mesh.material.properties.alpha_mode, &Msaa::Off);
    if output.targets.contains(GBufferTargets::MOTION) {
        key | instance | MeshPipelineKey::MOTION_VECTOR_PREPASS
    } else {
        key | (instance - PREVIOUS)
    }
}
