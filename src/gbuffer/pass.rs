//! The raster passes of the G-buffer. The first draws meshes that write only the base targets. While the view has
//! optional targets, a second one draws the meshes that write these. Each writes those that it needs, and `valid_mask`,
//! which lists them: words in other targets at that pixel stem from surfaces behind and are not read. Alpha-masked
//! meshes hide opaque ones at equal depth, so those of the first pass are then drawn last, in a third pass that clears
//! `valid_mask` where they are visible. None of their pipelines depends on the optional targets that the view has.
//!
//! The view decides when the passes run:
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
        diagnostic::RecordDiagnostics,
        render_phase::TrackedRenderPass,
        render_resource::{
            PipelineCache, RenderPassDepthStencilAttachment, RenderPassDescriptor, StoreOp,
        },
        renderer::{RenderContext, ViewQuery},
        view::{ExtractedView, ViewDepthTexture},
    },
};

use super::{
    phase::DrawnGBufferPhases,
    resolve_motion::ViewMotionResolve,
    textures::{BaseLoad, GBufferTextures, PassLoad, PassTargets},
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

    // The first attachment that is requested in a frame clears depth.
    let first_depth = is_first.then(|| depth.get_attachment(StoreOp::Store));
    let base = match &first_depth {
        Some(depth) => BaseLoad::first(active, depth),
        None => BaseLoad::Drawn,
    };
    let mut passes = Passes {
        textures,
        depth,
        first_depth,
        viewport: Viewport::from_viewport_and_override(
            camera.viewport.as_ref(),
            resolution_override,
        ),
        load: PassLoad {
            base,
            has_valid_mask: !is_first,
            has_optional: !is_first,
        },
        world,
    };
    let (opaque, alpha_masked) = phases.base.of(&retained);
    let (extended_opaque, extended_alpha_masked) = phases.extended.of(&retained);

    // Timed around the passes, not inside: the cost includes clearing. The first pass that has a target must clear it,
    // so it runs even without meshes.
    timed(ctx, "lean_deferred/gbuffer", &mut |ctx| {
        if active.targets.is_empty() {
            if is_first || !opaque.is_empty() || !alpha_masked.is_empty() {
                passes.draw(ctx, PassTargets::Base, |pass, world| {
                    opaque.render(pass, world, view_entity);
                    alpha_masked.render_depth_first(pass, world, view_entity);
                });
            }
        } else {
            if !opaque.is_empty() {
                let targets = if active.all_clear_valid_mask() {
                    PassTargets::ValidMask
                } else {
                    PassTargets::Base
                };
                passes.draw(ctx, targets, |pass, world| {
                    opaque.render(pass, world, view_entity);
                });
            }
            if is_first || !extended_opaque.is_empty() || !extended_alpha_masked.is_empty() {
                passes.draw(ctx, PassTargets::All, |pass, world| {
                    extended_opaque.render(pass, world, view_entity);
                    extended_alpha_masked.render_depth_first(pass, world, view_entity);
                });
            }
            if !alpha_masked.is_empty() {
                passes.draw(ctx, PassTargets::ValidMask, |pass, world| {
                    alpha_masked.render_depth_first(pass, world, view_entity);
                });
            }
        }

        if let (Some(resolve), Some(prepass)) = (resolve_motion, prepass_textures) {
            let cache = world.resource::<PipelineCache>();
            resolve.draw(!is_first, prepass, passes.viewport.as_ref(), cache, ctx);
        }
    });
}

/// The passes of one view at one point in the frame.
struct Passes<'a> {
    textures: &'a GBufferTextures,
    depth: &'a ViewDepthTexture,
    /// Attachment of the first pass, which clears depth.
    first_depth: Option<RenderPassDepthStencilAttachment<'a>>,
    viewport: Option<Viewport>,
    /// State of the targets for the next pass.
    load: PassLoad,
    world: &'a World,
}

impl Passes<'_> {
    fn draw(
        &mut self,
        ctx: &mut RenderContext,
        targets: PassTargets,
        render: impl for<'w> FnOnce(&mut TrackedRenderPass<'w>, &'w World),
    ) {
        let depth = self.first_depth.take();
        let depth = depth.unwrap_or_else(|| self.depth.get_attachment(StoreOp::Store));
        let (label, span) = match targets {
            PassTargets::Base => ("lean_deferred/gbuffer", "base"),
            PassTargets::ValidMask => ("lean_deferred/gbuffer/valid_mask", "valid_mask"),
            PassTargets::All => ("lean_deferred/gbuffer/extended", "extended"),
        };
        let diagnostics = ctx.diagnostic_recorder();
        let diagnostics = diagnostics.as_deref();
        let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some(label),
            color_attachments: &self.textures.attachments(targets, self.load),
            depth_stencil_attachment: Some(depth),
            ..default()
        });
        self.load = self.load.after(targets);
        // Counts the invocations of vertex and fragment shaders too.
        let span = diagnostics.pass_span(&mut pass, span);
        if let Some(viewport) = &self.viewport {
            pass.set_camera_viewport(viewport);
        }
        render(&mut pass, self.world);
        span.end(&mut pass);
    }
}
