//! What depth textures are made for.

use bevy::{
    core_pipeline::core_3d::prepare_core_3d_depth_textures,
    ecs::{schedule::ScheduleConfigs, system::ScheduleSystem},
    prelude::*,
    render::{RenderSystems, render_resource::TextureUsages},
};

/// The systems of [`extend_depth_usage`]: each adds what it needs, in any order.
#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
struct DepthUsageSystems;

/// For `Render`: views with `C` have depth textures that can be used for `usage` too, so that depth is read where it was drawn.
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
        // Makes them with the usages found here.
        .before(prepare_core_3d_depth_textures)
}
