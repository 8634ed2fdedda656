//! Pipelines of meshes that Bevy's passes draw: Bevy's own, with the crate's fragment shader.

use bevy::{
    asset::load_embedded_asset,
    pbr::StandardMaterial,
    platform::collections::{HashMap, HashSet, hash_map::Entry},
    prelude::*,
    render::{
        render_resource::{
            CachedPipelineState, CachedRenderPipelineId, PipelineCache, PipelineDescriptor,
            RenderPipelineDescriptor, ShaderStages, WgpuLimits,
        },
        renderer::RenderDevice,
    },
    shader::ShaderRef,
};

use super::{
    definitions::extend,
    own_group::{OwnLayouts, own_layout},
    reasons::{BevyLitReason, calls_light_functions},
};
use crate::gpu::{layout_limits::excess, pipeline_watch::PipelineWatch};

/// Label of these pipelines.
pub const PIPELINE_LABEL: &str = "lean_deferred/lighting/forward";

/// A pipeline of the crate's, in place of one of Bevy's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Variant {
    pub(super) bevys: CachedRenderPipelineId,
    /// The layers of the mesh, if the view has light layers.
    pub(super) layers: Option<u32>,
    /// True if the mesh reflects the picture.
    pub(super) reflects: bool,
}

/// In the render world: the crate's pipelines.
#[derive(Resource)]
pub(crate) struct ForwardPipelines {
    variants: HashMap<Variant, ForwardPipeline>,
    /// Those that were withheld in this frame.
    withheld: HashSet<Variant>,
    shaders: ForwardShaders,
    limits: WgpuLimits,
    /// Layouts of the crate's own bind group; `None` on devices without one for it.
    pub(super) layouts: Option<OwnLayouts>,
    /// True if some pipeline reads the layers of lights alone.
    pub(super) has_layered: bool,
    /// True if some pipeline traces reflections.
    pub(super) has_reflecting: bool,
}

struct ForwardShaders {
    own: Handle<Shader>,
    /// Bevy's, of `StandardMaterial`.
    standard: Handle<Shader>,
}

enum ForwardPipeline {
    /// Bevy's pipeline is kept.
    Kept,
    /// The device has too few bindings for reflections beside those of the material.
    TooManyBindings,
    Own {
        id: CachedRenderPipelineId,
        is_compiled: bool,
    },
}

/// A pipeline of the crate's that is compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct OwnPipeline {
    pub(super) id: CachedRenderPipelineId,
    /// True if it traces reflections.
    pub(super) reflects: bool,
}

/// The pipeline that is to draw a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PipelineChoice {
    /// `None` for Bevy's: the crate's is not compiled, or cannot draw the mesh.
    pub(super) own: Option<OwnPipeline>,
    /// False if the mesh is to be looked at again in the next frame: the description of Bevy's is not known before, or the crate's was
    /// withheld.
    pub(super) is_known: bool,
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
    commands.insert_resource(ForwardPipelines {
        shaders: ForwardShaders {
            own: load_embedded_asset!(asset_server.as_ref(), "forward.wgsl"),
            standard,
        },
        limits: device.limits(),
        layouts: OwnLayouts::new(&pipeline_cache, &device),
        variants: default(),
        withheld: default(),
        has_layered: false,
        has_reflecting: false,
    });
}

impl ForwardPipelines {
    /// Looks at the pipelines again. Returns true if some of them were compiled, or a changed shader does not compile.
    pub(super) fn update(&mut self, cache: &PipelineCache) -> bool {
        self.withheld.clear();
        let mut has_changed = false;
        for pipeline in self.variants.values_mut() {
            if let ForwardPipeline::Own { id, is_compiled } = pipeline {
                let state = cache.get_render_pipeline_state(*id);
                let is_now = matches!(state, CachedPipelineState::Ok(_));
                has_changed |= is_now != *is_compiled;
                *is_compiled = is_now;
            }
        }
        has_changed
    }

