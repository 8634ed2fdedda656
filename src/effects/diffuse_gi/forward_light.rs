//! Light of meshes in Bevy's forward passes, on views with a depth prepass. Without the prepass, this frame's GI would not know
//! their depth.

use bevy::{
    asset::load_embedded_asset,
    core_pipeline::prepass::DepthPrepass,
    prelude::*,
    render::{
        render_resource::{
            BindGroup, CachedComputePipelineId, ComputePipelineDescriptor, IntoBinding,
            PipelineCache, ShaderStages, StorageTextureAccess, TextureFormat, TextureSampleType,
            binding_types::{texture_2d, texture_depth_2d, texture_storage_2d, uniform_buffer},
        },
        renderer::{RenderContext, RenderDevice, ViewQuery},
        view::{ViewDepthTexture, ViewTarget},
    },
};

use super::{
    active::ActiveGi,
    binding_numbers::{DEPTH_TEXTURE, DIFFUSE_LIGHT_OUTPUT, NORMAL_TEXTURE, PICTURE_TEXTURE, VIEW},
    prepare::{GiUniforms, ViewGi},
    uniforms::GiUniform,
};
use crate::{
    gbuffer::GBufferTextures,
    gpu::{
        bind_group_cache::ResolvedLayout,
        bindings::layout,
        picture_bind_groups::PictureBindGroups,
        timed::{Dispatch, timed_dispatch},
    },
    shader_library::tiles,
    view::{ActiveLeanView, DiffuseLight, LightingIo},
};

const LABEL: &str = "lean_deferred/effects/diffuse_gi/forward_light";

/// The pipeline is created when the first view needs it.
#[derive(Resource)]
pub(super) struct ForwardLightPipeline {
    shader: Handle<Shader>,
    queued: Option<(ResolvedLayout, CachedComputePipelineId)>,
}

pub(super) fn init_forward_light_pipeline(mut commands: Commands, asset_server: Res<AssetServer>) {
    commands.insert_resource(ForwardLightPipeline {
        shader: load_embedded_asset!(asset_server.as_ref(), "forward_light.wgsl"),
        queued: None,
    });
}

impl ForwardLightPipeline {
    /// Queues the pipeline for compilation, once.
    fn queue(&mut self, cache: &PipelineCache) -> &ResolvedLayout {
        let shader = &self.shader;
        let (layout, _) = self.queued.get_or_insert_with(|| {
            let words = texture_2d(TextureSampleType::Uint);
            let floats = texture_2d(TextureSampleType::Float { filterable: false });
            let output =
                texture_storage_2d(TextureFormat::R32Uint, StorageTextureAccess::WriteOnly);
            let entries = [
                (VIEW, uniform_buffer::<GiUniform>(true)),
                (DEPTH_TEXTURE, texture_depth_2d()),
                (NORMAL_TEXTURE, words),
                (PICTURE_TEXTURE, floats),
                (DIFFUSE_LIGHT_OUTPUT, output),
            ];
            let layout = ResolvedLayout::new(cache, layout(LABEL, ShaderStages::COMPUTE, entries));
            let pipeline = cache.queue_compute_pipeline(ComputePipelineDescriptor {
                label: Some(LABEL.into()),
                layout: vec![layout.descriptor().clone()],
                shader: shader.clone(),
                entry_point: Some("main".into()),
                ..default()
            });
            (layout, pipeline)
        });
        layout
    }
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
    cache: Res<PipelineCache>,
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
        let layout = pipeline.queue(&cache);
        held.0.update(&device, layout, target, |entries, picture| {
            entries.push(VIEW, uniforms.clone())?;
            entries.push(DEPTH_TEXTURE, depth.view().into_binding())?;
            entries.push(NORMAL_TEXTURE, gbuffer.normal.default_view.into_binding())?;
            entries.push(PICTURE_TEXTURE, picture.into_binding())?;
            entries.push(DIFFUSE_LIGHT_OUTPUT, light.0.default_view.into_binding())
        });
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
    let queued = pipeline
        .as_ref()
        .and_then(|pipeline| pipeline.queued.as_ref());
    let pipeline = queued.and_then(|(_, pipeline)| cache.get_compute_pipeline(*pipeline));
    let group = held.0.of(target.main_texture());
    let (Some(pipeline), Some(group)) = (pipeline, group) else {
        return;
    };
    if lean.io.contains(LightingIo::DIFFUSE_LIGHT) {
        let dispatch = Dispatch {
            label: LABEL,
            pipeline,
            group,
            offset: gi.offset,
            workgroups: tiles::count(gi.viewport_size),
        };
        timed_dispatch(&mut ctx, &dispatch);
    }
}
