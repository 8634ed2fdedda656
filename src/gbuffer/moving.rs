//! Which meshes move: their motion vectors do not follow from depth and the cameras alone.

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

use super::{extracted::ExtractedMeshes, special::ChangedMeshes};
use crate::view::LeanDeferred;

/// Frames that a mesh goes on writing its motion after it stopped: one that stops and goes, as by the steps of a
/// physics simulation slower than the display, is not queued anew each time.
const LINGERING_FRAMES: u32 = 30;

/// In the render world: the visible meshes that moved in this frame or a little while ago, with the frames that they are
/// still listed. Empty without a lean camera that asks for motion vectors.
#[derive(Resource, Default)]
pub(crate) struct MovingMeshes(MainEntityHashMap<u32>);

impl MovingMeshes {
    pub(crate) fn contains(&self, mesh: MainEntity) -> bool {
        self.0.contains_key(&mesh)
    }
}

/// Has meshes sorted anew in the frame in which they start to move and when they have stopped. Static meshes cost nothing, but where Bevy
/// does not list those that moved: there, the look at a change tick.
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
