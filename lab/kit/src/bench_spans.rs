//! GPU spans around whole stages of Bevy's renderers, for benches.

use bevy::{
    core_pipeline::{
        core_3d::{main_opaque_pass_3d, main_transparent_pass_3d},
        mip_generation::experimental::depth::early_downsample_depth,
        prepass::node::{early_prepass, late_prepass},
        schedule::{Core3d, Core3dSystems},
        upscaling::upscaling,
    },
    ecs::schedule::SingleThreadedExecutor,
    pbr::{
        EARLY_SHADOW_PASS, clear_indirect_parameters_metadata, deferred::deferred_lighting,
        early_prepass_build_indirect_parameters, per_view_shadow_pass, shared_shadow_pass,
    },
    prelude::*,
    render::{RenderApp, renderer::RenderContext},
};

use crate::gpu_time::{begin, end};

/// Everything from the camera's first to its last pass, including shadow maps and post-processing.
pub const CAMERA: &str = "bench/camera";
/// Bevy's prepass, including its G-buffer if it has one.
pub const PREPASS: &str = "bench/prepass";
/// Bevy's deferred lighting pass.
pub const DEFERRED_LIGHTING: &str = "bench/deferred_lighting";
/// Bevy's forward pass over opaque meshes: rasterisation and lighting in one.
pub const OPAQUE: &str = "bench/opaque";
/// Bevy's own span of its pass of blended meshes.
pub const BLENDED: &str = "main_transparent_pass_3d";

/// Adds the [`CAMERA`] span. Spans of one thread nest, so the schedule runs single-threaded.
pub fn add_camera_span(app: &mut App) {
    app.sub_app_mut(RenderApp)
        .edit_schedule(Core3d, |schedule| {
            schedule.set_executor(SingleThreadedExecutor::new());
        })
        .add_systems(
            Core3d,
            (
                (|ctx: RenderContext| begin(ctx, CAMERA))
                    .before(clear_indirect_parameters_metadata)
                    .before(Core3dSystems::Prepass),
                end.after(upscaling),
            ),
        );
}

/// Adds [`CAMERA`] and spans around whole stages of Bevy's renderers with their clears and copies, like this crate's own spans: Bevy's
/// spans lie inside its passes, and its deferred lighting has none.
pub fn add_bench_spans(app: &mut App) {
    add_camera_span(app);
    app.sub_app_mut(RenderApp).add_systems(
        Core3d,
        (
            (|ctx: RenderContext| begin(ctx, DEFERRED_LIGHTING))
                .in_set(Core3dSystems::MainPass)
                .before(deferred_lighting),
            end.in_set(Core3dSystems::MainPass)
                .after(deferred_lighting)
                .before(main_opaque_pass_3d)
                .before(begin_opaque),
            begin_opaque
                .in_set(Core3dSystems::MainPass)
                .after(deferred_lighting)
                .before(main_opaque_pass_3d),
            end.in_set(Core3dSystems::MainPass)
                .after(main_opaque_pass_3d)
                .before(main_transparent_pass_3d),
            begin_prepass
                .after(early_prepass_build_indirect_parameters)
                .after(per_view_shadow_pass::<EARLY_SHADOW_PASS>)
                .after(shared_shadow_pass::<EARLY_SHADOW_PASS>)
                .before(early_prepass),
            end.after(early_downsample_depth)
                .before(late_prepass)
                .in_set(Core3dSystems::Prepass),
        ),
    );
}

fn begin_opaque(ctx: RenderContext) {
    begin(ctx, OPAQUE);
}

fn begin_prepass(ctx: RenderContext) {
    begin(ctx, PREPASS);
}
