//! Subsurface scattering, after lighting: light that enters a surface leaves it elsewhere, by Burley's profile (Christensen and
//! Burley 2015, "Approximate Reflectance Profiles for Efficient Subsurface Scattering").
//!
#![cfg_attr(
    doc,
    doc = concat!(
        "<img alt=\"A cat of jade\" src=\"data:image/jpeg;base64,",
        include_str!("../../../docs/pictures/thumbs/subsurface_scattering.jpg.base64"),
        "\">\n\n*A cat of jade between two lamps: without scattering, and with it.*"
    )
)]
//!
//! Give a mesh an [`ExtendedStandardMaterial`](crate::material_extension::ExtendedStandardMaterial) with
//! [`ShadingExtension::Subsurface`](crate::material_extension::ShadingExtension::Subsurface), and put [`LeanSubsurfaceScattering`] on a
//! camera, which gets [`LeanDeferred`](crate::LeanDeferred) with it.
//!
//! Lighting writes the diffuse light of such surfaces to a texture of its own, in the tiles that have some. The passes run on the
//! blocks of tiles with such light and add the change due to scattering to the picture. The picture is unchanged until they are
//! compiled, and where light leaves where it entered.
//!
//! Entering light is reduced into a pyramid of ever coarser levels, and accumulated back to the finest. On the way, each level keeps
//! a share of its light, which this level's kernel, about two texels wide, spreads (Strengert, Kraus and Ertl 2006, "Pyramid Methods
//! in GPU-Based Image Processing"). The sum of all kernels is the profile.

// - `settings.rs`: the component.
// - `support.rs`: limits that the device needs.
// - `uniforms.rs`, `view.wgsl`: the uniforms of a view.
// - `key.rs`: pipeline keys.
// - `pipelines.rs`: the table of the passes, their bindings and pipelines.
// - `active.rs`: decides per view and frame if light is scattered.
// - `prepare.rs`: uniforms, textures and bind groups of views.
// - `pass.rs`: runs the passes.
// - `down.wgsl`: from finer to coarser levels.
// - `turn.wgsl`: the two coarsest levels.
// - `up.wgsl`: from coarser to finer levels.
// - `picture.wgsl`: from the finest level to the picture.
// - `mean.wgsl`: a texel of a coarser level.
// - `scattered.wgsl`: scattered light of a texel, from its own level and the coarser one.
// - `profile.wgsl`: the shares of the levels.
// - `texel.wgsl`: listed blocks, and positions of texels.
// - `entries.wgsl`: texels in shared memory.
// - `binding_numbers.rs`, `bindings.wgsl`: binding numbers and declarations.
// - `lighting/subsurface_light.rs` allocates the textures of entering light.

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

pub use settings::{LeanSubsurfaceScattering, LeanSubsurfaceScatteringAdvanced};
// For tests and benches.
#[doc(hidden)]
pub use {
    active::ActiveScattering,
    pipelines::PASSES,
    prepare::ViewSubsurface,
    support::{NEEDED_LIMITS, missing_for_scattering},
    uniforms::SubsurfaceUniform,
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
        Effect, EffectSystems, LeanMemory, LeanViewSystems, LightingPasses, ScattersLight,
        SharedPlugin, ViewTextureSystems, can_build, memory, removal, require_lean, status,
        support::add_check,
    },
};

/// Adds subsurface scattering for cameras with [`LeanSubsurfaceScattering`]. Does nothing without
/// [`LeanDeferredPlugin`](crate::LeanDeferredPlugin). Part of [`LeanDeferredPlugins`](crate::LeanDeferredPlugins); alone, add it after
/// `DefaultPlugins`.
#[derive(Default)]
pub struct LeanSubsurfaceScatteringPlugin;

impl Plugin for LeanSubsurfaceScatteringPlugin {
    fn build(&self, app: &mut App) {
        if !can_build(app, "LeanSubsurfaceScatteringPlugin", true) {
            return;
        }
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
        add_check(app, |support| &mut support.subsurface, support::check);
        require_lean::<LeanSubsurfaceScattering>(app);
        status::add_to::<LeanSubsurfaceScattering>(app, Effect::Subsurface);

        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        removal::remove_with::<LeanSubsurfaceScattering, ActiveScattering>(render_app);
        removal::remove_with::<ActiveScattering, (ViewSubsurface, ScattersLight)>(render_app);
        removal::remove_with::<SubsurfaceLight, ViewSubsurface>(render_app);
        EffectSystems::SubsurfaceScattering.run_while::<With<LeanSubsurfaceScattering>>(render_app);
        let field: fn(&mut LeanMemory) -> &mut u64 = |memory| &mut memory.subsurface;
        memory::count(render_app, field, ViewSubsurface::bytes);
        memory::count(render_app, field, SubsurfaceLight::bytes);
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
