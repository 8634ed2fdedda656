//! The decision, in each frame, which cameras with [`LeanDeferred`] are rendered lean.
//!
//! A camera is lean if it is enabled, HDR without MSAA and `DeferredPrepass`, its schedule is `Core3d`, its viewport has all of depth, the
//! device has what [`missing_capabilities`] lists, its textures fit into memory and its shaders are compiled. Else Bevy renders it.
//! [`LeanStatus`] tells the app, and one warning for each reason tells the log.
//!
//! [`LeanDeferredSupport`], a resource of both worlds, tells if the device can do it. Where it cannot, cameras keep their `Msaa` and get no
//! `Hdr`.

// - `decision.rs`: per camera and frame, lean or Bevy's forward, with one warning per reason.
// - `support.rs`: what the device must offer, in one function.
// - `statuses.rs`: what the camera is doing, for the main world.
// - `foreign_depth.rs`: whether other renderers than Bevy's for meshes draw depth.

mod decision;
mod foreign_depth;
mod statuses;
mod support;

pub use support::{LeanDeferredSupport, missing_capabilities};
// For tests.
#[doc(hidden)]
pub use {
    crate::gpu::needed_limits::NeededLimit,
    support::{NEEDED_FLAGS, NEEDED_FORMATS, NEEDED_LIMITS, missing_of},
};

use bevy::{
    pbr::check_views_need_specialization,
    prelude::*,
    render::{
        ExtractSchedule, Render, RenderApp, RenderStartup, RenderSystems,
        extract_component::ExtractComponentPlugin, view::collect_visible_cpu_culled_entities,
    },
};

use crate::{
    gbuffer::GBufferPlugin,
    gpu::recovery,
    lighting::LightingPlugin,
    screen_space::subsurface::SubsurfacePlugin,
    shading_extension::ShadingExtensionPlugin,
    view::{
        DebugChannel, EffectSystems, GeometricNormal, LeanDeferred, LeanStatus, LeanViewSystems,
        ViewTextureSystems, can_build, overrides,
    },
};

/// The packed G-buffer and compute lighting, for cameras with [`LeanDeferred`]; subsurface scattering, and
/// [`ExtendedStandardMaterial`](crate::shading_extension::ExtendedStandardMaterial). Part of
/// [`LeanDeferredPlugins`](crate::LeanDeferredPlugins); alone, add it after `DefaultPlugins`.
#[derive(Default)]
pub struct LeanDeferredPlugin;

impl Plugin for LeanDeferredPlugin {
    fn build(&self, app: &mut App) {
        if !can_build(app, "LeanDeferredPlugin", true) {
            return;
        }
        app.add_plugins((
            GBufferPlugin,
            LightingPlugin,
            ShadingExtensionPlugin,
            SubsurfacePlugin,
        ));
        app.register_type::<LeanDeferred>()
            .register_type::<GeometricNormal>()
            .register_type::<DebugChannel>()
            .add_plugins(ExtractComponentPlugin::<LeanDeferred>::default())
            .register_type::<LeanStatus>()
            .add_observer(statuses::remove_status);
        overrides::add_to::<LeanDeferred>(app, support::tell_main_world);

        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        EffectSystems::Lean.run_while::<With<LeanDeferred>>(render_app);
        render_app
            .init_resource::<statuses::LeanStatuses>()
            .add_systems(
                ExtractSchedule,
                statuses::report_statuses.in_set(EffectSystems::Lean),
            )
            .add_systems(
                RenderStartup,
                (
                    support::init_lean_deferred_support.ambiguous_with_all(),
                    recovery::forget::<LeanDeferred>,
                ),
            )
            .add_systems(
                Render,
                (
                    (
                        decision::decide_active_views,
                        decision::make_main_textures_writable,
                    )
                        .chain()
                        .in_set(LeanViewSystems)
                        .in_set(RenderSystems::PrepareAssets)
                        .after(check_views_need_specialization)
                        .after(collect_visible_cpu_culled_entities),
                    decision::withdraw_views_without_memory
                        .after(ViewTextureSystems)
                        .before(RenderSystems::Queue),
                )
                    .in_set(EffectSystems::Lean),
            );
    }
}
