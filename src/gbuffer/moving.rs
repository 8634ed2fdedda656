//! Tracks moving meshes, whose motion vectors do not follow from depth and the cameras alone.

use bevy::{
    camera::visibility::ViewVisibility,
    core_pipeline::prepass::{MotionVectorPrepass, NormalPrepass},
    pbr::PreviousGlobalTransform,
    prelude::*,
    render::{
        Extract,
        sync_world::{MainEntity, MainEntityHashMap},
    },
};

use super::{bevy::extracted::ExtractedMeshes, mesh_overrides::ChangedMeshes};
use crate::view::LeanDeferred;

/// Frames for which a mesh still writes motion after it stopped. Meshes that alternate, as with physics steps slower
/// than the display, are not requeued each time.
const LINGERING_FRAMES: u32 = 30;

/// In the render world: visible meshes that moved recently, with the frames for which they remain listed. Empty without
/// an active lean camera whose motion vectors come from the G-buffer.
#[derive(Resource, Default)]
pub(crate) struct MovingMeshes(MainEntityHashMap<u32>);

impl MovingMeshes {
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(crate) fn contains(&self, mesh: MainEntity) -> bool {
        self.0.contains_key(&mesh)
    }
}

/// Has meshes sorted again when they start to move and once they have stopped. Static meshes cost nothing where Bevy
/// lists the moved ones; elsewhere each costs a check of its change tick.
pub(super) fn extract_moving_meshes(
    mut moving: ResMut<MovingMeshes>,
    mut changed_meshes: ResMut<ChangedMeshes>,
    mut extracted: ExtractedMeshes,
    cameras: Extract<
        Query<
            &Camera,
            (
                With<LeanDeferred>,
                With<MotionVectorPrepass>,
                Without<NormalPrepass>,
            ),
        >,
    >,
    transforms: Extract<
        Query<(&GlobalTransform, &PreviousGlobalTransform, &ViewVisibility), With<Mesh3d>>,
    >,
    changed: Extract<Query<Entity, (With<Mesh3d>, Changed<GlobalTransform>)>>,
) {
    if !cameras.iter().any(|camera| camera.is_active) {
        for (mesh, _) in moving.0.drain() {
            changed_meshes.insert(mesh);
        }
        return;
    }
    moving.0.retain(|mesh, frames| {
        *frames -= 1;
        if *frames == 0 {
            changed_meshes.insert(*mesh);
        }
        *frames > 0
    });
    let mut look_at = |mesh: MainEntity| {
        let moves = transforms
            .get(mesh.id())
            .is_ok_and(|(transform, previous, visibility)| {
                visibility.get() && transform.affine() != previous.0
            });
        if moves && moving.0.insert(mesh, LINGERING_FRAMES).is_none() {
            changed_meshes.insert(mesh);
        }
    };
    match extracted.iter() {
        Some(meshes) => meshes.for_each(look_at),
        None => changed.iter().for_each(|mesh| look_at(mesh.into())),
    }
}
