//! Lights meshes that Bevy's passes draw on lean cameras: blended ones, and others that the G-buffer does not carry.
//!
//! Bevy's fragment shader lights a pixel by all lights of its cluster. Here, the pipeline of such a mesh is replaced by Bevy's own
//! with another fragment shader (`forward.wgsl`), which lights by the functions in `lights/`: they skip lights out of range before
//! anything else is computed, and respect light layers. On views with [`ForwardReflections`], they add the light of the last frame that
//! the mesh mirrors. Vertex shader, bind groups, blending and depth are Bevy's, and the mesh
//! stays in Bevy's phase, in its order. Meshes whose fragment shader is not that of `StandardMaterial` keep their own, as do those that
//! [`BevyLitReason`] lists; shaders of apps that call the light functions are compiled with reflections.

// - `reasons.rs`: the reasons for which Bevy's fragment shader lights a mesh.
// - `definitions.rs`: shader definitions.
// - `material.rs`: lets shaders of apps call the light functions.
// - `pipelines.rs`: the pipelines, by Bevy's.
// - `queue.rs`: replaces the pipelines of meshes that Bevy has queued.
// - `own_group.rs`: binds the layers of lights and the textures of reflections.
// - `binding_numbers.rs`, `bindings.wgsl`: the crate's own bind group.
// - `reflections.rs`: textures and uniform that an effect provides for reflections.
// - `light.wgsl`: the light of a surface, also for shaders of apps.
// - `reflected_light.wgsl`: the picture in its mirror, also for shaders of apps.
// - `march.wgsl`, `last_frame.wgsl`: the way of its ray, and the surfaces of the last frame along it.
// - `forward.wgsl`: the fragment shader.

#[doc(hidden)]
pub mod binding_numbers;
#[doc(hidden)]
pub mod definitions;
mod material;
mod own_group;
mod pipelines;
mod queue;
mod reasons;
mod reflections;

pub use material::define_lean_lighting;
// For tests.
#[doc(hidden)]
pub use pipelines::PIPELINE_LABEL;
#[doc(hidden)]
pub use reasons::BevyLitReason;
#[doc(hidden)]
pub use reflections::{ForwardReflectionTextures, ForwardReflectionUniform, ForwardReflections};

pub(super) use own_group::OwnGroups;
pub(crate) use own_group::prepare_forward_groups;

use ::bevy::{
    asset::embedded_asset,
    core_pipeline::core_3d::{AlphaMask3d, Opaque3d, Transparent3d},
    prelude::*,
    render::{Render, RenderApp, RenderStartup, RenderSystems, render_phase::AddRenderCommand},
    shader::load_shader_library,
};

use super::bindings::prepare_lighting_bind_groups;
use crate::view::{EffectSystems, ForwardMeshesQueued};
use own_group::DrawWithOwnGroup;

/// Lights meshes that Bevy's passes draw.
pub(super) struct ForwardLightPlugin;

impl Plugin for ForwardLightPlugin {
    fn build(&self, app: &mut App) {
        load_shader_library!(app, "bindings.wgsl");
        load_shader_library!(app, "last_frame.wgsl");
        load_shader_library!(app, "march.wgsl");
        load_shader_library!(app, "reflected_light.wgsl");
        load_shader_library!(app, "light.wgsl");
        embedded_asset!(app, "forward.wgsl");
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .add_render_command::<Opaque3d, DrawWithOwnGroup<false>>()
            .add_render_command::<AlphaMask3d, DrawWithOwnGroup<false>>()
            .add_render_command::<Transparent3d, DrawWithOwnGroup<false>>()
            .add_render_command::<Opaque3d, DrawWithOwnGroup<true>>()
            .add_render_command::<AlphaMask3d, DrawWithOwnGroup<true>>()
            .add_render_command::<Transparent3d, DrawWithOwnGroup<true>>()
            .add_systems(RenderStartup, pipelines::init_forward_pipelines)
            .add_systems(
                Render,
                (
                    queue::light_forward_meshes
                        .in_set(RenderSystems::QueueMeshes)
                        .after(ForwardMeshesQueued),
                    prepare_forward_groups
                        .in_set(RenderSystems::PrepareBindGroups)
                        .after(prepare_lighting_bind_groups),
                )
                    .in_set(EffectSystems::Lean),
            );
    }
}
