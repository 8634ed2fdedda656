//! Access that spawning needs.

use bevy::{ecs::system::SystemParam, mesh::skinning::SkinnedMeshInverseBindposes, prelude::*};
use bevy_lean_deferred::prelude::ExtendedStandardMaterial;

use crate::geometry::Geometry;

/// Spawns things.
#[derive(SystemParam)]
pub struct Stage<'w, 's> {
    pub commands: Commands<'w, 's>,
    pub meshes: ResMut<'w, Assets<Mesh>>,
    pub images: ResMut<'w, Assets<Image>>,
    pub standard: ResMut<'w, Assets<StandardMaterial>>,
    pub extended: ResMut<'w, Assets<ExtendedStandardMaterial>>,
    pub bind_poses: ResMut<'w, Assets<SkinnedMeshInverseBindposes>>,
}

impl Stage<'_, '_> {
    /// Spawns geometry where it was built.
    pub fn place<M: Material>(&mut self, geometry: Geometry, material: &Handle<M>) {
        if !geometry.is_empty() {
            let mesh = self.meshes.add(geometry.mesh());
            self.commands
                .spawn((Mesh3d(mesh), MeshMaterial3d(material.clone())));
        }
    }
}
