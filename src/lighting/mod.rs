//! The lighting pass: one compute dispatch over the packed G-buffer, with Bevy's own lighting functions.
//!
//! - `features.rs`: what a view has to be lit with, and so what its shader is compiled with and binds.
//! - `pipeline.rs`: layouts and pipelines.
//! - `buffers.rs`, `bindings.rs`: the buffers and the bind groups, made anew only when what they bind changed.
//! - `pass.rs`: the dispatch.
//! - `lighting.wgsl`, `geometric_normal.{wgsl,rs}`: the shader, and its binding-free maths, twice.

mod bindings;
mod buffers;
mod features;
pub mod geometric_normal;
mod pass;
mod pipeline;

pub(crate) use features::{LightingKey, SceneFeatures};
pub(crate) use pipeline::LightingPipelines;

use bevy::{
    asset::embedded_asset,
    core_pipeline::{
        core_3d::main_opaque_pass_3d,
        schedule::{Core3d, Core3dSystems},
    },
    pbr::{MeshPipelineSystems, prepare_mesh_view_bind_groups},
    prelude::*,
    render::{
        GpuResourceAppExt, Render, RenderApp, RenderStartup, RenderSystems,
        render_resource::{BindGroup, CachedComputePipelineId},
    },
};

use crate::shared::SharedPlugin;

/// On a view: everything its lighting pass needs. Dropped with the effect.
#[derive(Component, Default)]
pub struct ViewLighting {
    /// The key and the pipeline of this frame.
    pub(crate) pipeline: Option<(LightingKey, CachedComputePipelineId)>,
    bindings: bindings::ViewLightingBindings,
}

/// The lighting pass, in `Core3d`.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
pub struct LightingPasses;

impl ViewLighting {
    /// The bind groups that stay as they are from frame to frame until something that they bind is replaced: light
    /// probes and decals, and the G-buffer with either main texture. Another one, of the view, follows Bevy, which
    /// makes the buffers of the light clusters anew in each frame.
    pub fn lasting_bind_groups(&self) -> impl Iterator<Item = &BindGroup> {
        self.bindings.lasting()
    }
}

/// Lights the packed G-buffer.
pub(crate) struct LightingPlugin;

impl Plugin for LightingPlugin {
    fn build(&self, app: &mut App) {
        SharedPlugin::add_to(app);
        embedded_asset!(app, "lighting.wgsl");

        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_gpu_resource::<buffers::LightingBuffers>()
            .add_systems(
                RenderStartup,
                pipeline::init_lighting_pipelines.after(MeshPipelineSystems),
            )
            .add_systems(
                Render,
                (
                    buffers::write_lighting_buffers.in_set(RenderSystems::PrepareResources),
                    bindings::prepare_lighting_bind_groups
                        .in_set(RenderSystems::PrepareBindGroups)
                        .after(prepare_mesh_view_bind_groups),
                ),
            )
            .add_systems(
                Core3d,
                pass::lighting_pass
                    .in_set(LightingPasses)
                    .in_set(Core3dSystems::MainPass)
                    .before(main_opaque_pass_3d),
            );
    }
}
