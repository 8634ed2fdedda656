//! Light that surfaces send to one another, and what they hide of the sky: in one march over depth.
//!
//! - `settings.rs`: the component.
//! - `uniforms.rs`, `key.rs`, `pipelines.rs`: what the shaders read, and what they are compiled by.
//! - `active.rs`: whether a view gets it in this frame. `prepare.rs`: what the passes need of the view.
//! - `pass.rs`: the three passes. `levels.wgsl`: depth, and the light of the last frame, as this one sees it.
//!   `gather.wgsl`: what falls onto each texel. `filter.wgsl`: what sixteen texels have found, together.
//! - `view.wgsl`, `bindings.wgsl`, `binding_numbers.rs`: what the shaders read, and where.

mod active;
#[doc(hidden)]
pub mod binding_numbers;
mod key;
mod pass;
mod pipelines;
mod prepare;
mod settings;
mod uniforms;

pub use settings::{LeanScreenSpaceGi, ScreenSpaceGiQuality};
// For tests and benches.
#[doc(hidden)]
pub use {
    active::ActiveGi,
    prepare::{GiBindings, ViewGi},
    uniforms::GiView,
};

use bevy::{
    asset::embedded_asset,
    core_pipeline::schedule::{Core3d, Core3dSystems},
    prelude::*,
    render::{
        GpuResourceAppExt, Render, RenderApp, RenderStartup, RenderSystems,
        extract_component::ExtractComponentPlugin,
    },
    shader::load_shader_library,
};

use super::succession::SuccessionPlugin;
use crate::{
    gpu::recovery,
    view::{
        ActiveLeanView, GBufferPasses, IndirectDiffuse, LeanViewSystems, LightingPasses,
        ReadsDiffuseLight, SharedPlugin, can_build, overrides, removal,
    },
};

/// Diffuse GI, for cameras with [`LeanScreenSpaceGi`].
#[derive(Default)]
pub struct LeanScreenSpaceGiPlugin;

impl Plugin for LeanScreenSpaceGiPlugin {
    fn build(&self, app: &mut App) {
        if !can_build(app, "LeanScreenSpaceGiPlugin", true) {
            return;
        }
        SharedPlugin::add_to(app);
        SuccessionPlugin::add_to(app);
        load_shader_library!(app, "view.wgsl");
        load_shader_library!(app, "bindings.wgsl");
        embedded_asset!(app, "levels.wgsl");
        embedded_asset!(app, "gather.wgsl");
        embedded_asset!(app, "filter.wgsl");
        app.register_type::<LeanScreenSpaceGi>()
            .add_plugins(ExtractComponentPlugin::<LeanScreenSpaceGi>::default());
        overrides::add_to::<LeanScreenSpaceGi>(app);

        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        removal::remove_with::<LeanScreenSpaceGi, ActiveGi>(render_app);
        removal::remove_with::<ActiveGi, (ViewGi, GiBindings, IndirectDiffuse, ReadsDiffuseLight)>(
            render_app,
        );
        removal::remove_with::<ActiveLeanView, (ViewGi, GiBindings)>(render_app);
        render_app
            .init_resource::<active::Warnings>()
            .init_gpu_resource::<prepare::GiUniforms>()
            .add_systems(
                RenderStartup,
                (
                    pipelines::init_gi_pipelines,
                    recovery::forget::<LeanScreenSpaceGi>,
                ),
            )
            .add_systems(
                Render,
                (
                    active::decide_active_gi
                        .in_set(RenderSystems::PrepareAssets)
                        .before(LeanViewSystems),
                    prepare::prepare_gi.in_set(RenderSystems::PrepareResources),
                    prepare::prepare_gi_bind_groups.in_set(RenderSystems::PrepareBindGroups),
                ),
            )
            .add_systems(
                Core3d,
                pass::find_diffuse_light
                    .in_set(Core3dSystems::MainPass)
                    .after(GBufferPasses)
                    .before(LightingPasses),
            );
    }
}
