//! Diffuse global illumination: diffuse light between surfaces, and their occlusion of the environment, from one march over depth
//! (Mayaux 2018, "Horizon-based indirect lighting").
//!
#![cfg_attr(
    doc,
    doc = concat!(
        "<img alt=\"A room\" src=\"data:image/jpeg;base64,",
        include_str!("../../../docs/pictures/thumbs/diffuse_gi.jpg.base64"),
        "\">\n\n*A room lit by the sun through a window: without diffuse GI, and with it.*"
    )
)]
//!
//! Put [`LeanScreenSpaceGi`] on a camera, which gets [`LeanDeferred`](crate::LeanDeferred) with it. Three passes run between G-buffer
//! and lighting:
//!
//! 1. *levels* reprojects the diffuse light of the last frame onto the surfaces of this frame, at four mip levels.
//! 2. *gather* marches over depth from each texel. The sixteen texels of a 4×4 block take different directions.
//! 3. *filter* averages 4×4 texels of the same surface, which brings the sixteen directions together, and more of them where few
//!    directions have most of the light.
//!
//! Lighting adds the light and attenuates environment maps, irradiance volumes and ambient light by the occlusion. The GPU time of the
//! three passes is recorded as `lean_deferred/effects/diffuse_gi`.

// - `settings.rs`: the component.
// - `uniforms.rs`, `view.wgsl`: the uniform of a view.
// - `key.rs`: pipeline keys.
// - `pipelines.rs`: the table of the passes, their bindings and pipelines.
// - `active.rs`: decides per view and frame if light is computed.
// - `textures.rs`: the textures of a view, and its history.
// - `prepare.rs`: uniforms and bind groups of views.
// - `pass.rs`: runs the passes.
// - `entry.wgsl`: the words of the levels.
// - `levels.wgsl`: depth, and the reprojected light of the last frame.
// - `gather.wgsl`: light and occlusion of each texel.
// - `filter.wgsl`: the mean of 4×4 texels, and of more beside small lamps.
// - `forward_light.{rs,wgsl}`: adds the light of meshes that Bevy's forward passes draw.
// - `binding_numbers.rs`, `bindings.wgsl`: binding numbers and declarations.

mod active;
#[doc(hidden)]
pub mod binding_numbers;
mod forward_light;
mod key;
mod pass;
mod pipelines;
mod prepare;
mod settings;
mod textures;
mod uniforms;

pub use settings::{LeanScreenSpaceGi, LeanScreenSpaceGiAdvanced};
// For tests and benches.
#[doc(hidden)]
pub use {
    active::ActiveGi, forward_light::ForwardLight, pipelines::PASSES, prepare::GiBindings,
    textures::ViewGi, uniforms::GiUniform,
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
    debug_view::DebugViewPlugin, history_validity::HistoryValidityPlugin,
    reprojection::ReprojectionPlugin, shown_exposure::ShownExposurePlugin, support,
};
use crate::{
    gpu::{recovery, texture_bytes::texture_bytes},
    view::{
        ActiveLeanView, DiffuseLight, Effect, EffectSystems, GBufferPasses, IndirectDiffuse,
        IndirectLightPasses, LeanMemory, LeanViewSystems, LightingPasses, OpaquePicturePasses,
        ReadsDiffuseLight, SharedPlugin, ViewTextureSystems, can_build, memory, removal,
        require_lean, status, support::add_check,
    },
};

/// Adds diffuse GI for cameras with [`LeanScreenSpaceGi`]. Does nothing without
/// [`LeanDeferredPlugin`](crate::LeanDeferredPlugin). Part of [`LeanDeferredPlugins`](crate::LeanDeferredPlugins); alone, add it after
/// `DefaultPlugins`.
#[derive(Default)]
pub struct LeanScreenSpaceGiPlugin;

impl Plugin for LeanScreenSpaceGiPlugin {
    fn build(&self, app: &mut App) {
        if !can_build(app, "LeanScreenSpaceGiPlugin", true) {
            return;
        }
        SharedPlugin::add_to(app);
        HistoryValidityPlugin::add_to(app);
        ReprojectionPlugin::add_to(app);
        load_shader_library!(app, "view.wgsl");
        load_shader_library!(app, "entry.wgsl");
        load_shader_library!(app, "bindings.wgsl");
        load_shader_library!(app, "shown_pixel.wgsl");
        embedded_asset!(app, "levels.wgsl");
        embedded_asset!(app, "gather.wgsl");
        embedded_asset!(app, "filter.wgsl");
        embedded_asset!(app, "forward_light.wgsl");
        app.register_type::<LeanScreenSpaceGi>()
            .add_plugins(ExtractComponentPlugin::<LeanScreenSpaceGi>::default());
        app.add_plugins(ShownExposurePlugin::<ViewGi>::default());
        DebugViewPlugin::add_to(app);
        add_check(app, |support| &mut support.screen_space, support::check);
        require_lean::<LeanScreenSpaceGi>(app);
        status::add_to::<LeanScreenSpaceGi>(app, Effect::DiffuseGi);

        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        removal::remove_with::<LeanScreenSpaceGi, ActiveGi>(render_app);
        removal::remove_with::<ActiveGi, (ViewGi, IndirectDiffuse, ReadsDiffuseLight)>(render_app);
        removal::remove_with::<ActiveLeanView, ViewGi>(render_app);
        removal::remove_with::<ViewGi, (GiBindings, ForwardLight)>(render_app);
        EffectSystems::DiffuseGi.run_while::<With<LeanScreenSpaceGi>>(render_app);
        let field: fn(&mut LeanMemory) -> &mut u64 = |memory| &mut memory.diffuse_gi;
        memory::count(render_app, field, ViewGi::bytes);
        memory::count::<DiffuseLight>(render_app, field, |light| {
            let [now, last] = [&light.texture, &light.last].map(|held| &held.texture);
            let former = if now.id() == last.id() {
                0
            } else {
                texture_bytes(last)
            };
            texture_bytes(now) + former
        });
        render_app
            .init_gpu_resource::<prepare::GiUniforms>()
            .add_systems(
                RenderStartup,
                (
                    pipelines::init_gi_pipelines,
                    forward_light::init_forward_light_pipeline,
                    recovery::forget::<LeanScreenSpaceGi>,
                ),
            )
            .add_systems(
                Render,
                (
                    active::decide_active_gi
                        .in_set(RenderSystems::PrepareAssets)
                        .before(LeanViewSystems),
                    prepare::prepare_gi.in_set(ViewTextureSystems),
                    (
                        prepare::prepare_gi_bind_groups,
                        forward_light::prepare_forward_light,
                    )
                        .in_set(RenderSystems::PrepareBindGroups),
                )
                    .in_set(EffectSystems::DiffuseGi),
            )
            .add_systems(
                Core3d,
                (
                    pass::find_diffuse_light
                        .in_set(Core3dSystems::MainPass)
                        .in_set(IndirectLightPasses)
                        .after(GBufferPasses)
                        .before(LightingPasses),
                    forward_light::add_forward_light.in_set(OpaquePicturePasses),
                )
                    .in_set(EffectSystems::DiffuseGi),
            );
    }
}
