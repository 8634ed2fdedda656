//! Decides in each frame which cameras with [`LeanDeferred`] are rendered lean.
//!
//! A `Camera3d` is lean if it is enabled and has `Hdr`, an `Rgba16Float` main texture, the schedule `Core3d`, a viewport with the depth
//! range 0 to 1, and neither MSAA nor `DeferredPrepass`. The device must have what [`missing_capabilities`] lists, the textures must fit
//! into memory, and the shaders must be compiled. Otherwise Bevy renders the camera. [`LeanStatus`](crate::LeanStatus) reports the state
//! to the app, and one warning per reason is logged.
//!
//! [`LeanSupport`] holds the capabilities that the device lacks. If it lacks any, cameras keep their `Msaa` and get
//! no `Hdr`.

// - `decision.rs`: decides per view and frame.
// - `inputs.rs`: the inputs of the decision.
// - `eligibility.rs`: decides which views can be lean.
// - `draw_order.rs`: decides when and how the meshes of a view are drawn.
// - `candidates.rs`: the states that a view may have, and the best of them whose lighting is compiled.
// - `prewarm.rs`: the state that a prewarmed camera will have in its level.
// - `support.rs`: capabilities that the device needs.
// - `notice.rs`: logs that a camera has become lean.
// - `foreign_depth.rs`: detects other renderers that may draw depth before the G-buffer.

mod candidates;
mod decision;
mod draw_order;
mod eligibility;
mod foreign_depth;
mod inputs;
mod notice;
mod prewarm;
mod support;

pub use support::missing_capabilities;
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
        Render, RenderApp, RenderStartup, RenderSystems, extract_component::ExtractComponentPlugin,
        view::collect_visible_cpu_culled_entities,
    },
};

use crate::{
    gbuffer::GBufferPlugin,
    gpu::recovery,
    lighting::LightingPlugin,
    view::{
        Effect, EffectSystems, LeanDeferred, LeanSupport, LeanViewSystems, ViewTextureSystems,
        can_build, overrides, status, support::add_check,
    },
};

/// Adds the packed G-buffer and compute lighting for cameras with [`LeanDeferred`]. Part of
/// [`LeanDeferredPlugins`](crate::LeanDeferredPlugins); alone, add it after `DefaultPlugins`.
#[derive(Default)]
pub struct LeanDeferredPlugin;

impl Plugin for LeanDeferredPlugin {
    fn build(&self, app: &mut App) {
        if !can_build(app, "LeanDeferredPlugin", true) {
            return;
        }
        app.add_plugins((GBufferPlugin, LightingPlugin));
        app.register_type::<LeanDeferred>()
            .add_plugins(ExtractComponentPlugin::<LeanDeferred>::default());
        add_check(app, |support| &mut support.deferred, support::check);
        status::add_to::<LeanDeferred>(app, Effect::Deferred);
        overrides::add_to::<LeanDeferred>(app, |world| {
            world.resource::<LeanSupport>().deferred.is_ok()
        });

        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        EffectSystems::Lean.run_while::<With<LeanDeferred>>(render_app);
        render_app
            .add_systems(RenderStartup, recovery::forget::<LeanDeferred>)
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
                    notice::log_newly_lean_cameras.in_set(RenderSystems::Cleanup),
                )
                    .in_set(EffectSystems::Lean),
            );
    }
}
