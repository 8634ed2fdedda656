//! Screen-space reflections: rays through the depth of this frame, into the light of the last one.
//!
#![cfg_attr(
    doc,
    doc = concat!(
        "<img alt=\"A wet street\" src=\"data:image/jpeg;base64,",
        include_str!("../../../docs/pictures/thumbs/reflections.jpg.base64"),
        "\">\n\n*A wet street: without reflections, and with them.*"
    )
)]
//!
//! Put [`LeanScreenSpaceReflections`] on a camera, which gets [`LeanDeferred`](crate::LeanDeferred) with it. The picture of each frame,
//! as Bevy's transparent pass leaves it, is kept as history for the next frame. Four passes run between G-buffer and lighting:
//!
//! 1. *hi-z* stores the nearest and the furthest depth of each cell of pixels.
//! 2. *trace* traces a ray from each texel, in one of sixteen directions of the GGX lobe, which a block of 4×4 texels shares. Rays of
//!    smooth surfaces step from cell to cell and then from pixel to pixel; those of rough ones step in segments that grow with distance.
//! 3. *spatial filter* averages the rays around each texel, and for rough surfaces the lobes of four frames.
//! 4. *resolve* computes the reflection of each pixel from the rays or lobes around it.
//!
//! Lighting shows the result in the place of environment maps, probes and ambient light, with the same Fresnel and roughness terms. GPU
//! times are recorded as `lean_deferred/effects/history` and, of the four passes together, `lean_deferred/effects/reflections`.

// - `settings.rs`: the component.
// - `uniforms.rs`, `view.wgsl`: the uniform of a view.
// - `key.rs`: pipeline keys.
// - `pipelines.rs`: the table of the passes, their bindings and pipelines.
// - `forward.rs`: lets forward meshes trace rays through the textures of the passes.
// - `fixtures.rs`: samplers and a texture that all views share.
// - `active.rs`: decides per view and frame if reflections are computed.
// - `prepare.rs`: uniforms, textures and bind groups of views.
// - `pass.rs`: runs the passes.
// - `hi_z.wgsl`: the first pass.
// - `trace.wgsl`: the second pass.
// - `ray.wgsl`: a ray on screen, and its hits.
// - `smooth_march.wgsl`, `rough_march.wgsl`: the steps of rays of smooth and of rough surfaces.
// - `spatial_filter.wgsl`: the third pass.
// - `lobes.wgsl`: the lobes of the last frames.
// - `resolve.wgsl`: the fourth pass.
// - `receiver.wgsl`: the pixel that is resolved.
// - `smooth_light.wgsl`, `rough_light.wgsl`: reflections of smooth and of rough surfaces.
// - `texels.wgsl`: texels in shared memory, for the last two passes.
// - `surface.wgsl`: the reflecting surface, and its light in the last frame.
// - `mirrored_light.wgsl`: that light with the fog of its way over the mirror.
// - `binding_numbers.rs`, `bindings.wgsl`: binding numbers and declarations.

mod active;
#[doc(hidden)]
pub mod binding_numbers;
mod fixtures;
mod forward;
mod key;
mod pass;
mod pipelines;
mod prepare;
mod settings;
mod uniforms;

pub use settings::{LeanScreenSpaceReflections, LeanScreenSpaceReflectionsAdvanced};
// For tests and benches.
#[doc(hidden)]
pub use {
    active::ActiveReflections,
    pipelines::PASSES,
    prepare::{PHASES, ReflectionBindings, ViewReflections, WORKGROUP_SIDE},
    uniforms::ReflectionUniform,
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
    debug_view::{DebugViewPlugin, RayHits},
    history::{HistoryPlugin, ReadsHistory, prepare_histories, prepare_history_bind_groups},
    reprojection::ReprojectionPlugin,
    support,
};
use crate::{
    gpu::recovery,
    lighting::forward::{ForwardReflections, prepare_forward_groups},
    view::{
        ActiveLeanView, Effect, EffectSystems, GBufferPasses, IndirectLightPasses,
        IndirectSpecular, LeanViewSystems, LightingPasses, SharedPlugin, ViewTextureSystems,
        can_build, memory, removal, require_lean, status, support::add_check,
    },
};

/// Adds reflections for cameras with [`LeanScreenSpaceReflections`]. Does nothing without
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
        ReprojectionPlugin::add_to(app);
        load_shader_library!(app, "view.wgsl");
        load_shader_library!(app, "bindings.wgsl");
        load_shader_library!(app, "ray.wgsl");
        load_shader_library!(app, "smooth_march.wgsl");
        load_shader_library!(app, "rough_march.wgsl");
        load_shader_library!(app, "surface.wgsl");
        load_shader_library!(app, "mirrored_light.wgsl");
        load_shader_library!(app, "texels.wgsl");
        load_shader_library!(app, "receiver.wgsl");
        load_shader_library!(app, "smooth_light.wgsl");
        load_shader_library!(app, "rough_light.wgsl");
        load_shader_library!(app, "lobes.wgsl");
        embedded_asset!(app, "hi_z.wgsl");
        embedded_asset!(app, "trace.wgsl");
        embedded_asset!(app, "spatial_filter.wgsl");
        embedded_asset!(app, "resolve.wgsl");
        app.register_type::<LeanScreenSpaceReflections>()
            .add_plugins(ExtractComponentPlugin::<LeanScreenSpaceReflections>::default());
        DebugViewPlugin::add_to(app);
        add_check(app, |support| &mut support.screen_space, support::check);
        require_lean::<LeanScreenSpaceReflections>(app);
        status::add_to::<LeanScreenSpaceReflections>(app, Effect::Reflections);

        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        removal::remove_with::<LeanScreenSpaceReflections, (ActiveReflections, ReadsHistory)>(
            render_app,
        );
        removal::remove_with::<
            ActiveReflections,
            (
                ViewReflections,
                ReflectionBindings,
                IndirectSpecular,
                ForwardReflections,
            ),
        >(render_app);
        removal::remove_with::<ActiveLeanView, (ViewReflections, ReflectionBindings)>(render_app);
        removal::remove_with::<ViewReflections, RayHits>(render_app);
        EffectSystems::Reflections.run_while::<With<LeanScreenSpaceReflections>>(render_app);
        memory::count(
            render_app,
            |memory| &mut memory.reflections,
            ViewReflections::bytes,
        );
        render_app
            .init_gpu_resource::<prepare::ReflectionUniforms>()
            .init_gpu_resource::<fixtures::ReflectionFixtures>()
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
                    (
                        active::decide_active_reflections,
                        forward::decide_forward_reflections,
                    )
                        .chain()
                        .in_set(RenderSystems::PrepareAssets)
                        .before(LeanViewSystems),
                    prepare::prepare_reflections
                        .in_set(ViewTextureSystems)
                        .after(prepare_histories),
                    prepare::prepare_reflection_bind_groups
                        .in_set(RenderSystems::PrepareBindGroups)
                        .after(prepare_history_bind_groups),
                    forward::prepare_forward_reflections
                        .in_set(RenderSystems::PrepareBindGroups)
                        .after(prepare_history_bind_groups)
                        .before(prepare_forward_groups),
                )
                    .in_set(EffectSystems::Reflections),
            )
            .add_systems(
                Core3d,
                pass::find_reflections
                    .in_set(EffectSystems::Reflections)
                    .in_set(Core3dSystems::MainPass)
                    .in_set(IndirectLightPasses)
                    .after(GBufferPasses)
                    .before(LightingPasses),
            );
    }
}
