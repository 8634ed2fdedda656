//! Subsurface scattering, after lighting: light that enters a surface leaves it elsewhere, by Burley's profile (Christensen and
//! Burley 2015, "Approximate Reflectance Profiles for Efficient Subsurface Scattering").
//!
//! Give a mesh an [`ExtendedStandardMaterial`](crate::shading_extension::ExtendedStandardMaterial) with
//! [`ShadingExtension::Subsurface`](crate::shading_extension::ShadingExtension::Subsurface). Cameras with
//! [`LeanDeferred`] scatter its light without being told; [`LeanSubsurfaceScattering`] on the camera has the quality.
//!
//! Lighting writes the diffuse light of such surfaces apart, in the tiles that have some. The passes go over the blocks of tiles
//! with any, and add to the picture what scattering changes. Until they are compiled, and where light leaves where it entered, the picture
//! stays as it is. What enters is brought into ever coarser levels, and back: on the way, each level keeps a share of what it has, so
//! that it is spread by this level's kernel, about two texels wide (Strengert, Kraus and Ertl 2006, "Pyramid Methods in GPU-Based
//! Image Processing"). All kernels together are the profile.

// - `settings.rs`: the component. `support.rs`: what the device can do.
// - `uniforms.rs`, `key.rs`, `pipelines.rs`: what the shaders read, and what they are compiled by.
// - `active.rs`: whether a view gets it in this frame. `prepare.rs`: what the passes need of the view.
// - `pass.rs`: the passes. `down.wgsl`: to coarser levels. `turn.wgsl`: to the coarsest one and back. `up.wgsl`: to finer ones.
//   `picture.wgsl`: to the picture.
// - `mean.wgsl`: a texel of a coarser level. `scattered.wgsl`: what scatters to a finer one. `profile.{rs,wgsl}`: the shares.
// - `texel.wgsl`: what passes go over. `entries.wgsl`: what a workgroup keeps of that.
// - `view.wgsl`, `bindings.wgsl`, `binding_numbers.rs`: what the shaders read, and where.
// - The light comes from `lighting/subsurface_light.rs`.

mod active;
#[doc(hidden)]
pub mod binding_numbers;
mod key;
mod pass;
mod pipelines;
mod prepare;
#[doc(hidden)]
pub mod profile;
mod settings;
mod support;
mod uniforms;

pub use settings::{LeanSubsurfaceScattering, SubsurfaceScatteringQuality};
// For tests and benches.
#[doc(hidden)]
pub use {
    active::ActiveScattering,
    prepare::ViewSubsurface,
    support::{NEEDED_LIMITS, missing_for_scattering},
    uniforms::SubsurfaceView,
};

use bevy::{
    asset::embedded_asset,
    core_pipeline::{
        core_3d::main_opaque_pass_3d,
        schedule::{Core3d, Core3dSystems},
    },
    prelude::*,
    render::{
        GpuResourceAppExt, Render, RenderApp, RenderStartup, RenderSystems,
        extract_component::ExtractComponentPlugin,
    },
    shader::load_shader_library,
};

use crate::{
    gpu::recovery,
    lighting::{SubsurfaceLight, lighting_pass, prepare_subsurface_light},
    view::{
        EffectSystems, LeanDeferred, LeanViewSystems, LightingPasses, ScattersLight, SharedPlugin,
        ViewTextureSystems, removal,
    },
};

/// Subsurface scattering, for cameras with [`LeanDeferred`]. Part of
/// [`LeanDeferredPlugin`](crate::LeanDeferredPlugin), whose materials ask for it.
pub(crate) struct SubsurfacePlugin;

impl Plugin for SubsurfacePlugin {
    fn build(&self, app: &mut App) {
        SharedPlugin::add_to(app);
        load_shader_library!(app, "view.wgsl");
        load_shader_library!(app, "bindings.wgsl");
        load_shader_library!(app, "profile.wgsl");
        load_shader_library!(app, "texel.wgsl");
        load_shader_library!(app, "entries.wgsl");
        load_shader_library!(app, "mean.wgsl");
        load_shader_library!(app, "scattered.wgsl");
        embedded_asset!(app, "down.wgsl");
        embedded_asset!(app, "turn.wgsl");
        embedded_asset!(app, "up.wgsl");
        embedded_asset!(app, "picture.wgsl");
        app.register_type::<LeanSubsurfaceScattering>()
            .add_plugins(ExtractComponentPlugin::<LeanSubsurfaceScattering>::default());

        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        removal::remove_with::<LeanDeferred, ActiveScattering>(render_app);
        removal::remove_with::<ActiveScattering, (ViewSubsurface, ScattersLight)>(render_app);
        removal::remove_with::<SubsurfaceLight, ViewSubsurface>(render_app);
        EffectSystems::SubsurfaceScattering
            .run_while::<Or<(With<LeanDeferred>, With<LeanSubsurfaceScattering>)>>(render_app);
        render_app
            .init_gpu_resource::<prepare::SubsurfaceUniforms>()
            .add_systems(
                RenderStartup,
                (
                    pipelines::init_subsurface_pipelines,
                    recovery::forget::<LeanSubsurfaceScattering>,
                ),
            )
            .add_systems(
                Render,
                (
                    active::decide_active_scattering
                        .in_set(RenderSystems::PrepareAssets)
                        .before(LeanViewSystems),
                    prepare::prepare_subsurface
                        .in_set(ViewTextureSystems)
                        .after(prepare_subsurface_light),
                    prepare::prepare_subsurface_bind_groups
                        .in_set(RenderSystems::PrepareBindGroups),
                )
                    .in_set(EffectSystems::SubsurfaceScattering),
            )
            .add_systems(
                Core3d,
                pass::scatter_light
                    .in_set(EffectSystems::SubsurfaceScattering)
                    .in_set(LightingPasses)
                    .after(lighting_pass)
                    .before(main_opaque_pass_3d)
                    .in_set(Core3dSystems::MainPass),
            );
    }
}
