//! The raster passes: first the meshes that write the base targets alone, then, while the view has optional targets,
//! those that write them, and all alpha-masked ones, which hide opaque ones at the same depth. Each mesh writes the
//! optional targets that it needs, and one more, which says which these are: a pixel's words of others were left by what
//! lies behind, and are not read. Where the passes stand in the frame depends on the view:
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

/// When a pass draws.
enum Moment {
    /// In the place of the early prepass.
    Early,
    /// In the place of the late prepass: what the first depth did not hide.
    Late,
    /// Before the main pass, on views without any prepass.
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
    // The first to ask for depth has it cleared.
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

    // Around the passes, not in them: clearing is part of what they cost.
    timed(ctx, "lean_deferred/gbuffer", &mut |ctx| {
        // Each target must be cleared once, by whichever pass is the first to have it.
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
