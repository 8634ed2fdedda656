//! The last frame of a view, its light and its depth, as they were before post-processing: for effects that find in it what
//! this frame cannot know yet.
//!
//! An effect inserts [`ReadsHistory`] on its views, and finds [`ViewHistory`] there. It is valid while each frame follows the
//! one before: not after a cut, a pause, a change of size, or of the kind of projection.
//!
//! - `prepare.rs`: the textures, and whether they are valid. `uniforms.rs`, `pipelines.rs`, `pass.rs`, `levels.wgsl`: what fills
//!   them. `distance.rs`: the unit of the distances in them. `opaque_depth.rs`: depth without transmissive meshes.

#[doc(hidden)]
pub mod binding_numbers;
mod distance;
mod opaque_depth;
mod pass;
mod pipelines;
mod prepare;
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
pub use uniforms::HistoryView;

use super::{shown_exposure::ShownExposurePlugin, succession::SuccessionPlugin};
use crate::view::{
    EffectSystems, HistoryPasses, OpaquePicturePasses, SharedPlugin, ViewTextureSystems,
    depth_usage::extend_depth_usage, removal,
};

/// On a view of the render world: something reads its last frame. To be inserted before `RenderSystems::PrepareViews`,
/// and removed when nothing does any more.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct ReadsHistory;

/// Keeps the last frame of views that somebody reads. Added by those that do, once.
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
        SuccessionPlugin::add_to(app);
        app.add_plugins(ShownExposurePlugin::<ViewHistory>::default());
        embedded_asset!(app, "levels.wgsl");
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        removal::remove_with::<ReadsHistory, ViewHistory>(render_app);
        EffectSystems::History.run_while::<With<ReadsHistory>>(render_app);
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
                    // Volumetric fog and what else comes between here and post-processing has no order of its own.
                    pass::keep_frame
                        .in_set(Core3dSystems::MainPass)
                        .in_set(HistoryPasses)
                        .after(main_transparent_pass_3d),
                )
                    .in_set(EffectSystems::History),
            );
    }
}
