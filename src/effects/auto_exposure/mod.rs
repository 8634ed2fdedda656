//! Auto exposure: reduces the luminance of the picture in two dispatches, and adapts the exposure to it.
//!
#![cfg_attr(
    doc,
    doc = concat!(
        "<img alt=\"A dark corner\" src=\"data:image/jpeg;base64,",
        include_str!("../../../docs/pictures/thumbs/auto_exposure_dark.jpg.base64"),
        "\">\n\n*A corner lit by a lamp: without auto exposure, and with it.*"
    )
)]
//!
//! Put [`LeanAutoExposure`] on any camera, 3D or 2D; it adds `Hdr`. Each frame, after anti-aliasing and before bloom:
//!
//! 1. *meter*: workgroups sum the luminance of the camera's viewport, weighted by [`MeteringPattern`], for the mean of [`Metering`];
//!    with a [`LuminanceTrim`] they bin it in a histogram.
//! 2. *adapt*: one workgroup adds up these sums and moves the exposure towards its target, in stops per second. The solution is
//!    exact: its path is the same at any frame rate.
//!
//! Bevy's tonemapping applies the exposure. It stays on the GPU; [`MeteredExposure`] on the camera reads it back, some frames later.
//! After a [`CameraCut`](crate::CameraCut) the exposure starts adapted.
//!
//! The GPU time of both passes is recorded together as `lean_deferred/effects/auto_exposure`. On devices that lack what they need
//! ([`LeanSupport::auto_exposure`](crate::LeanSupport::auto_exposure)), the effect is off, and one warning says why.

// - `settings.rs`: the components.
// - `support.rs`: capabilities of the device.
// - `clock.rs`: real and virtual time, one of which drives adaptation.
// - `state.rs`: the exposure of a camera on the GPU.
// - `readback.rs`: reads the exposure back, for cameras with `MeteredExposure`.
// - `uniforms.rs`: the uniform of a view, and the adaptation state.
// - `key.rs`: pipeline key, and sizes of dispatches and buffers.
// - `pipelines.rs`: the table of the passes, their bindings and pipelines.
// - `masks.rs`: images of the metering masks.
// - `active.rs`: decides per view and frame if and how it is metered.
// - `prepare.rs`: uniforms, buffers and bind groups of views.
// - `pass.rs`: runs the passes.
// - `meter.wgsl`: the first dispatch.
// - `adapt.wgsl`: the second dispatch.
// - `reduction.wgsl`: sums over a workgroup.
// - `binding_numbers.rs`, `bindings.wgsl`: binding numbers and declarations.
// - `overlay.{rs,wgsl}`: the debug view: pixel weights and the exposure over the picture.
// - `pattern.wgsl`: the weight of a pixel.
// - `luminance.wgsl`, `adaptation.wgsl`: binding-free maths.

mod active;
#[doc(hidden)]
pub mod binding_numbers;
mod clock;
#[doc(hidden)]
pub mod key;
mod masks;
mod overlay;
mod pass;
mod pipelines;
mod prepare;
mod readback;
mod settings;
mod state;
mod support;
mod uniforms;

pub use settings::{
    ExposureClock, LeanAutoExposure, LeanAutoExposureAdvanced, LuminanceTrim, MeteredExposure,
    Metering, MeteringPattern, ReductionPath,
};
#[doc(hidden)]
pub use support::NEEDED_LIMITS;
// For tests and benches.
#[doc(hidden)]
pub use {
    active::ActiveExposure,
    key::ExposureKey,
    pipelines::{PASSES, layouts},
    prepare::{ExposureBindings, ViewExposure},
    readback::ExposureReadback,
    state::ExposureHistory,
    uniforms::{ExposureState, ExposureUniform},
};

use overlay::ShownWeights;

use bevy::{
    asset::embedded_asset,
    core_pipeline::{
        schedule::{Core2d, Core2dSystems, Core3d, Core3dSystems},
        tonemapping::tonemapping,
    },
    prelude::*,
    render::{
        ExtractSchedule, GpuResourceAppExt, Render, RenderApp, RenderStartup, RenderSystems,
        extract_component::ExtractComponentPlugin,
    },
    shader::load_shader_library,
};

use crate::{
    gpu::recovery,
    view::{
        Effect, EffectSystems, ExposureOverlayPasses, ExposurePasses, LeanDebugView, LeanMemory,
        LeanSupport, SharedPlugin, can_build,
        debug_draw::{DebugDrawn, draw_debug_view},
        memory, overrides, removal, status,
        support::add_check,
    },
};

/// Adds auto exposure for cameras with [`LeanAutoExposure`]. Part of [`LeanDeferredPlugins`](crate::LeanDeferredPlugins); alone, add it
/// after `DefaultPlugins`.
#[derive(Default)]
pub struct LeanAutoExposurePlugin;

