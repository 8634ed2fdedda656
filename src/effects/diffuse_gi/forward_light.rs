//! Light of meshes in Bevy's forward passes, on views with a depth prepass. Without the prepass, this frame's GI would not know
//! their depth.

use core::slice;

use bevy::{
    asset::load_embedded_asset,
    core_pipeline::prepass::DepthPrepass,
    prelude::*,
    render::{
        render_resource::{BindGroup, IntoBinding, PipelineCache},
        renderer::{RenderContext, RenderDevice, ViewQuery},
        view::{ViewDepthTexture, ViewTarget},
    },
};

use super::{
    active::ActiveGi,
    binding_numbers::{DEPTH_TEXTURE, DIFFUSE_LIGHT_OUTPUT, NORMAL_TEXTURE, PICTURE_TEXTURE, VIEW},
    pipelines::binding_kind,
    prepare::GiUniforms,
    textures::ViewGi,
};
use crate::{
    gbuffer::GBufferTextures,
    gpu::{
        effect_pipelines::{ComputePass, EffectKey, EffectPipelines},
        picture_bind_groups::PictureBindGroups,
        pipeline_watch::PipelineWatch,
        timed::timed_dispatches,
    },
    shader_library::tiles,
    view::{ActiveLeanView, DiffuseLight, LightingIo, Prewarming},
};

const LABEL: &str = "lean_deferred/effects/diffuse_gi/forward_light";

const PASSES: [ComputePass; 1] = [ComputePass {
    label: LABEL,
    shader: |assets| load_embedded_asset!(assets, "forward_light.wgsl"),
    entry: "main",
    defs: &[],
    key_defs: &[],
    reads: &[VIEW, DEPTH_TEXTURE, NORMAL_TEXTURE, PICTURE_TEXTURE],
    writes: &[DIFFUSE_LIGHT_OUTPUT],
}];

/// The pass is compiled in one way, once the first view needs it.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct ForwardLightKey;

impl EffectKey for ForwardLightKey {}

type ForwardLightPipeline = EffectPipelines<ForwardLightKey>;

pub(super) fn init_forward_light_pipeline(mut commands: Commands, asset_server: Res<AssetServer>) {
    commands.insert_resource(ForwardLightPipeline::new(
        &asset_server,
        &PASSES,
        binding_kind,
    ));
}

/// On a view whose forward meshes emit light into GI.
#[derive(Component, Default)]
pub struct ForwardLight(PictureBindGroups);

impl ForwardLight {
    /// Bind groups that are reused across frames while nothing changes.
    pub fn lasting_bind_groups(&self) -> impl Iterator<Item = &BindGroup> {
        self.0.all()
    }
}

/// Inserts or removes [`ForwardLight`], and updates its bind groups.
pub(super) fn prepare_forward_light(
    mut commands: Commands,
    device: Res<RenderDevice>,
    (cache, watch, prewarming): (Res<PipelineCache>, Res<PipelineWatch>, Res<Prewarming>),
    pipeline: Option<ResMut<ForwardLightPipeline>>,
    uniforms: Res<GiUniforms>,
    mut views: Query<
        (
            Entity,
            (Has<DepthPrepass>, Has<ViewGi>),
            (&GBufferTextures, &ViewDepthTexture),
            (&ViewTarget, Option<&DiffuseLight>),
            Option<&mut ForwardLight>,
        ),
        With<ActiveGi>,
    >,
) {
    let (Some(mut pipeline), Some(uniforms)) = (pipeline, uniforms.binding()) else {
        return;
    };
    // The view may get a prepass later.
    if prewarming.is_active() && !views.is_empty() {
        pipeline.specialize(&cache, &watch, ForwardLightKey);
    }
    for (entity, asked, (gbuffer, depth), (target, light), held) in &mut views {
        let (true, Some(light)) = (asked == (true, true), light) else {
            if held.is_some() {
                commands.entity(entity).remove::<ForwardLight>();
            }
            continue;
        };
        let mut made = None;
        let held = match held {
            Some(held) => held.into_inner(),
            None => made.insert(ForwardLight::default()),
        };
        for layout in pipeline.specialize(&cache, &watch, ForwardLightKey) {
            held.0.bind(&device, layout, target, |binding, picture| {
                Some(match binding {
                    VIEW => uniforms.clone(),
                    DEPTH_TEXTURE => depth.view().into_binding(),
                    NORMAL_TEXTURE => gbuffer.normal.default_view.into_binding(),
                    PICTURE_TEXTURE => picture.into_binding(),
                    DIFFUSE_LIGHT_OUTPUT => light.texture.default_view.into_binding(),
                    _ => return None,
                })
            });
        }
        if let Some(made) = made {
            commands.entity(entity).insert(made);
        }
    }
}

/// Runs after the opaque meshes.
pub(super) fn add_forward_light(
    view: ViewQuery<(&ForwardLight, &ViewGi, &ActiveLeanView, &ViewTarget)>,
    cache: Res<PipelineCache>,
    pipeline: Option<Res<ForwardLightPipeline>>,
    mut ctx: RenderContext,
) {
    let (held, gi, lean, target) = view.into_inner();
    let Some(pipeline) = pipeline else {
        return;
    };
    if !lean.io.contains(LightingIo::DIFFUSE_LIGHT) {
        return;
    }
    let group = held.0.of(target.main_texture());
    let offsets = slice::from_ref(&gi.offset);
    let workgroups = tiles::count(gi.viewport_size);
    let dispatches: [_; PASSES.len()] =
        pipeline.dispatches(&cache, ForwardLightKey, |_| (group, offsets, workgroups));
    timed_dispatches(&mut ctx, LABEL, None, &dispatches);
}
