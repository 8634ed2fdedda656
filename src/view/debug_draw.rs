//! Draws debug views over the picture: their pipelines, the bind group of a view, and the pass.

use core::{hash::Hash, marker::PhantomData};

use bevy::{
    camera::{MainPassResolutionOverride, Viewport},
    core_pipeline::FullscreenShader,
    platform::collections::HashMap,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{
            BindGroupLayoutDescriptor, BlendState, CachedRenderPipelineId, ColorTargetState,
            ColorWrites, FragmentState, PipelineCache, RenderPassDescriptor,
            RenderPipelineDescriptor, TextureFormat,
        },
        renderer::{RenderContext, RenderDevice, ViewQuery},
        view::{ExtractedView, ViewTarget},
    },
    shader::ShaderDefVal,
};

use super::debug_view::LeanDebugView;
use crate::gpu::{
    bind_group_cache::{CachedBindGroup, Entries, ResolvedLayout},
    timed::timed,
};

/// Pipeline key of a debug view that is drawn over the picture, beside the target's format. The shader's fragment function is
/// `fragment`.
pub(crate) trait DebugDraw: Copy + Eq + Hash + Send + Sync + 'static {
    /// Label of the pass and of its pipelines.
    const LABEL: &'static str;
    /// Blends it with the colours of the picture, which it otherwise replaces.
    const BLEND: Option<BlendState> = None;
    /// It is drawn after upscaling, to the viewport of the camera, whatever the resolution of the main pass.
    const IS_AFTER_UPSCALING: bool = false;

    /// Layout of the bind group.
    fn layout(self) -> BindGroupLayoutDescriptor;

    fn shader_defs(self) -> Vec<ShaderDefVal>;
}

/// Pipelines by target and key. A pipeline is created on first use.
#[derive(Resource)]
pub(crate) struct DebugPipelines<D: DebugDraw> {
    shader: Handle<Shader>,
    fullscreen: FullscreenShader,
    by_key: HashMap<(TextureFormat, D), (CachedRenderPipelineId, ResolvedLayout)>,
}

/// On a view over which a `D` is drawn: its pipeline, which may still be compiling, and its bind group.
#[derive(Component)]
pub(crate) struct DebugDrawn<D: DebugDraw> {
    pipeline: CachedRenderPipelineId,
    group: CachedBindGroup,
    /// Offset of the uniform, if the bind group has one.
    offset: Option<u32>,
    of: PhantomData<D>,
}

impl<D: DebugDraw> DebugPipelines<D> {
    pub(crate) fn new(shader: Handle<Shader>, fullscreen: &FullscreenShader) -> Self {
        Self {
            shader,
            fullscreen: fullscreen.clone(),
            by_key: HashMap::default(),
        }
    }

    fn get(
        &mut self,
        cache: &PipelineCache,
        format: TextureFormat,
        key: D,
    ) -> (CachedRenderPipelineId, &ResolvedLayout) {
        let (pipeline, layout) = self.by_key.entry((format, key)).or_insert_with(|| {
            let layout = ResolvedLayout::new(cache, key.layout());
            let pipeline = cache.queue_render_pipeline(RenderPipelineDescriptor {
                label: Some(D::LABEL.into()),
                layout: vec![layout.descriptor().clone()],
                vertex: self.fullscreen.to_vertex_state(),
                fragment: Some(FragmentState {
                    shader: self.shader.clone(),
                    shader_defs: key.shader_defs(),
                    entry_point: Some("fragment".into()),
                    targets: vec![Some(ColorTargetState {
                        format,
                        blend: D::BLEND,
                        write_mask: match D::BLEND {
                            Some(_) => ColorWrites::COLOR,
                            None => ColorWrites::ALL,
                        },
                    })],
                }),
                ..default()
            });
            (pipeline, layout)
        });
        (*pipeline, layout)
    }

    /// Sets what is drawn over a view: `key`, with the bindings that `fill` pushes and the uniform at `offset`.
    pub(crate) fn set(
        &mut self,
        commands: &mut Commands,
        device: &RenderDevice,
        cache: &PipelineCache,
        (entity, view): (Entity, &ExtractedView),
        drawn: Option<Mut<DebugDrawn<D>>>,
        (key, offset): (D, Option<u32>),
        fill: impl FnOnce(&mut Entries) -> Option<()>,
    ) {
        let (pipeline, layout) = self.get(cache, view.target_format, key);
        let mut new = None;
        let drawn = match drawn {
            Some(drawn) => drawn.into_inner(),
            None => new.insert(DebugDrawn {
                pipeline,
                group: CachedBindGroup::default(),
                offset,
                of: PhantomData,
            }),
        };
        drawn.pipeline = pipeline;
        drawn.offset = offset;
        drawn.group.update(device, layout, fill);
        if let Some(new) = new {
            commands.entity(entity).insert(new);
        }
    }
}

/// Draws a `D` over the part of the viewport that shows the debug view.
pub(crate) fn draw_debug_view<D: DebugDraw>(
    view: ViewQuery<(
        &DebugDrawn<D>,
        &LeanDebugView,
        &ViewTarget,
        &ExtractedCamera,
        Option<&MainPassResolutionOverride>,
    )>,
    cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (drawn, debug_view, target, camera, resolution_override) = view.into_inner();
    let (Some(pipeline), Some(group)) =
        (cache.get_render_pipeline(drawn.pipeline), drawn.group.get())
    else {
        return;
    };
    let picture = target.main_texture();
    let picture_size = UVec2::new(picture.width(), picture.height());
    let resolution_override = resolution_override.filter(|_| !D::IS_AFTER_UPSCALING);
    let viewport =
        Viewport::from_viewport_and_override(camera.viewport.as_ref(), resolution_override)
            .unwrap_or_else(|| Viewport {
                physical_size: picture_size,
                ..default()
            });
    let origin = viewport.physical_position;
    let columns = debug_view.columns(viewport.physical_size.x);
    let shown = UVec2::new(columns, viewport.physical_size.y);
    // A viewport may lag behind a target that is resized: scissors must not exceed it.
    let shown = shown.min(picture_size.saturating_sub(origin));
    if shown.min_element() == 0 {
        return;
    }
    timed(&mut ctx, D::LABEL, &mut |ctx| {
        let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some(D::LABEL),
            // Views with MSAA show only what comes after tonemapping, which has resolved it.
            color_attachments: &[Some(target.get_unsampled_color_attachment())],
            ..default()
        });
        pass.set_camera_viewport(&viewport);
        pass.set_scissor_rect(origin.x, origin.y, shown.x, shown.y);
        pass.set_render_pipeline(pipeline);
        pass.set_bind_group(0, group, drawn.offset.as_slice());
        pass.draw(0..3, 0..1);
    });
}
