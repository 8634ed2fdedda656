//! The raster pass. Where it stands in the frame depends on the view:
//!
//! - No prepass: once, after Bevy has built the indirect draws for the main passes.
//! - A depth prepass, which something else asked for: in its place, so that what reads depth between prepass and main
//!   pass (Bevy's SSAO, contact shadows) finds the lean meshes there.
//! - With `OcclusionCulling` twice: what was visible last frame, then what the depth of that does not hide.

use bevy::{
    camera::{MainPassResolutionOverride, Viewport},
    core_pipeline::prepass::ViewPrepassTextures,
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

/// In the place of the early prepass.
pub(super) fn early_gbuffer_pass(
    world: &World,
    view: ViewQuery<GBufferView>,
    opaque: Res<ViewBinnedRenderPhases<OpaqueGBuffer>>,
    alpha_mask: Res<ViewBinnedRenderPhases<AlphaMaskGBuffer>>,
    mut ctx: RenderContext,
) {
    let entity = view.entity();
    let view = view.into_inner();
    if view.2.draws_in_prepass {
        draw(
            world,
            entity,
            view,
            &opaque,
            &alpha_mask,
            initial_load(view.2),
            &mut ctx,
        );
    }
}

/// In the place of the late prepass: what the first depth did not hide.
pub(super) fn late_gbuffer_pass(
    world: &World,
    view: ViewQuery<GBufferView>,
    opaque: Res<ViewBinnedRenderPhases<OpaqueGBuffer>>,
    alpha_mask: Res<ViewBinnedRenderPhases<AlphaMaskGBuffer>>,
    mut ctx: RenderContext,
) {
    let entity = view.entity();
    let view = view.into_inner();
    let (occlusion_culling, no_indirect_drawing) = view.7;
    if view.2.draws_in_prepass && occlusion_culling && !no_indirect_drawing {
        draw(
            world,
            entity,
            view,
            &opaque,
            &alpha_mask,
            LoadOp::Load,
            &mut ctx,
        );
    }
}

/// Before the main pass, on views without any prepass.
pub(super) fn main_gbuffer_pass(
    world: &World,
    view: ViewQuery<GBufferView>,
    opaque: Res<ViewBinnedRenderPhases<OpaqueGBuffer>>,
    alpha_mask: Res<ViewBinnedRenderPhases<AlphaMaskGBuffer>>,
    mut ctx: RenderContext,
) {
    let entity = view.entity();
    let view = view.into_inner();
    if !view.2.draws_in_prepass {
        draw(
            world,
            entity,
            view,
            &opaque,
            &alpha_mask,
            initial_load(view.2),
            &mut ctx,
        );
    }
}

fn draw(
    world: &World,
    view_entity: Entity,
    (camera, view, _, textures, depth, prepass_textures, resolution_override, _): bevy::ecs::query::QueryItem<GBufferView>,
    opaque_phases: &ViewBinnedRenderPhases<OpaqueGBuffer>,
    alpha_mask_phases: &ViewBinnedRenderPhases<AlphaMaskGBuffer>,
    load: LoadOp<wgpu::Color>,
    ctx: &mut RenderContext,
) {
    let (Some(opaque), Some(alpha_mask)) = (
        opaque_phases.get(&view.retained_view_entity),
        alpha_mask_phases.get(&view.retained_view_entity),
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
