//! Dispatches lighting.

use bevy::{
    prelude::*,
    render::{
        render_resource::{ComputePassDescriptor, LoadOp, PipelineCache, RenderPassDescriptor},
        renderer::{RenderContext, ViewQuery},
        view::ViewTarget,
    },
};

use super::{state::ViewLighting, subsurface_light::SubsurfaceLight};
use crate::{
    gbuffer::GBufferTextures, gpu::timed::timed, shader_library::tiles, view::ActiveLeanView,
};

/// Views that the dispatch lights.
#[cfg(not(feature = "test_hooks"))]
type Dispatched = ();
#[cfg(feature = "test_hooks")]
type Dispatched = Without<super::fragment::FragmentLighting>;

/// Lights the G-buffer of a view into its main texture.
pub(crate) fn lighting_pass(
    view: ViewQuery<
        (&ViewLighting, &ViewTarget, Option<&SubsurfaceLight>),
        (With<ActiveLeanView>, With<GBufferTextures>, Dispatched),
    >,
    pipeline_cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (lighting, target, subsurface) = view.into_inner();
    let bindings = &lighting.bindings;
    let is_compiled = |id| pipeline_cache.get_compute_pipeline(id).is_some();
    if !lighting.pipelines.iter().all(|(_, id)| is_compiled(*id)) {
        return;
    }
    let (Some(view_group), Some(arrays_group), Some(targets_group)) = (
        bindings.view.get(),
        bindings.arrays.get(),
        bindings.targets_for(target.main_texture_view()),
    ) else {
        return;
    };

    // Requesting the attachment marks the texture as cleared for this frame; otherwise the next render pass would clear
    // what is written here. If a clear was due, lighting writes the background itself when it covers the whole target.
    let attachment = target.get_color_attachment();
    let must_clear = matches!(attachment.ops.load, LoadOp::Clear(_));
    let writes_background = must_clear && bindings.covers_target;
    timed(&mut ctx, "lean_deferred/lighting", &mut |ctx| {
        if must_clear && !writes_background {
            drop(ctx.begin_tracked_render_pass(RenderPassDescriptor {
                label: Some("lean_deferred/lighting/clear"),
                color_attachments: &[Some(attachment.clone())],
                ..default()
            }));
        }

        if let Some(list) = &lighting.tile_list {
            list.clear(ctx.command_encoder());
        }
        if let Some(subsurface) = subsurface {
            subsurface.clear_tiles(ctx.command_encoder());
        }
        let mut pass = ctx
            .command_encoder()
            .begin_compute_pass(&ComputePassDescriptor {
                label: Some("lean_deferred/lighting"),
                timestamp_writes: None,
            });
        let offset = bindings.uniform_offsets[usize::from(writes_background)];
        for (key, id) in &lighting.pipelines {
            let Some(pipeline) = pipeline_cache.get_compute_pipeline(*id) else {
                continue;
            };
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, view_group, &bindings.view_offsets);
            pass.set_bind_group(1, arrays_group, &[]);
            pass.set_bind_group(2, targets_group, &[offset]);
            if key.shaded.is_empty() {
                if let Some(group) = bindings.fill_list.get() {
                    pass.set_bind_group(3, group, &[]);
                }
                let count = tiles::count(bindings.viewport_size);
                pass.dispatch_workgroups(count.x, count.y, 1);
            } else if let (Some(list), Some(group)) =
                (&lighting.tile_list, bindings.read_list.get())
            {
                pass.set_bind_group(3, group, &[]);
                pass.dispatch_workgroups_indirect(list.dispatch(), 0);
            }
        }
    });
}
