//! History of a view: light and depth of its last frame, before post-processing, for effects that read them in this frame.
//!
//! An effect inserts [`ReadsHistory`] on its views and reads [`ViewHistory`] there. The history is valid if its frame directly
//! precedes this one: not after a cut, a pause, or a change between perspective and orthographic. The viewport may change: textures
//! are mapped by that of their own frame.
//!
//! - `request.rs`: the component that asks for a history.
//! - `prepare.rs`: the textures and their validity.
//! - `uniforms.rs`: the uniform of a view.
//! - `pipelines.rs`: the table of the dispatches, their bindings and pipelines.
//! - `binding_numbers.rs`: binding numbers.
//! - `pass.rs`, `levels.wgsl`: the pass that fills the textures.
//! - `distance.rs`: the unit of stored distances.
//! - `opaque_depth.rs`: depth without transmissive meshes.

#[doc(hidden)]
pub mod binding_numbers;
mod distance;
mod opaque_depth;
mod pass;
mod pipelines;
mod prepare;
mod request;
mod uniforms;

use bevy::{
    asset::embedded_asset,
    core_pipeline::{
        core_3d::{main_transparent_pass_3d, prepare_core_3d_depth_textures},
        schedule::{Core3d, Core3dSystems},
    },
    prelude::*,
    render::{
        GpuResourceAppExt, Render, RenderApp, RenderStartup, RenderSystems,
        render_resource::TextureUsages,
    },
};

pub(super) use distance::units_per_metre;
pub use prepare::ViewHistory;
pub(super) use prepare::{prepare_histories, prepare_history_bind_groups};
pub use request::ReadsHistory;
pub use uniforms::HistoryUniform;

use super::{history_validity::HistoryValidityPlugin, shown_exposure::ShownExposurePlugin};
use crate::view::{
    EffectSystems, HistoryPasses, OpaquePicturePasses, SharedPlugin, ViewTextureSystems,
    depth_usage::extend_depth_usage, memory, removal,
};

/// Keeps the history of views with [`ReadsHistory`]. Added once, by the effects that need it.
pub(crate) struct HistoryPlugin;

impl HistoryPlugin {
    pub(crate) fn add_to(app: &mut App) {
        if !app.is_plugin_added::<Self>() {
            app.add_plugins(Self);
        }
    }
}

impl Plugin for HistoryPlugin {
    fn build(&self, app: &mut App) {
        SharedPlugin::add_to(app);
        HistoryValidityPlugin::add_to(app);
        app.add_plugins(ShownExposurePlugin::<ViewHistory>::default());
        embedded_asset!(app, "levels.wgsl");
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        removal::remove_with::<ReadsHistory, ViewHistory>(render_app);
        EffectSystems::History.run_while::<With<ReadsHistory>>(render_app);
        memory::count(render_app, |memory| &mut memory.history, ViewHistory::bytes);
        render_app
            .init_gpu_resource::<prepare::HistoryUniforms>()
            .init_gpu_resource::<opaque_depth::OpaqueDepths>()
            .add_systems(
                RenderStartup,
                (pipelines::init_history_pipelines, prepare::forget_histories),
            )
            .add_systems(
                Render,
                (
                    extend_depth_usage::<ReadsHistory>(
                        TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC,
                    ),
                    opaque_depth::prepare_opaque_depths
                        .in_set(RenderSystems::PrepareResources)
                        .after(prepare_core_3d_depth_textures),
                    prepare::prepare_histories.in_set(ViewTextureSystems),
                    prepare::prepare_history_bind_groups.in_set(RenderSystems::PrepareBindGroups),
                )
                    .in_set(EffectSystems::History),
            )
            .add_systems(
                Core3d,
                (
                    opaque_depth::copy_opaque_depth.in_set(OpaquePicturePasses),
                    // Volumetric fog runs after this set, so the history has none.
                    pass::keep_frame
                        .in_set(Core3dSystems::MainPass)
                        .in_set(HistoryPasses)
                        .after(main_transparent_pass_3d),
                )
                    .in_set(EffectSystems::History),
            );
    }
}
