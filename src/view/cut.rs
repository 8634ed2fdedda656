//! Camera cuts, after which history is invalid.

use bevy::{prelude::*, render::extract_component::ExtractComponent};

/// Insert on a camera at a cut, when it jumps to another place or scene: its next frame uses no history. Exposure
/// starts adapted, and effects that read the last frame do without. Removed at the end of the frame.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_lean_deferred::prelude::*;
/// fn jump(mut commands: Commands, mut camera: Single<(Entity, &mut Transform), With<Camera3d>>) {
///     let (entity, transform) = &mut *camera;
///     transform.translation = Vec3::new(50.0, 2.0, 0.0);
///     commands.entity(*entity).insert(CameraCut);
/// }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default)]
#[reflect(Component, Default, Clone)]
pub struct CameraCut;

/// Number of cuts, on a camera that had one or whose effects request it. Effects compare it with the last count that
/// they saw, so a skipped frame loses no cut.
#[doc(hidden)]
#[derive(Component, ExtractComponent, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CameraCuts(pub(crate) u32);

/// Counts the cuts of this frame.
pub(super) fn count_cuts(
    mut commands: Commands,
    mut cameras: Query<(Entity, Option<&mut CameraCuts>), With<CameraCut>>,
) {
    for (camera, cuts) in &mut cameras {
        let mut camera = commands.entity(camera);
        camera.remove::<CameraCut>();
        match cuts {
            Some(mut cuts) => cuts.0 = cuts.0.wrapping_add(1) & 0x7fff_ffff,
            None => {
                camera.insert(CameraCuts(1));
            }
        }
    }
}
