//! Reports the meshes of a lean camera that Bevy's forward pass draws.

use core::cmp::Reverse;

use bevy::{
    asset::UntypedAssetId,
    platform::collections::HashMap,
    prelude::*,
    render::{
        MainWorld,
        sync_world::{MainEntity, MainEntityHashMap, MainEntityHashSet},
    },
};

use super::forward_reason::ForwardReason;
use crate::view::LeanDeferred;

/// Largest length of [`LeanForwardMeshes::first`].
const MOST_MATERIALS: usize = 8;

/// On a camera with [`LeanDeferred`]: the visible meshes that Bevy's forward pass drew in the last frame, with the reasons. Meshes are
/// counted only for cameras with this component. Empty while the camera is not lean: Bevy draws all meshes then.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_lean_deferred::prelude::*;
/// fn spawn_camera(mut commands: Commands) {
///     commands.spawn((
///         Camera3d::default(),
///         LeanDeferred::default(),
///         LeanForwardMeshes::default(),
///     ));
/// }
///
/// fn print_reasons(
///     cameras: Query<&LeanForwardMeshes, Changed<LeanForwardMeshes>>,
///     assets: Res<AssetServer>,
/// ) {
///     for meshes in &cameras {
///         for (reason, count) in &meshes.counts {
///             info!("Forward draws {count} meshes: {reason}");
///         }
///         for (material, reason) in &meshes.first {
///             // Materials that no file contains have no path.
///             info!("{material} {:?}: {reason}", assets.get_path(*material));
///         }
///     }
/// }
/// ```
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct LeanForwardMeshes {
    /// Number of meshes for each reason, the largest first.
    pub counts: Vec<(ForwardReason, usize)>,
    /// Up to 8 materials of these meshes, with the reason: those of the most meshes first.
    pub first: Vec<(UntypedAssetId, ForwardReason)>,
    /// Number of these meshes that are lit by this crate's light functions in Bevy's passes: those of `StandardMaterial` that
    /// `docs/limits.md` does not exclude. Bevy's lights the others.
    pub lit: usize,
}

impl LeanForwardMeshes {
    fn of<'a>(
        meshes: impl Iterator<Item = &'a (UntypedAssetId, ForwardReason)>,
        lit: usize,
    ) -> Self {
        let mut by_reason = HashMap::<ForwardReason, usize>::default();
        let mut by_material = HashMap::<(UntypedAssetId, ForwardReason), usize>::default();
        for &(material, reason) in meshes {
            *by_reason.entry(reason).or_default() += 1;
            *by_material.entry((material, reason)).or_default() += 1;
        }
        let mut counts: Vec<_> = by_reason.into_iter().collect();
        counts.sort_unstable_by_key(|&(reason, count)| (Reverse(count), reason));
        let mut materials: Vec<_> = by_material.into_iter().collect();
        materials.sort_unstable_by_key(|&((material, reason), count)| {
            (Reverse(count), reason, material)
        });
        materials.truncate(MOST_MATERIALS);
        Self {
            counts,
            first: materials.into_iter().map(|(pair, _)| pair).collect(),
            lit,
        }
    }

    /// Number of meshes that forward drew.
    pub fn total(&self) -> usize {
        self.counts.iter().map(|(_, count)| count).sum()
    }
}

/// The visible meshes of one camera that forward draws, with their materials.
#[derive(Default)]
pub(super) struct CameraForwardMeshes {
    by_mesh: MainEntityHashMap<(UntypedAssetId, ForwardReason)>,
    /// Those of them that the crate's light functions light.
    lit: MainEntityHashSet,
    /// True if all visible meshes have been sorted since the camera became lean or got its [`LeanForwardMeshes`].
    is_complete: bool,
    /// `None` if a mesh has changed since the last report.
    report: Option<LeanForwardMeshes>,
}

impl CameraForwardMeshes {
    pub(super) fn is_complete(&self) -> bool {
        self.is_complete
    }

    /// Forgets all meshes. Call before all visible meshes are sorted.
    pub(super) fn start_over(&mut self) {
        *self = Self {
            is_complete: true,
            ..default()
        };
    }

    pub(super) fn insert(
        &mut self,
        mesh: MainEntity,
        material: UntypedAssetId,
        reason: ForwardReason,
    ) {
        self.by_mesh.insert(mesh, (material, reason));
        self.report = None;
    }

    pub(super) fn remove(&mut self, mesh: MainEntity) {
        if self.by_mesh.remove(&mesh).is_some() {
            self.lit.remove(&mesh);
            self.report = None;
        }
    }

