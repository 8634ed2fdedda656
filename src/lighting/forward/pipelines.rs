//! Pipelines of meshes that Bevy's passes draw: Bevy's own, with the crate's fragment shader.

use bevy::{
    asset::load_embedded_asset,
    pbr::StandardMaterial,
    platform::collections::{HashMap, HashSet, hash_map::Entry},
    prelude::*,
    render::{
        render_resource::{
            CachedPipelineState, CachedRenderPipelineId, PipelineCache, PipelineDescriptor,
            RenderPipelineDescriptor,
        },
        renderer::RenderDevice,
    },
    shader::ShaderRef,
};

use super::{
    binding_numbers::LIGHT_LAYERS_GROUP, definitions::extend, layers::light_layers_layout,
    reasons::BevyLitReason,
};
use crate::gpu::{bind_group_cache::ResolvedLayout, pipeline_watch::PipelineWatch};

/// Label of these pipelines.
pub const PIPELINE_LABEL: &str = "lean_deferred/lighting/forward";

/// In the render world: the crate's pipelines, by Bevy's and by the layers of the mesh, if the view has light layers.
#[derive(Resource)]
pub(super) struct ForwardPipelines {
    by_bevys: HashMap<(CachedRenderPipelineId, Option<u32>), ForwardPipeline>,
    /// Those that were withheld in this frame.
    withheld: HashSet<(CachedRenderPipelineId, Option<u32>)>,
    shaders: ForwardShaders,
    /// Layout of the layers of lights; `None` on devices without a bind group for it.
    pub(super) layers_layout: Option<ResolvedLayout>,
    /// True if some pipeline reads the layers of lights.
    pub(super) has_layered: bool,
}

struct ForwardShaders {
    own: Handle<Shader>,
    /// Bevy's, of `StandardMaterial`.
    standard: Handle<Shader>,
}

enum ForwardPipeline {
    /// Bevy's pipeline is kept.
    Kept,
    Own {
        id: CachedRenderPipelineId,
        is_compiled: bool,
    },
}

/// The pipeline that is to draw a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PipelineChoice {
    /// Bevy's, until its description is known, from the next frame on; and while the crate's is withheld.
    NotKnownYet,
    /// Bevy's: the crate's is not compiled, or cannot draw the mesh.
    Bevys,
    Own(CachedRenderPipelineId),
}

/// Makes [`ForwardPipelines`] anew for a new device.
pub(super) fn init_forward_pipelines(
    mut commands: Commands,
    asset_server: Res<AssetServer>,
    pipeline_cache: Res<PipelineCache>,
    device: Res<RenderDevice>,
) {
    let standard = match StandardMaterial::fragment_shader() {
        ShaderRef::Path(path) => asset_server.load(path),
        ShaderRef::Handle(handle) => handle,
        // Then no pipeline has it, and Bevy lights all meshes.
        ShaderRef::Default => Handle::default(),
    };
    let groups = device.limits().max_bind_groups as usize;
    commands.insert_resource(ForwardPipelines {
        shaders: ForwardShaders {
            own: load_embedded_asset!(asset_server.as_ref(), "forward.wgsl"),
            standard,
        },
        layers_layout: (groups > LIGHT_LAYERS_GROUP)
            .then(|| ResolvedLayout::new(&pipeline_cache, light_layers_layout())),
        by_bevys: default(),
        withheld: default(),
        has_layered: false,
    });
}

impl ForwardPipelines {
    /// Looks at the pipelines again. Returns true if some of them were compiled, or a changed shader does not compile.
    pub(super) fn update(&mut self, cache: &PipelineCache) -> bool {
        self.withheld.clear();
        let mut has_changed = false;
        for pipeline in self.by_bevys.values_mut() {
            if let ForwardPipeline::Own { id, is_compiled } = pipeline {
                let state = cache.get_render_pipeline_state(*id);
                let is_now = matches!(state, CachedPipelineState::Ok(_));
                has_changed |= is_now != *is_compiled;
                *is_compiled = is_now;
            }
        }
        has_changed
    }

    /// Chooses between Bevy's pipeline and the crate's, which is requested if it is new and the budget of `watch` admits it.
    pub(super) fn choose(
        &mut self,
        (cache, watch): (&PipelineCache, &PipelineWatch),
        bevys: CachedRenderPipelineId,
        layers: Option<u32>,
    ) -> PipelineChoice {
        let key = (bevys, layers);
        let pipeline = match self.by_bevys.entry(key) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => {
                let cached = cache.pipelines().nth(bevys.id());
                let Some(PipelineDescriptor::RenderPipelineDescriptor(descriptor)) =
                    cached.map(|cached| &cached.descriptor)
                else {
                    return PipelineChoice::NotKnownYet;
                };
                let reason = BevyLitReason::of(descriptor, self.shaders.standard.id());
                let is_withheld =
                    reason.is_none() && (self.withheld.contains(&key) || !watch.budget.admits());
                if is_withheld {
                    self.withheld.insert(key);
                    return PipelineChoice::NotKnownYet;
                }
                new.insert(match reason {
                    Some(reason) => {
                        debug!("Bevy's fragment shader lights meshes of a lean view: {reason}");
                        ForwardPipeline::Kept
                    }
                    None => {
                        self.has_layered |= layers.is_some();
                        let own = lit_by_crate(descriptor, &self.shaders.own, layers);
                        ForwardPipeline::Own {
                            id: cache.queue_render_pipeline(own),
                            is_compiled: false,
                        }
                    }
                })
            }
        };
        match pipeline {
            ForwardPipeline::Own {
                id,
                is_compiled: true,
            } => PipelineChoice::Own(*id),
            ForwardPipeline::Own { .. } | ForwardPipeline::Kept => PipelineChoice::Bevys,
        }
    }
}

/// Bevy's pipeline with the fragment shader `own`.
fn lit_by_crate(
    bevys: &RenderPipelineDescriptor,
    own: &Handle<Shader>,
    layers: Option<u32>,
) -> RenderPipelineDescriptor {
    let mut descriptor = bevys.clone();
    descriptor.label = Some(PIPELINE_LABEL.into());
    if let Some(fragment) = &mut descriptor.fragment {
        fragment.shader = own.clone();
        fragment.entry_point = None;
        extend(&mut fragment.shader_defs, layers);
    }
    if layers.is_some() {
        descriptor.layout.push(light_layers_layout());
    }
    descriptor
}
