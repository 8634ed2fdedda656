//! The [`LeanDeferred`] component, and whether the camera that carries it can be rendered that way.
//!
//! - `settings.rs`: the component.
//! - `support.rs`: what the device must offer, in one function.
//! - `status.rs`: what the camera is doing, for the main world.
//! - `foreign_depth.rs`: whether other renderers than Bevy's for meshes draw depth.
//! - `activity.rs`: per camera and frame, the decision lean or Bevy's forward, with one warning per reason.

mod activity;
mod foreign_depth;
mod settings;
mod status;
mod support;

pub use activity::{ActiveLeanView, LeanViewSystems};
pub use settings::{GBufferChannel, GeometricNormal, LeanDeferred};
pub use status::{LeanOffReason, LeanStatus};
pub use support::{LeanDeferredSupport, missing_capabilities};

use bevy::{
    pbr::check_views_need_specialization,
    prelude::*,
    render::{
        ExtractSchedule, Render, RenderApp, RenderStartup, RenderSystems,
        extract_component::ExtractComponentPlugin,
    },
};

use crate::{camera_overrides, recovery};

/// Registers [`LeanDeferred`], extracts it and decides each frame which cameras are rendered with it.
pub(crate) struct LeanCameraPlugin;

impl Plugin for LeanCameraPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<LeanDeferred>()
            .register_type::<GeometricNormal>()
            .register_type::<GBufferChannel>()
            .add_plugins(ExtractComponentPlugin::<LeanDeferred>::default())
            .register_type::<LeanStatus>()
            .add_observer(status::remove_status);
        camera_overrides::add_to::<LeanDeferred>(app);

        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_resource::<status::LeanStatuses>()
            .add_systems(ExtractSchedule, status::report_statuses)
            .add_systems(
                RenderStartup,
                (
                    support::init_lean_deferred_support,
                    recovery::forget::<LeanDeferred>,
                ),
            )
            .add_systems(
                Render,
                (
                    activity::decide_active_views,
                    activity::make_main_textures_writable,
                )
                    .chain()
                    .in_set(LeanViewSystems)
                    .in_set(RenderSystems::PrepareAssets)
                    .after(check_views_need_specialization),
            );
    }
}
