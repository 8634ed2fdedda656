//! Motion of static surfaces, from depth.

use bevy::math::{Mat4, Vec2, Vec4};

use crate::reference::shader_library::layout::motion::motion_between;

/// Screen-space motion, in UV units, of a static point at `position`, which is homogeneous in view space: only the camera moves.
pub fn motion_at_rest(
    position: Vec4,
    world_from_view: Mat4,
    clip_from_world: Mat4,
    previous_clip_from_world: Mat4,
) -> Vec2 {
    let world_position = world_from_view * position;
    motion_between(
        clip_from_world * world_position,
        previous_clip_from_world * world_position,
    )
}
