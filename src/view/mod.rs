//! State of a view: in the main world on the camera, in the render world per frame.
//!
//! | on | type | state |
//! |---|---|---|
//! | cameras | [`LeanDeferred`] | requests lean rendering, with its settings |
//! | cameras | [`LeanStatus`] | for each effect, if the last frame had it, or why not |
//! | cameras | [`LeanMemory`] | requests the bytes of GPU memory that each effect holds |
//! | cameras | [`LeanPrewarm`] | requests that pipelines are compiled ahead of need, with its progress |
//! | cameras | [`LeanDebugView`] | requests data of an effect in place of the picture |
//! | cameras | [`CameraCut`] | the camera jumps in this frame |
//! | views of the render world | [`ActiveLeanView`] | the view is lean in this frame, with the contents of its G-buffer |
//!
//! Systems of the render world order themselves by [`LeanViewSystems`], passes in `Core3d` by [`GBufferPasses`],
//! [`LightingPasses`] and [`OpaquePicturePasses`].

// The base layer: all stages depend on it, and it depends on none of them.
//
// - `settings.rs`: `LeanDeferred`, the settings of a camera.
// - `quality.rs`: quality levels and resolutions of effects.
// - `status.rs`: `LeanStatus`, the status of each effect on a camera.
// - `effect_statuses.rs`: reports statuses to the main world, and logs reasons.
// - `support.rs`: `LeanSupport`, the effects that the device can run.
// - `memory.rs`: `LeanMemory`, the GPU memory of each effect.
// - `prewarm/`: `LeanPrewarm`, which compiles pipelines during a loading screen.
// - `debug_view.rs`: `LeanDebugView`, which shows data of an effect in place of the picture.
// - `debug_draw.rs`: draws debug views over the picture.
// - `active.rs`: `ActiveLeanView`, the state of a view in this frame.
// - `surfaces.rs`: kinds of surfaces and their G-buffer targets.
// - `schedule.rs`: system sets.
// - `pass_order.rs`: orders passes among those of apps and other crates.
// - `cut.rs`: camera cuts.
// - `averaging.rs`: detects views whose frames are averaged over time.
// - `depth_usage.rs`: usages of depth textures.
// - `lighting_io.rs`: light that effects take from lighting and give to it.
// - `overrides/`: changes to cameras, and their reversal.
// - `in_use.rs`: skips the systems of effects that no camera has.
// - `removal.rs`: removes dependent components together with their source.
// - `bevy/`: rules of Bevy that are repeated.
// - `out_of_memory.rs`: textures that do not fit into memory.
// - `warn_once.rs`: warns once per camera why a part of an effect is off.

mod active;
mod averaging;
mod bevy;
mod cut;
pub(crate) mod debug_draw;
mod debug_view;
pub(crate) mod depth_usage;
mod effect_statuses;
mod in_use;
mod lighting_io;
pub(crate) mod memory;
mod out_of_memory;
pub(crate) mod overrides;
pub(crate) mod pass_order;
pub(crate) mod prewarm;
mod quality;
pub(crate) mod removal;
mod schedule;
mod settings;
pub(crate) mod status;
pub(crate) mod support;
mod surfaces;
pub(crate) mod warn_once;

pub use active::ActiveLeanView;
pub(crate) use active::Demand;
pub(crate) use averaging::FrameAveraging;
pub use cut::{CameraCut, CameraCuts};
pub use debug_view::{DebugView, LeanDebugView};
pub(crate) use effect_statuses::EffectStatuses;
pub(crate) use in_use::EffectSystems;
pub(crate) use lighting_io::LightingIoQuery;
#[doc(hidden)]
pub use lighting_io::{
    AmbientOcclusion, DiffuseLight, IndirectDiffuse, IndirectSpecular, LightingIo, OccludesLight,
    ReadsDiffuseLight, ScattersLight,
};
pub use memory::LeanMemory;
#[doc(hidden)]
pub use out_of_memory::OutOfMemory;
pub use prewarm::{LeanPrewarm, PrewarmFeatures, PrewarmProgress};
pub(crate) use prewarm::{PrewarmExtraction, PrewarmedCamera, PrewarmedView, Prewarming};
pub(crate) use quality::parse_level;
pub use quality::{LeanQuality, LeanResolution, ParseLevelError};
#[doc(hidden)]
pub use schedule::DebugViewPasses;
pub(crate) use schedule::{
    ExposureOverlayPasses, ExposurePasses, ForwardMeshesQueued, HistoryPasses, IndirectLightPasses,
    ViewTextureSystems,
};
pub use schedule::{GBufferPasses, LeanViewSystems, LightingPasses, OpaquePicturePasses};
pub(crate) use settings::require_lean;
pub use settings::{LeanDeferred, LeanDeferredAdvanced, LightCulling};
pub(crate) use status::Effect;
pub use status::{EffectStatus, LeanOffReason, LeanStatus};
pub use support::LeanSupport;
pub(crate) use surfaces::LightingVariants;
pub use surfaces::{GBufferTargets, ShadingModel};

use self::bevy::unfit_items;

use ::bevy::{
    asset::io::embedded::EmbeddedAssetRegistry,
    core_pipeline::{
        core_3d::{Opaque3d, main_opaque_pass_3d},
        schedule::{Core2d, Core3d, Core3dSystems},
    },
    pbr::{PbrPlugin, check_views_need_specialization},
    prelude::*,
    render::{
        GpuResourceAppExt, Render, RenderApp, RenderPlugin, RenderStartup, RenderSystems,
        extract_component::ExtractComponentPlugin, render_phase::ViewBinnedRenderPhases,
        render_resource::PipelineCache, renderer::RenderDevice,
    },
};

use pass_order::PassOrder;