impl Plugin for LeanAutoExposurePlugin {
    fn build(&self, app: &mut App) {
        if !can_build(app, "LeanAutoExposurePlugin", false) {
            return;
        }
        SharedPlugin::add_to(app);
        load_shader_library!(app, "bindings.wgsl");
        load_shader_library!(app, "luminance.wgsl");
        load_shader_library!(app, "pattern.wgsl");
        load_shader_library!(app, "adaptation.wgsl");
        load_shader_library!(app, "reduction.wgsl");
        embedded_asset!(app, "meter.wgsl");
        embedded_asset!(app, "adapt.wgsl");
        embedded_asset!(app, "overlay.wgsl");
        app.register_type::<LeanAutoExposure>()
            .register_type::<MeteredExposure>()
            .add_plugins((
                ExtractComponentPlugin::<LeanAutoExposure>::default(),
                ExtractComponentPlugin::<MeteredExposure>::default(),
            ))
            .add_observer(state::remove_state);
        add_check(app, |support| &mut support.auto_exposure, support::check);
        status::add_to::<LeanAutoExposure>(app, Effect::AutoExposure);
        overrides::add_to::<LeanAutoExposure>(app, |world| {
            world.resource::<LeanSupport>().auto_exposure.is_ok()
        });

        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        // `ExposureHistory` outlasts `ActiveExposure`: the effect may pause.
        removal::remove_with::<LeanAutoExposure, (ActiveExposure, ExposureHistory, ExposureReadback)>(
            render_app,
        );
        removal::remove_with::<
            ActiveExposure,
            (ViewExposure, ExposureBindings, DebugDrawn<ShownWeights>),
        >(render_app);
        removal::remove_with::<LeanDebugView, DebugDrawn<ShownWeights>>(render_app);
        removal::remove_with::<MeteredExposure, ExposureReadback>(render_app);
        EffectSystems::AutoExposure.run_while::<With<LeanAutoExposure>>(render_app);
        let field: fn(&mut LeanMemory) -> &mut u64 = |memory| &mut memory.auto_exposure;
        memory::count(render_app, field, ViewExposure::bytes);
        memory::count(render_app, field, ExposureHistory::bytes);
        memory::count(render_app, field, ExposureReadback::bytes);
        render_app
            .init_gpu_resource::<prepare::ExposureUniforms>()
            .init_resource::<clock::Clocks>()
            .add_systems(
                RenderStartup,
                (
                    pipelines::init_exposure_pipelines,
                    overlay::init_overlay_pipelines,
                    recovery::forget::<LeanAutoExposure>,
                ),
            )
            .add_systems(
                ExtractSchedule,
                (readback::report_metered, clock::extract_clocks)
                    .in_set(EffectSystems::AutoExposure),
            )
            .add_systems(
                Render,
                (
                    active::decide_active_exposure.in_set(RenderSystems::Queue),
                    (
                        state::begin_histories,
                        prepare::write_exposure_uniforms,
                        readback::prepare_readbacks,
                    )
                        .chain()
                        .in_set(RenderSystems::PrepareResources),
                    prepare::prepare_exposure_bind_groups.in_set(RenderSystems::PrepareBindGroups),
                    readback::map_readbacks.in_set(RenderSystems::Cleanup),
                )
                    .in_set(EffectSystems::AutoExposure),
            )
            .add_systems(
                Render,
                overlay::prepare_overlays
                    .in_set(RenderSystems::PrepareBindGroups)
                    .in_set(EffectSystems::DebugViews),
            )
            .add_systems(
                Core3d,
                (
                    pass::auto_exposure
                        .in_set(EffectSystems::AutoExposure)
                        .in_set(ExposurePasses)
                        .after(Core3dSystems::EarlyPostProcess)
                        .before(Core3dSystems::PostProcess),
                    draw_debug_view::<ShownWeights>
                        .in_set(EffectSystems::DebugViews)
                        .in_set(ExposureOverlayPasses)
                        .in_set(Core3dSystems::PostProcess)
                        .after(tonemapping),
                ),
            )
            .add_systems(
                Core2d,
                (
                    pass::auto_exposure
                        .in_set(EffectSystems::AutoExposure)
                        .in_set(ExposurePasses)
                        .after(Core2dSystems::EarlyPostProcess)
                        .before(Core2dSystems::PostProcess),
                    draw_debug_view::<ShownWeights>
                        .in_set(EffectSystems::DebugViews)
                        .in_set(ExposureOverlayPasses)
                        .in_set(Core2dSystems::PostProcess)
                        .after(tonemapping),
                ),
            );
    }
}
