//! Ambient occlusion: neighbouring surfaces in the depth buffer block ambient light.
//!
//! Put [`LeanScreenSpaceAmbientOcclusion`] on any `Camera3d`. It needs no prepass: it reads the depth of the opaque meshes.
//!
#![cfg_attr(
    doc,
    doc = concat!(
        "<img alt=\"A courtyard\" src=\"data:image/jpeg;base64,",
        include_str!("../../../docs/pictures/thumbs/ambient_occlusion.jpg.base64"),
        "\">\n\n*A courtyard under an overcast sky: without occlusion, and with it.*"
    )
)]
//!
//! 1. A pass gathers occlusion into a single-channel texture at full or half resolution, from horizons ([`OcclusionKernel::Hbao`]) or
//!    from valleys of depth ([`OcclusionKernel::Hdao`]).
//! 2. A filter removes the pattern of the samples, 2×2 or 4×4 pixels ([`OcclusionFilter`]).
//! 3. The occlusion is applied ([`OcclusionApplication`]):
//!
//! | application | default for cameras | darkens |
//! |---|---|---|
//! | `Indirect` | with [`LeanDeferred`] | ambient light, environment maps, probes, irradiance volumes; in the lighting pass |
//! | `MultiplicativeBlend` | without | the whole picture after the opaque meshes, direct light too |
//!
//! The pattern of the samples is the same in every frame: there is no noise, and TAA is not needed. GPU times are recorded as
//! `lean_deferred/effects/ambient_occlusion/gather` and `…/merge`.
//!
//! If compute shaders cannot store to `R8Unorm`, a raster pass writes the texture
//! ([`LeanSupport::ambient_occlusion_by_compute`]).
//!
//! [`LeanDeferred`]: crate::LeanDeferred
//! [`LeanSupport::ambient_occlusion_by_compute`]: crate::LeanSupport::ambient_occlusion_by_compute

// - `settings.rs`: the component.
// - `support.rs`: capabilities of the device, and the texture's format.
// - `uniforms.rs`, `view.wgsl`: the uniform of a view.
// - `key.rs`: pipeline keys.
// - `pipelines.rs`: layouts and pipelines.
// - `active.rs`: decides per view and frame if and how occlusion is computed and applied.
// - `prepare.rs`: uniforms, textures and bind groups of views.
// - `pass.rs`: the gather, as a compute or a raster pass, and the merge.
// - `lattice.{rs,wgsl}`, `sparse_depth.wgsl`: depths that distant samples read, and the compute pass that stores them.
// - `binding_numbers.rs`, `bindings.wgsl`: binding numbers and declarations.
// - `hbao.wgsl`, `hdao.wgsl`: the kernels.
// - `gather.wgsl`: entry points of the kernels.
// - `merge.wgsl`: filters occlusion and darkens the picture by it.
// - `debug_view.{rs,wgsl}`: shows filtered occlusion in place of the picture.

mod active;
#[doc(hidden)]
pub mod binding_numbers;
mod debug_view;
mod key;
#[doc(hidden)]
pub mod lattice;
mod pass;
mod pipelines;
mod prepare;
mod settings;
mod support;
mod uniforms;

pub use settings::{
    LeanScreenSpaceAmbientOcclusion, LeanScreenSpaceAmbientOcclusionAdvanced, OcclusionApplication,
    OcclusionFilter, OcclusionKernel, OcclusionNormals,
};
#[doc(hidden)]
pub use support::COMPUTE_LIMITS;
// For tests and benches.
#[doc(hidden)]
pub use {
    active::ActiveOcclusion,
    prepare::{OcclusionBindings, OcclusionTextures, ViewOcclusion},
    uniforms::OcclusionUniform,
};

use debug_view::ShownOcclusion;

use bevy::{
    asset::embedded_asset,
    core_pipeline::schedule::{Core3d, Core3dSystems},
    prelude::*,
    render::{
        GpuResourceAppExt, Render, RenderApp, RenderStartup, RenderSystems,
        extract_component::ExtractComponentPlugin, render_resource::TextureUsages,
        renderer::RenderDevice,
    },
    shader::load_shader_library,
};

use crate::{
    gpu::recovery,
    view::{
        AmbientOcclusion, DebugViewPasses, Effect, EffectSystems, GBufferPasses, HistoryPasses,
        IndirectLightPasses, LeanDebugView, LeanViewSystems, LightingPasses, OccludesLight,
        OpaquePicturePasses, SharedPlugin, ViewTextureSystems, can_build,
        debug_draw::{DebugDrawn, draw_debug_view},
        depth_usage::extend_depth_usage,
        memory, overrides, removal, status,
        support::add_check,
    },
};