use crate::{
    gpu::{
        pipeline_watch::{self, PipelineWatch},
        subgroups::Subgroups,
    },
    shader_library,
};

/// Resources and systems that several effects share. Added once, by the first of them.
pub(crate) struct SharedPlugin;

impl SharedPlugin {
    pub(crate) fn add_to(app: &mut App) {
        if !app.is_plugin_added::<Self>() {
            app.add_plugins(Self);
        }
    }
}

impl Plugin for SharedPlugin {
    fn build(&self, app: &mut App) {
        shader_library::load(app);
        app.init_resource::<overrides::CameraNeeds>()
            .init_resource::<support::SupportChecks>()
            .register_type::<CameraCut>()
            .register_type::<LeanStatus>()
            .register_type::<LeanMemory>()
            .register_type::<LeanDebugView>()
            .add_plugins((
                ExtractComponentPlugin::<CameraCuts>::default(),
                ExtractComponentPlugin::<LeanDebugView>::default(),
            ))
            .add_systems(
                First,
                // Bevy may create a new device when one is lost.
                follow_device
                    .run_if(resource_exists_and_changed::<RenderDevice>)
                    .ambiguous_with_all(),
            )
            .add_systems(
                Last,
                (
                    cut::count_cuts.run_if(any_with_component::<CameraCut>),
                    // Only logs.
                    overrides::warn_of_overlaps
                        .run_if(overrides::are_cameras_changed)
                        .ambiguous_with_all(),
                ),
            )
            .add_observer(overrides::override_new_camera)
            .add_observer(overrides::keep_ticks_young);
        prewarm::add_to(app);
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        EffectSystems::Memory.run_while::<With<LeanMemory>>(render_app);
        EffectSystems::DebugViews.run_while::<With<LeanDebugView>>(render_app);
        render_app
            .init_gpu_resource::<PipelineWatch>()
            // Each system queues its own pipelines, in any order.
            .allow_ambiguous_resource::<PipelineCache>()
            .init_gpu_resource::<OutOfMemory>()
            // Each system records its own failed allocations, in any order.
            .allow_ambiguous_resource::<OutOfMemory>()
            .init_resource::<EffectStatuses>()
            // Each system sets the statuses of its own effect, in any order.
            .allow_ambiguous_resource::<EffectStatuses>()
            .init_resource::<memory::MemoryReports>()
            // Each system adds bytes, in any order.
            .allow_ambiguous_resource::<memory::MemoryReports>()
            .configure_sets(
                Render,
                ViewTextureSystems
                    .after(RenderSystems::PrepareViews)
                    .before(RenderSystems::Queue),
            )
            .add_systems(RenderStartup, look_at_device.ambiguous_with_all())
            .add_systems(
                ExtractSchedule,
                (
                    pipeline_watch::watch_pipelines.ambiguous_with_all(),
                    effect_statuses::report_statuses.run_if(effect_statuses::are_statuses_known),
                    memory::report_memory(),
                ),
            )
            .add_systems(
                Render,
                (
                    (
                        out_of_memory::forget_cameras.before(LeanViewSystems),
                        unfit_items::drop_unfit_items
                            .after(check_views_need_specialization)
                            .run_if(resource_exists::<ViewBinnedRenderPhases<Opaque3d>>),
                    )
                        .in_set(RenderSystems::PrepareAssets),
                    averaging::note_frame_averaging
                        .after(RenderSystems::PrepareViews)
                        .before(ViewTextureSystems),
                ),
            )
            .edit_schedule(Core3d, |schedule| {
                schedule
                    .add_build_pass(PassOrder::of_core_3d())
                    .configure_sets(
                        OpaquePicturePasses
                            .in_set(Core3dSystems::MainPass)
                            .after(main_opaque_pass_3d),
                    );
            })
            .edit_schedule(Core2d, |schedule| {
                schedule.add_build_pass(PassOrder::of_core_2d());
            });
    }

    fn finish(&self, app: &mut App) {
        follow_device(app.world_mut());
        let checks = app.world().resource::<support::SupportChecks>().clone();
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app.insert_resource(checks);
        }
    }
}

/// Checks the device of the main world, and fits cameras to it.
fn follow_device(world: &mut World) {
    support::check_device(world);
    overrides::fit_device(world);
}

/// Checks each new device of the render world.
fn look_at_device(world: &mut World) {
    support::check_device(world);
    let subgroups = Subgroups::from_world(world);
    world.insert_resource(subgroups);
}

/// True if the app has the plugins that the effect `plugin` depends on. Otherwise logs an error, and the plugin must add nothing.
pub(crate) fn can_build(app: &mut App, plugin: &'static str, with_pbr: bool) -> bool {
    let missing = if !app.world().contains_resource::<EmbeddedAssetRegistry>() {
        "AssetPlugin"
    } else if !app.is_plugin_added::<RenderPlugin>() {
        "RenderPlugin"
    } else if with_pbr && !app.is_plugin_added::<PbrPlugin>() {
        "PbrPlugin"
    } else {
        return true;
    };
    if !app.is_plugin_added::<OffNotice>() {
        app.add_plugins(OffNotice { plugin, missing });
    }
    false
}

/// Logs in `finish`, once there is a log, that plugins of this crate have added nothing. `plugin` is the first of them.
struct OffNotice {
    plugin: &'static str,
    missing: &'static str,
}

impl Plugin for OffNotice {
    fn build(&self, _: &mut App) {}

    fn finish(&self, _: &mut App) {
        let Self { plugin, missing } = self;
        error!(
            "{plugin} is off, as all plugins of this crate that need {missing}: it was not there when they were added. Add \
             `LeanDeferredPlugins` after `DefaultPlugins`."
        );
    }
}
