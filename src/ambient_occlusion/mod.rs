//! Ambient occlusion: what neighbouring surfaces hide from the light that comes from everywhere, found from depth.
//!
//! Put [`LeanAmbientOcclusion`] on any `Camera3d`. It needs no prepass: it reads the depth that the opaque meshes leave.
//!
//! 1. A pass gathers occlusion into a texture of one channel, by horizons ([`OcclusionKernel::Hbao`]) or by valleys of depth
//!    ([`OcclusionKernel::Hdao`]), at full or half resolution.
//! 2. A filter removes the pattern of 2×2 or 4×4 pixels in which samples are laid out ([`OcclusionFilter`]).
//! 3. The occlusion reaches the picture ([`OcclusionApplication`]):
//!
//! | application | default for cameras | what it darkens |
//! |---|---|---|
//! | `Indirect` | with [`LeanDeferred`](crate::LeanDeferred) | ambient light, environment maps, probes, irradiance volumes; in the lighting pass |
//! | `MultiplicativeBlend` | without | the whole picture after the opaque meshes, direct light too |
//!
//! The samples are the same in every frame: there is no noise, and TAA is not needed. Passes are timed as
//! `lean_deferred/ambient_occlusion/gather` and `…/merge`.
//!
//! A device that cannot store the texture's format from compute shaders draws it instead ([`OcclusionSupport`]).

// - `settings.rs`: the component. `support.rs`: what the device can do.
// - `uniforms.rs`, `key.rs`, `pipelines.rs`: what the shaders read, and what they are compiled by.
// - `active.rs`: whether and how a view gets it in this frame. `prepare.rs`: what the passes need of the view.
// - `pass.rs`: the gather, as a compute or a raster pass, and the merge.
// - `view.wgsl`, `bindings.wgsl`, `binding_numbers.rs`: what the shaders read, and where.
// - `hbao.wgsl`, `hdao.wgsl`: the kernels. `gather.wgsl`: their entry points.
// - `filter.wgsl`: the filter, for `merge.wgsl` and the lighting pass.

mod active;
#[doc(hidden)]
pub mod binding_numbers;
mod key;
mod pass;
mod pipelines;
mod prepare;
mod settings;
mod support;
mod uniforms;

pub use settings::{
    LeanAmbientOcclusion, OcclusionApplication, OcclusionFilter, OcclusionFormat, OcclusionKernel,
    OcclusionNormals, OcclusionQuality, OcclusionResolution,
};
#[doc(hidden)]
pub use support::COMPUTE_LIMITS;
pub use support::OcclusionSupport;
// For tests and benches.
#[doc(hidden)]
pub use {
    active::ActiveOcclusion,
    prepare::{OcclusionBindings, OcclusionTexture, ViewOcclusion},
    uniforms::OcclusionView,
};

pub(crate) use key::FilterKey;
pub(crate) use pipelines::OcclusionPipelines;
pub(crate) use prepare::OcclusionUniforms;

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
        EffectSystems, FoundLightPasses, GBufferPasses, LeanViewSystems, LightingPasses,
        OpaquePicturePasses, SharedPlugin, ViewTextureSystems, can_build,
        depth_usage::extend_depth_usage, overrides, removal,
    },
};

/// What the lighting pass imports, whether there is occlusion or not: Bevy wants all modules that a shader names.
pub(crate) fn load_shader_library(app: &mut App) {
    load_shader_library!(app, "view.wgsl");
    load_shader_library!(app, "filter.wgsl");
}

/// Ambient occlusion, for cameras with [`LeanAmbientOcclusion`]. Part of
/// [`LeanDeferredPlugins`](crate::LeanDeferredPlugins); alone, add it after `DefaultPlugins`.
#[derive(Default)]
pub struct LeanAmbientOcclusionPlugin;

impl Plugin for LeanAmbientOcclusionPlugin {
    fn build(&self, app: &mut App) {
        if !can_build(app, "LeanAmbientOcclusionPlugin", false) {
            return;
        }
        SharedPlugin::add_to(app);
        load_shader_library(app);
        load_shader_library!(app, "bindings.wgsl");
        load_shader_library!(app, "hbao.wgsl");
        load_shader_library!(app, "hdao.wgsl");
        embedded_asset!(app, "gather.wgsl");
        embedded_asset!(app, "merge.wgsl");
        app.register_type::<LeanAmbientOcclusion>()
            .add_plugins(ExtractComponentPlugin::<LeanAmbientOcclusion>::default());
        overrides::add_to::<LeanAmbientOcclusion>(app, |world| {
            world.contains_resource::<RenderDevice>()
        });

        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        removal::remove_with::<LeanAmbientOcclusion, ActiveOcclusion>(render_app);
        removal::remove_with::<ActiveOcclusion, (OcclusionTexture, ViewOcclusion, OcclusionBindings)>(
            render_app,
        );
        EffectSystems::AmbientOcclusion.run_while::<With<LeanAmbientOcclusion>>(render_app);
        render_app
            .init_gpu_resource::<OcclusionUniforms>()
            .init_gpu_resource::<OcclusionSupport>()
            .add_systems(
                RenderStartup,
                (
                    pipelines::init_occlusion_pipelines,
                    recovery::forget::<LeanAmbientOcclusion>,
                ),
            )
            .add_systems(
                Render,
                (
                    active::decide_active_occlusion
                        .in_set(RenderSystems::PrepareAssets)
                        .after(LeanViewSystems),
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
                Core3d,
                (
                    pass::occlusion_for_lighting
                        .in_set(Core3dSystems::MainPass)
                        .in_set(FoundLightPasses)
                        .after(GBufferPasses)
                        .before(LightingPasses),
                    pass::occlusion_after_opaque.in_set(OpaquePicturePasses),
                )
                    .in_set(EffectSystems::AmbientOcclusion),
            );
    }
}
