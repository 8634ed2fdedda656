//! The raster passes of the G-buffer. The first draws meshes that write only the base targets. The second runs while
//! the view has optional targets. It draws the meshes that write these, and all alpha-masked ones, which hide opaque
//! ones at equal depth. Each mesh writes the optional targets that it needs, and `valid_mask`, which lists them: words in
//! other targets at that pixel stem from surfaces behind and are not read. The view decides when the passes run:
//!
//! - No prepass: once, after Bevy has built the indirect draws for the main passes.
//! - A depth prepass, which something else requested: in its place, so that readers of depth between prepass and main
//!   pass (Bevy's SSAO, contact shadows) see the lean meshes.
//! - `OcclusionCulling`: twice. First the meshes that were visible in the last frame, then those that the resulting
//!   depth does not occlude.

use bevy::{
    camera::{MainPassResolutionOverride, Viewport},
    core_pipeline::prepass::ViewPrepassTextures,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{PipelineCache, RenderPassDescriptor, StoreOp},
        renderer::{RenderContext, ViewQuery},
        view::{ExtractedView, ViewDepthTexture},
    },
};

use super::{
    phase::DrawnGBufferPhases,
    resolve_motion::ViewMotionResolve,
    textures::{BaseLoad, GBufferTextures},
};
use crate::{gpu::timed::timed, view::ActiveLeanView};

pub(super) type GBufferView = (
    &'static ExtractedCamera,
    &'static ExtractedView,
    &'static ActiveLeanView,
    &'static GBufferTextures,
    &'static ViewDepthTexture,
    Option<&'static ViewPrepassTextures>,
    Option<&'static ViewMotionResolve>,
    Option<&'static MainPassResolutionOverride>,
);

/// Point in the frame at which a pass draws.
enum Moment {
    /// In place of the early prepass.
    Early,
    /// In place of the late prepass: the meshes that the first depth does not occlude.
    Late,
    /// Before the main pass, on views without a prepass.
    Main,
}

pub(super) fn early_gbuffer_pass(
    world: &World,
    view: ViewQuery<GBufferView>,
    phases: DrawnGBufferPhases,
    mut ctx: RenderContext,
) {
    draw(world, view, &phases, Moment::Early, &mut ctx);
}

pub(super) fn late_gbuffer_pass(
    world: &World,
    view: ViewQuery<GBufferView>,
    phases: DrawnGBufferPhases,
    mut ctx: RenderContext,
) {
    draw(world, view, &phases, Moment::Late, &mut ctx);
}

pub(super) fn main_gbuffer_pass(
    world: &World,
    view: ViewQuery<GBufferView>,
    phases: DrawnGBufferPhases,
    mut ctx: RenderContext,
) {
    draw(world, view, &phases, Moment::Main, &mut ctx);
}

fn draw(
    world: &World,
    view: ViewQuery<GBufferView>,
    phases: &DrawnGBufferPhases,
    moment: Moment,
    ctx: &mut RenderContext,
) {
    let view_entity = view.entity();
    let (
        camera,
        view,
        active,
        textures,
        depth,
        prepass_textures,
        resolve_motion,
        resolution_override,
    ) = view.into_inner();
    let is_first = match moment {
        Moment::Early if active.draws_in_prepass => true,
        Moment::Main if !active.draws_in_prepass => true,
        Moment::Late if active.culls_in_two_phases => false,
        _ => return,
    };
    let retained = view.retained_view_entity;

    let viewport =
        Viewport::from_viewport_and_override(camera.viewport.as_ref(), resolution_override);
    // The first attachment that is requested in a frame clears depth.
    let mut first_depth = is_first.then(|| depth.get_attachment(StoreOp::Store));
    let mut base_load = match &first_depth {
        Some(depth) => BaseLoad::first(active, depth),
        None => BaseLoad::Drawn,
    };
    let mut depth_attachment = || {
        let first = first_depth.take();
        first.unwrap_or_else(|| depth.get_attachment(StoreOp::Store))
    };
    let has_optional = !active.targets.is_empty();

    // Timed around the passes, not inside: the cost includes clearing.
    timed(ctx, "lean_deferred/gbuffer", &mut |ctx| {
        // The first pass that has a target must clear it, so it runs even without meshes.
        if !phases.base.is_empty(&retained) || (is_first && !has_optional) {
            let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
                label: Some("lean_deferred/gbuffer"),
                color_attachments: &textures.base_attachments(base_load),
                depth_stencil_attachment: Some(depth_attachment()),
                ..default()
            });
            base_load = BaseLoad::Drawn;
            if let Some(viewport) = &viewport {
                pass.set_camera_viewport(viewport);
            }
            phases.base.render(&retained, &mut pass, world, view_entity);
        }
        if has_optional && (is_first || !phases.extended.is_empty(&retained)) {
            let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
                label: Some("lean_deferred/gbuffer/extended"),
                color_attachments: &textures.all_attachments(base_load, is_first),
                depth_stencil_attachment: Some(depth_attachment()),
                ..default()
            });
            if let Some(viewport) = &viewport {
                pass.set_camera_viewport(viewport);
            }
            phases
                .extended
                .render(&retained, &mut pass, world, view_entity);
        }

        if let (Some(resolve), Some(prepass)) = (resolve_motion, prepass_textures) {
            let cache = world.resource::<PipelineCache>();
            resolve.draw(!is_first, prepass, viewport.as_ref(), cache, ctx);
        }
    });
}