    /// Chooses between Bevy's pipeline and the crate's, which is requested if it is new and the budget of `watch` admits it. While that with
    /// reflections is not ready, one without them that was requested earlier stands in.
    pub(super) fn choose(
        &mut self,
        cache_and_watch: (&PipelineCache, &PipelineWatch),
        wanted: Variant,
    ) -> PipelineChoice {
        let without = Variant {
            reflects: false,
            ..wanted
        };
        self.request(cache_and_watch, wanted);
        let mut is_known = self.variants.contains_key(&wanted);
        if let Some(ForwardPipeline::TooManyBindings) = self.variants.get(&wanted) {
            self.request(cache_and_watch, without);
            is_known = self.variants.contains_key(&without);
        }
        let mut candidates = [wanted, without].into_iter();
        let own = candidates.find_map(|variant| match self.variants.get(&variant) {
            Some(&ForwardPipeline::Own {
                id,
                is_compiled: true,
            }) => Some(OwnPipeline {
                id,
                reflects: variant.reflects,
            }),
            _ => None,
        });
        PipelineChoice { own, is_known }
    }

    /// Requests a pipeline that is new, unless the budget of `watch` withholds it or the description of Bevy's is not known yet.
    fn request(&mut self, (cache, watch): (&PipelineCache, &PipelineWatch), variant: Variant) {
        let Entry::Vacant(new) = self.variants.entry(variant) else {
            return;
        };
        let cached = cache.pipelines().nth(variant.bevys.id());
        let Some(PipelineDescriptor::RenderPipelineDescriptor(descriptor)) =
            cached.map(|cached| &cached.descriptor)
        else {
            return;
        };
        let reason = BevyLitReason::of(descriptor, self.shaders.standard.id());
        // Shaders of apps that call the light functions are compiled again for reflections alone.
        let keeps_shader = variant.reflects
            && reason == Some(BevyLitReason::OtherShader)
            && calls_light_functions(descriptor);
        if let Some(reason) = reason
            && !keeps_shader
        {
            debug!("Bevy's fragment shader lights meshes of a lean view: {reason}");
            new.insert(ForwardPipeline::Kept);
            return;
        }
        let own = (!keeps_shader).then_some(&self.shaders.own);
        let own = lit_by_crate(descriptor, own, variant);
        let entries = own.layout.iter().flat_map(|layout| &layout.entries);
        let entries = entries.filter(|entry| entry.visibility.contains(ShaderStages::FRAGMENT));
        let lacking = excess(entries, &self.limits);
        if variant.reflects && lacking > 0 {
            warn_once!(
                "some forward meshes do not reflect the image (`LeanScreenSpaceReflectionsAdvanced::forward_meshes`), but environment maps \
                 and ambient light alone: their material leaves {lacking} bindings too few on this device. Remove as many of its textures"
            );
            new.insert(ForwardPipeline::TooManyBindings);
            return;
        }
        if self.withheld.contains(&variant) || !watch.budget.admits() {
            self.withheld.insert(variant);
            return;
        }
        self.has_layered |= variant.layers.is_some() && !variant.reflects;
        self.has_reflecting |= variant.reflects;
        new.insert(ForwardPipeline::Own {
            id: cache.queue_render_pipeline(own),
            is_compiled: false,
        });
    }
}

/// Bevy's pipeline with the fragment shader `own`, or with its own shader, which calls the light functions.
fn lit_by_crate(
    bevys: &RenderPipelineDescriptor,
    own: Option<&Handle<Shader>>,
    variant: Variant,
) -> RenderPipelineDescriptor {
    let mut descriptor = bevys.clone();
    descriptor.label = Some(PIPELINE_LABEL.into());
    if let Some(fragment) = &mut descriptor.fragment {
        // Shaders of apps do not enter the layers of a mesh.
        let layers = variant.layers.filter(|_| own.is_some());
        if let Some(own) = own {
            fragment.shader = own.clone();
            fragment.entry_point = None;
        }
        extend(&mut fragment.shader_defs, layers, variant.reflects);
    }
    if variant.layers.is_some() || variant.reflects {
        let layout = own_layout(variant.layers.is_some(), variant.reflects);
        descriptor.layout.push(layout);
    }
    descriptor
}
