//! Spawns the meshes of a built-in scene.

use bevy::prelude::*;

pub struct Builder<'w, 's> {
    pub commands: Commands<'w, 's>,
    pub meshes: ResMut<'w, Assets<Mesh>>,
}

impl Builder<'_, '_> {
    pub fn add(
        &mut self,
        mesh: impl Into<Mesh>,
        material: &Handle<StandardMaterial>,
        center: Vec3,
    ) -> EntityCommands<'_> {
        self.add_at(mesh, material, Transform::from_translation(center))
    }

    pub fn add_at(
        &mut self,
        mesh: impl Into<Mesh>,
        material: &Handle<StandardMaterial>,
        transform: Transform,
    ) -> EntityCommands<'_> {
        self.commands.spawn((
            Mesh3d(self.meshes.add(mesh)),
            MeshMaterial3d(material.clone()),
            transform,
        ))
    }

    /// Spawns a box between two corners.
    pub fn add_box(
        &mut self,
        material: &Handle<StandardMaterial>,
        low: Vec3,
        high: Vec3,
    ) -> EntityCommands<'_> {
        self.add(Cuboid::from_size(high - low), material, (low + high) / 2.0)
    }
}
