//! The boxes scene with materials that write the optional targets.

use bevy::prelude::*;

/// What some of the boxes have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Special {
    Nothing,
    Emissive,
    Reflectance,
    Clearcoat,
    Anisotropy,
    Backlight,
    Unlit,
    /// One after the other.
    Everything,
}

/// The scenes: their names, what is special, and how many boxes there are for each that is.
pub const SCENES: [(&str, Special, usize); 10] = [
    ("targets_none", Special::Nothing, 1),
    ("targets_emissive", Special::Emissive, 1),
    ("targets_emissive_few", Special::Emissive, 16),
    ("targets_reflectance", Special::Reflectance, 1),
    ("targets_clearcoat", Special::Clearcoat, 1),
    ("targets_anisotropy", Special::Anisotropy, 1),
    ("targets_backlight", Special::Backlight, 1),
    ("targets_unlit", Special::Unlit, 1),
    ("targets_all", Special::Everything, 1),
    ("targets_all_few", Special::Everything, 16),
];

impl Special {
    fn apply(self, index: usize, material: &mut StandardMaterial) {
        match self {
            Self::Nothing => {}
            Self::Emissive => material.emissive = LinearRgba::rgb(0.1, 0.2, 0.4),
            Self::Reflectance => material.reflectance = 0.9,
            Self::Clearcoat => {
                material.clearcoat = 0.8;
                material.clearcoat_perceptual_roughness = 0.1;
            }
            Self::Anisotropy => {
                material.anisotropy_strength = 0.7;
                material.anisotropy_rotation = 0.4;
            }
            Self::Backlight => {
                material.diffuse_transmission = 0.6;
                material.thickness = 0.2;
            }
            Self::Unlit => material.unlit = true,
            Self::Everything => {
                [
                    Self::Emissive,
                    Self::Reflectance,
                    Self::Clearcoat,
                    Self::Anisotropy,
                    Self::Backlight,
                    Self::Unlit,
                ][index % 6]
                    .apply(index, material);
            }
        }
    }
}

/// Makes one in `every` box special, once the scene is spawned. All meshes get tangents, so that they are the same in all
/// scenes.
pub fn make_special(world: &mut World, special: Special, every: usize) {
    for (_, mesh) in world.resource_mut::<Assets<Mesh>>().iter_mut() {
        mesh.generate_tangents()
            .expect("the meshes of the boxes have all that tangents need");
    }
    let mut boxes = world.query::<(&MeshMaterial3d<StandardMaterial>, &Transform)>();
    let materials: Vec<_> = boxes
        .iter(world)
        .filter(|(_, transform)| transform.translation.y > 0.0)
        .map(|(material, _)| material.id())
        .collect();
    let mut assets = world.resource_mut::<Assets<StandardMaterial>>();
    for (index, id) in materials.into_iter().step_by(every).enumerate() {
        special.apply(
            index,
            assets.get_mut(id).expect("it was just made").into_inner(),
        );
    }
}
