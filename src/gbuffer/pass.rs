//! The raster pass. Where it stands in the frame depends on the view:
//!
//! - No prepass: once, after Bevy has built the indirect draws for the main passes.
//! - A depth prepass, which something else asked for: in its place, so that what reads depth between prepass and main
//!   pass (Bevy's SSAO, contact shadows) finds the lean meshes there.
//! - With `OcclusionCulling` twice: what was visible last frame, then what the depth of that does not hide.

use bevy::{
    camera::{MainPassResolutionOverride, Viewport},
    core_pipeline::prepass::ViewPrepassTextures,
    ecs::system::SystemParam,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        diagnostic::RecordDiagnostics,
        occlusion_culling::OcclusionCulling,
        render_phase::ViewBinnedRenderPhases,
        render_resource::{LoadOp, RenderPassDescriptor, StoreOp},
        renderer::{RenderContext, ViewQuery},
        view::{ExtractedView, NoIndirectDrawing, ViewDepthTexture},
    },
};

use super::{
    phase::{AlphaMaskGBuffer, OpaqueGBuffer},
    textures::{GBufferTextures, initial_load},
};
use crate::camera::ActiveLeanView;

pub(super) type GBufferView = (
    &'static ExtractedCamera,
    &'static ExtractedView,
    &'static ActiveLeanView,
    &'static GBufferTextures,
    &'static ViewDepthTexture,
    Option<&'static ViewPrepassTextures>,
    Option<&'static MainPassResolutionOverride>,
    (Has<OcclusionCulling>, Has<NoIndirectDrawing>),
);

/// When a pass draws.
enum Moment {
    /// In the place of the early prepass.
    Early,
    /// In the place of the late prepass: what the first depth did not hide.
    Late,
    /// Before the main pass, on views without any prepass.
    Main,
}

/// What is drawn.
#[derive(SystemParam)]
pub(super) struct GBufferPhases<'w> {
    opaque: Res<'w, ViewBinnedRenderPhases<OpaqueGBuffer>>,
    alpha_mask: Res<'w, ViewBinnedRenderPhases<AlphaMaskGBuffer>>,
}

pub(super) fn early_gbuffer_pass(
    world: &World,
    view: ViewQuery<GBufferView>,
    phases: GBufferPhases,
    mut ctx: RenderContext,
) {
    draw(world, view, &phases, Moment::Early, &mut ctx);
}

pub(super) fn late_gbuffer_pass(
    world: &World,
    view: ViewQuery<GBufferView>,
    phases: GBufferPhases,
    mut ctx: RenderContext,
) {
    draw(world, view, &phases, Moment::Late, &mut ctx);
}

pub(super) fn main_gbuffer_pass(
    world: &World,
    view: ViewQuery<GBufferView>,
    phases: GBufferPhases,
    mut ctx: RenderContext,
) {
    draw(world, view, &phases, Moment::Main, &mut ctx);
}

fn draw(
    world: &World,
    view: ViewQuery<GBufferView>,
    phases: &GBufferPhases,
    moment: Moment,
    ctx: &mut RenderContext,
) {
    let view_entity = view.entity();
    let (camera, view, active, textures, depth, prepass_textures, resolution_override, culling) =
        view.into_inner();
    let (occlusion_culling, no_indirect_drawing) = culling;
    let load = match moment {
        Moment::Early if active.draws_in_prepass => initial_load(active),
        Moment::Main if !active.draws_in_prepass => initial_load(active),
        Moment::Late if active.draws_in_prepass && occlusion_culling && !no_indirect_drawing => {
            LoadOp::Load
        }
        _ => return,
    };
    let (Some(opaque), Some(alpha_mask)) = (
        phases.opaque.get(&view.retained_view_entity),
        phases.alpha_mask.get(&view.retained_view_entity),
    ) else {
        return;
    };

    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    // Around the pass, not in it: clearing and copying are part of what it costs.
    let span = diagnostics.time_span(ctx.command_encoder(), "lean_deferred/gbuffer");
    let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
        label: Some("lean_deferred/gbuffer"),
        color_attachments: &textures.attachments(load),
        depth_stencil_attachment: Some(depth.get_attachment(StoreOp::Store)),
        ..default()
    });

    if let Some(viewport) =
        Viewport::from_viewport_and_override(camera.viewport.as_ref(), resolution_override)
    {
        pass.set_camera_viewport(&viewport);
    }
    if !opaque.is_empty()
        && let Err(error) = opaque.render(&mut pass, world, view_entity)
    {
        error!("drawing the opaque G-buffer phase: {error:?}");
    }
    if !alpha_mask.is_empty()
        && let Err(error) = alpha_mask.render(&mut pass, world, view_entity)
    {
        error!("drawing the alpha-masked G-buffer phase: {error:?}");
    }

    drop(pass);

    // Whoever asked for a depth prepass reads this copy.
    if let Some(prepass) = prepass_textures
        && let Some(prepass_depth) = &prepass.depth
    {
        ctx.command_encoder().copy_texture_to_texture(
            depth.texture.as_image_copy(),
            prepass_depth.texture.texture.as_image_copy(),
            prepass.size,
        );
    }
    span.end(ctx.command_encoder());
}