    /// Notes if the crate's light functions light `mesh`.
    fn set_lit(&mut self, mesh: MainEntity, is_lit: bool) {
        let has_changed = if is_lit && self.by_mesh.contains_key(&mesh) {
            self.lit.insert(mesh)
        } else {
            self.lit.remove(&mesh)
        };
        if has_changed {
            self.report = None;
        }
    }

    fn report(&mut self) -> &LeanForwardMeshes {
        let meshes = self.by_mesh.values();
        self.report
            .get_or_insert_with(|| LeanForwardMeshes::of(meshes, self.lit.len()))
    }
}

/// In the render world: forward meshes of the cameras with [`LeanDeferred`] and [`LeanForwardMeshes`]. Empty if there are none.
#[derive(Resource, Default)]
pub(super) struct ForwardMeshes(MainEntityHashMap<CameraForwardMeshes>);

impl ForwardMeshes {
    /// Meshes of a lean camera; `None` if it has no [`LeanForwardMeshes`]. Forgets those of a camera that is not lean.
    pub(super) fn of(
        &mut self,
        camera: MainEntity,
        is_lean: bool,
    ) -> Option<&mut CameraForwardMeshes> {
        let meshes = self.0.get_mut(&camera)?;
        if !is_lean {
            *meshes = default();
            return None;
        }
        Some(meshes)
    }

    /// Notes if the crate's light functions light `mesh` on a lean camera.
    pub(super) fn set_lit(&mut self, camera: MainEntity, mesh: MainEntity, is_lit: bool) {
        if let Some(meshes) = self.0.get_mut(&camera) {
            meshes.set_lit(mesh, is_lit);
        }
    }

    /// Forgets the meshes of cameras that are not rendered.
    pub(super) fn keep_only(&mut self, is_rendered: impl Fn(MainEntity) -> bool) {
        for (camera, meshes) in &mut self.0 {
            if !is_rendered(*camera) {
                *meshes = default();
            }
        }
    }
}

/// Copies the meshes of the last frame to their cameras in the main world, and notes which cameras ask for those of the next.
pub(super) fn report_forward_meshes(
    mut main_world: ResMut<MainWorld>,
    mut forward_meshes: ResMut<ForwardMeshes>,
    cameras: Query<&MainEntity, With<LeanDeferred>>,
) {
    let tracked = &mut forward_meshes.0;
    tracked.retain(|camera, _| cameras.iter().any(|other| other == camera));
    for camera in &cameras {
        let Some(mut reported) = main_world.get_mut::<LeanForwardMeshes>(camera.id()) else {
            tracked.remove(camera);
            continue;
        };
        let report = tracked.entry(*camera).or_default().report();
        if *reported != *report {
            *reported = report.clone();
        }
    }
}

/// Without [`LeanDeferred`] nothing is reported.
pub(super) fn clear_report(removed: On<Remove, LeanDeferred>, mut commands: Commands) {
    commands
        .entity(removed.entity)
        .queue_silenced(|mut camera: EntityWorldMut| {
            if let Some(mut reported) = camera.get_mut::<LeanForwardMeshes>() {
                reported.set_if_neq(LeanForwardMeshes::default());
            }
        });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn materials_of_the_most_meshes_come_first() {
        let material = |index: u128| {
            let id = AssetId::<StandardMaterial>::Uuid {
                uuid: bevy::asset::uuid::Uuid::from_u128(index),
            };
            id.untyped()
        };
        let mut meshes = CameraForwardMeshes::default();
        let mut entities = (1..).map(|index| {
            let entity = Entity::from_raw_u32(index).expect("it is small");
            MainEntity::from(entity)
        });
        for index in 0..12 {
            let reason = match index {
                0 => ForwardReason::Blended,
                _ => ForwardReason::NoNormals,
            };
            for mesh in entities.by_ref().take(20 - index) {
                meshes.insert(mesh, material(index as u128), reason);
            }
        }
        let entity = |index| MainEntity::from(Entity::from_raw_u32(index).expect("it is small"));
        meshes.set_lit(entity(3), true);
        meshes.set_lit(entity(4), true);
        meshes.set_lit(entity(4), false);
        // No such mesh is left to forward.
        meshes.set_lit(entity(100_000), true);
        let report = meshes.report().clone();
        assert_eq!(report.lit, 1);
        let others: usize = (9..20).sum();
        assert_eq!(
            report.counts,
            [
                (ForwardReason::NoNormals, others),
                (ForwardReason::Blended, 20)
            ]
        );
        assert_eq!(report.total(), others + 20);
        assert_eq!(report.first.len(), MOST_MATERIALS);
        assert_eq!(report.first[0], (material(0), ForwardReason::Blended));
        assert_eq!(report.first[7], (material(7), ForwardReason::NoNormals));
    }
}