/// Adds ambient occlusion for cameras with [`LeanScreenSpaceAmbientOcclusion`]. Part of
/// [`LeanDeferredPlugins`](crate::LeanDeferredPlugins); alone, add it after `DefaultPlugins`.
#[derive(Default)]
pub struct LeanScreenSpaceAmbientOcclusionPlugin;

impl Plugin for LeanScreenSpaceAmbientOcclusionPlugin {
    fn build(&self, app: &mut App) {
        if !can_build(app, "LeanScreenSpaceAmbientOcclusionPlugin", false) {
            return;
        }
        SharedPlugin::add_to(app);
        load_shader_library!(app, "view.wgsl");
        load_shader_library!(app, "bindings.wgsl");
        load_shader_library!(app, "lattice.wgsl");
        load_shader_library!(app, "hbao.wgsl");
        load_shader_library!(app, "hdao.wgsl");
        embedded_asset!(app, "sparse_depth.wgsl");
        embedded_asset!(app, "gather.wgsl");
        embedded_asset!(app, "merge.wgsl");
        embedded_asset!(app, "debug_view.wgsl");
        app.register_type::<LeanScreenSpaceAmbientOcclusion>()
            .add_plugins(ExtractComponentPlugin::<LeanScreenSpaceAmbientOcclusion>::default());
        add_check(
            app,
            |support| &mut support.ambient_occlusion_by_compute,
            support::check_compute,
        );
        status::add_to::<LeanScreenSpaceAmbientOcclusion>(app, Effect::AmbientOcclusion);
        overrides::add_to::<LeanScreenSpaceAmbientOcclusion>(app, |world| {
            world.contains_resource::<RenderDevice>()
        });

        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        removal::remove_with::<LeanScreenSpaceAmbientOcclusion, (ActiveOcclusion, OccludesLight)>(
            render_app,
        );
        removal::remove_with::<
            ActiveOcclusion,
            (
                OcclusionTextures,
                ViewOcclusion,
                OcclusionBindings,
                AmbientOcclusion,
                DebugDrawn<ShownOcclusion>,
            ),
        >(render_app);
        removal::remove_with::<LeanDebugView, DebugDrawn<ShownOcclusion>>(render_app);
        EffectSystems::AmbientOcclusion
            .run_while::<With<LeanScreenSpaceAmbientOcclusion>>(render_app);
        memory::count(
            render_app,
            |memory| &mut memory.ambient_occlusion,
            OcclusionTextures::bytes,
        );
        render_app
            .init_gpu_resource::<prepare::OcclusionUniforms>()
            .add_systems(
                RenderStartup,
                (
                    pipelines::init_occlusion_pipelines,
                    debug_view::init_debug_pipelines,
                    recovery::forget::<LeanScreenSpaceAmbientOcclusion>,
                ),
            )
            .add_systems(
                Render,
                (
                    (
                        active::request_lighting.before(LeanViewSystems),
                        active::decide_active_occlusion.after(LeanViewSystems),
                    )
                        .in_set(RenderSystems::PrepareAssets),
                    (
                        prepare::write_occlusion_uniforms,
                        prepare::prepare_occlusion_textures,
                    )
                        .chain()
                        .in_set(ViewTextureSystems),
                    extend_depth_usage::<ActiveOcclusion>(TextureUsages::TEXTURE_BINDING),
                    prepare::prepare_occlusion_bind_groups.in_set(RenderSystems::PrepareBindGroups),
                )
                    .in_set(EffectSystems::AmbientOcclusion),
            )
            .add_systems(
                Render,
                debug_view::prepare_debug_views
                    .in_set(RenderSystems::PrepareBindGroups)
                    .in_set(EffectSystems::DebugViews),
            )
            .add_systems(
                Core3d,
                (
                    pass::occlusion_for_lighting
                        .in_set(Core3dSystems::MainPass)
                        .in_set(IndirectLightPasses)
                        .after(GBufferPasses)
                        .before(LightingPasses),
                    pass::occlusion_after_opaque.in_set(OpaquePicturePasses),
                )
                    .in_set(EffectSystems::AmbientOcclusion),
            )
            .add_systems(
                Core3d,
                draw_debug_view::<ShownOcclusion>
                    .in_set(EffectSystems::DebugViews)
                    .in_set(Core3dSystems::MainPass)
                    .in_set(DebugViewPasses)
                    .after(HistoryPasses),
            );
    }
}
