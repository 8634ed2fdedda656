//! Extends the usages of depth textures.

use bevy::{
    core_pipeline::core_3d::prepare_core_3d_depth_textures,
    ecs::{schedule::ScheduleConfigs, system::ScheduleSystem},
    prelude::*,
    render::{RenderSystems, render_resource::TextureUsages},
};

/// The systems of [`extend_depth_usage`]. Each adds its usage, in any order.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
struct DepthUsageSystems;

/// System for `Render` that adds `usage` to the depth textures of views with `C`, so that depth can be read without a
/// copy.
pub(crate) fn extend_depth_usage<C: Component>(
    usage: TextureUsages,
) -> ScheduleConfigs<ScheduleSystem> {
    let extend = move |mut cameras: Query<&mut Camera3d, With<C>>| {
        for mut camera in &mut cameras {
            let usages = TextureUsages::from(camera.depth_texture_usages) | usage;
            camera.depth_texture_usages = usages.into();
        }
    };
    extend
        .in_set(RenderSystems::PrepareResources)
        .in_set(DepthUsageSystems)
        .ambiguous_with(DepthUsageSystems)
        // Creates the textures with these usages.
        .before(prepare_core_3d_depth_textures)
}
