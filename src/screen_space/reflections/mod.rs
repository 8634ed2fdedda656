//! Screen-space reflections: rays through the depth of this frame, into the light of the last one.
//!
//! Put [`LeanScreenSpaceReflections`] beside [`LeanDeferred`](crate::LeanDeferred). It keeps the picture of each frame, as it is after
//! Bevy's transparent pass, for the next one. Between G-buffer and lighting four passes read it:
//!
//! 1. *cells* notes how near and how far the surfaces of each cell of pixels are.
//! 2. *trace* sends a ray from each texel along one of the sixteen directions of the lobe (GGX) that neighbours share, from cell to cell and
//!    then from pixel to pixel; or, of rough surfaces, in segments that grow with the way.
//! 3. *lobes* takes the mean of the rays around each texel.
//! 4. *resolve* finds for each pixel what it mirrors, of the rays or the lobes around it.
//!
//! Lighting shows the result in the place of environment maps, probes and ambient light, with the same Fresnel and roughness terms. The
//! passes are timed as `lean_deferred/screen_space/history`, `lean_deferred/screen_space/reflections/cells`, `…/trace`, `…/lobes` and `…/resolve`.

// - `settings.rs`: the component.
// - `uniforms.rs`, `key.rs`, `pipelines.rs`: what the shaders read, and what they are compiled by.
// - `active.rs`: whether a view gets it in this frame. `prepare.rs`: what the passes need of the view.
// - `pass.rs`: the four passes. `cells.wgsl`: how near and how far cells of pixels reach, in words by `cell.{rs,wgsl}`.
//   `trace.wgsl`: a ray (`ray.wgsl`) for each texel, by `smooth_march.wgsl` or `rough_march.wgsl`. `lobes.wgsl`: the
//   mean of the rays around each texel. `resolve.wgsl`: what each pixel (`receiver.wgsl`) mirrors, by `smooth_light.wgsl` or
//   `rough_light.wgsl`. Both of the latter passes know texels by `texels.wgsl`.
// - `view.wgsl`, `bindings.wgsl`, `binding_numbers.rs`: what the shaders read, and where. `surface.wgsl`: what mirrors, and
//   what the last frame showed of it.

mod active;
#[doc(hidden)]
pub mod binding_numbers;
#[doc(hidden)]
pub mod cell;
mod key;
mod pass;
mod pipelines;
mod prepare;
mod settings;
mod uniforms;

pub use settings::{
    LeanScreenSpaceReflections, ScreenSpaceReflectionsDebugView, ScreenSpaceReflectionsQuality,
};
// For tests and benches.
#[doc(hidden)]
pub use {
    active::ActiveReflections,
    prepare::{ReflectionBindings, ViewReflections, WORKGROUP_SIDE},
    uniforms::ReflectionView,
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

use super::{
    ReadsHistory,
    debug_view::DebugViewPlugin,
    history::{HistoryPlugin, prepare_histories, prepare_history_bind_groups},
};
use crate::{
    gpu::recovery,
    view::{
        ActiveLeanView, EffectSystems, FoundLightPasses, GBufferPasses, IndirectSpecular,
        LeanViewSystems, LightingPasses, SharedPlugin, ViewTextureSystems, can_build, removal,
    },
};

/// Reflections, for cameras with [`LeanScreenSpaceReflections`]. Does nothing without
/// [`LeanDeferredPlugin`](crate::LeanDeferredPlugin). Part of [`LeanDeferredPlugins`](crate::LeanDeferredPlugins); alone, add it after
/// `DefaultPlugins`.
#[derive(Default)]
pub struct LeanScreenSpaceReflectionsPlugin;

impl Plugin for LeanScreenSpaceReflectionsPlugin {
    fn build(&self, app: &mut App) {
        if !can_build(app, "LeanScreenSpaceReflectionsPlugin", true) {
            return;
        }
        SharedPlugin::add_to(app);
        HistoryPlugin::add_to(app);
        load_shader_library!(app, "view.wgsl");
        load_shader_library!(app, "bindings.wgsl");
        load_shader_library!(app, "cell.wgsl");
        load_shader_library!(app, "ray.wgsl");
        load_shader_library!(app, "smooth_march.wgsl");
        load_shader_library!(app, "rough_march.wgsl");
        load_shader_library!(app, "surface.wgsl");
        load_shader_library!(app, "texels.wgsl");
        load_shader_library!(app, "receiver.wgsl");
        load_shader_library!(app, "smooth_light.wgsl");
        load_shader_library!(app, "rough_light.wgsl");
        embedded_asset!(app, "cells.wgsl");
        embedded_asset!(app, "trace.wgsl");
        embedded_asset!(app, "lobes.wgsl");
        embedded_asset!(app, "resolve.wgsl");
        app.register_type::<LeanScreenSpaceReflections>()
            .add_plugins(ExtractComponentPlugin::<LeanScreenSpaceReflections>::default());
        app.add_plugins(DebugViewPlugin::<ViewReflections>::default());

        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        removal::remove_with::<LeanScreenSpaceReflections, ActiveReflections>(render_app);
        removal::remove_with::<
            ActiveReflections,
            (
                ViewReflections,
                ReflectionBindings,
                IndirectSpecular,
                ReadsHistory,
            ),
        >(render_app);
        removal::remove_with::<ActiveLeanView, (ViewReflections, ReflectionBindings)>(render_app);
        EffectSystems::Reflections.run_while::<With<LeanScreenSpaceReflections>>(render_app);
        render_app
            .init_gpu_resource::<prepare::ReflectionUniforms>()
            .add_systems(
                RenderStartup,
                (
                    pipelines::init_reflection_pipelines,
                    recovery::forget::<LeanScreenSpaceReflections>,
                ),
            )
            .add_systems(
                Render,
                (
                    active::decide_active_reflections
                        .in_set(RenderSystems::PrepareAssets)
                        .before(LeanViewSystems),
                    prepare::prepare_reflections
                        .in_set(ViewTextureSystems)
                        .after(prepare_histories),
                    prepare::prepare_reflection_bind_groups
                        .in_set(RenderSystems::PrepareBindGroups)
                        .after(prepare_history_bind_groups),
                )
                    .in_set(EffectSystems::Reflections),
            )
            .add_systems(
                Core3d,
                pass::find_reflections
                    .in_set(EffectSystems::Reflections)
                    .in_set(Core3dSystems::MainPass)
                    .in_set(FoundLightPasses)
                    .after(GBufferPasses)
                    .before(LightingPasses),
            );
    }
}
