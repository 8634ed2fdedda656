//! The boxes scene with materials that write the optional targets or are blended, and with light probes.

use bevy::{
    camera::visibility::RenderLayers, core_pipeline::prepass::MotionVectorPrepass,
    light::ClusteredDecal, pbr::Lightmap, prelude::*,
};
use kit::scenes::SceneBuilder;

/// The special property of some of the boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Special {
    Nothing,
    Emissive,
    Reflectance,
    Clearcoat,
    Anisotropy,
    DiffuseTransmission,
    Unlit,
    /// Has a lightmap.
    Lightmap,
    /// All materials above without lightmaps, by turns.
    Materials,
    /// Nothing moves, but the camera asks for motion vectors.
    Rest,
    /// All boxes move.
    Motion,
    /// All boxes are on two layers, of which the sun has one.
    Layers,
    /// No box is special, but a decal covers one of them.
    Decal,
    /// Blended, with half alpha.
    Glass,
    /// No box is special, but two reflection probes light them.
    Probes,
    /// As `Probes`, and an irradiance volume.
    Volume,
    /// All materials, motion and layers.
    Everything,
}

/// A box that moves.
#[derive(Component)]
pub struct Moving;

/// Moves the boxes to and fro by a hundredth of a millimetre: the picture stays the same.
pub fn move_boxes(mut boxes: Query<&mut Transform, With<Moving>>, mut back: Local<bool>) {
    *back = !*back;
    let shift = if *back { -0.00001 } else { 0.00001 };
    for mut transform in &mut boxes {
        transform.translation.x += shift;
    }
}

/// The scenes: name, special property, and the number of boxes per special one.
pub const SCENES: [(&str, Special, usize); 20] = [
    ("targets_none", Special::Nothing, 1),
    ("targets_emissive", Special::Emissive, 1),
    ("targets_emissive_few", Special::Emissive, 16),
    ("targets_reflectance", Special::Reflectance, 1),
    ("targets_clearcoat", Special::Clearcoat, 1),
    ("targets_anisotropy", Special::Anisotropy, 1),
    ("targets_backlight", Special::DiffuseTransmission, 1),
    ("targets_unlit", Special::Unlit, 1),
    ("targets_lightmap", Special::Lightmap, 1),
    ("targets_materials", Special::Materials, 1),
    ("targets_rest", Special::Rest, 1),
    ("targets_motion", Special::Motion, 1),
    ("targets_layers", Special::Layers, 1),
    ("targets_decal", Special::Decal, 1),
    ("targets_all", Special::Everything, 1),
    ("targets_all_few", Special::Everything, 16),
    ("glass", Special::Glass, 1),
    ("glass_few", Special::Glass, 16),
    ("probes", Special::Probes, 1),
    ("probes_volume", Special::Volume, 1),
];

impl Special {
    /// Tells if the camera asks for motion vectors.
    pub fn wants_motion(self) -> bool {
        matches!(self, Self::Rest | Self::Motion | Self::Everything)
    }

    fn has_layers(self) -> bool {
        matches!(self, Self::Layers | Self::Everything)
    }

    /// Adds to the camera the components that the property needs.
    pub fn prepare_camera(self, camera: &mut EntityWorldMut) {
        if self.wants_motion() {
            camera.insert(MotionVectorPrepass);
        }
        if self.has_layers() {
            camera.insert(RenderLayers::from_layers(&[0, 1]));
        }
    }

    fn apply(self, index: usize, material: &mut StandardMaterial) {
        match self {
            Self::Nothing
            | Self::Rest
            | Self::Motion
            | Self::Layers
            | Self::Decal
            | Self::Probes
            | Self::Volume => {}
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
            Self::DiffuseTransmission => {
                material.diffuse_transmission = 0.6;
                material.thickness = 0.2;
            }
            Self::Unlit => material.unlit = true,
            Self::Lightmap => material.lightmap_exposure = 1000.0,
            Self::Glass => {
                material.alpha_mode = AlphaMode::Blend;
                material.base_color.set_alpha(0.5);
            }
            Self::Materials | Self::Everything => {
                [
                    Self::Emissive,
                    Self::Reflectance,
                    Self::Clearcoat,
                    Self::Anisotropy,
                    Self::DiffuseTransmission,
                    Self::Unlit,
                ][index % 6]
                    .apply(index, material);
            }
        }
    }
}

/// Spawns the light probes of the property: two reflection probes of which each has a half of the boxes, and the band in the middle both.
pub fn spawn_probes(scene: &mut SceneBuilder, special: Special) {
    if !matches!(special, Special::Probes | Special::Volume) {
        return;
    }
    for x in [-10.0, 10.0] {
        let light = scene.environment_map(400.0);
        scene.spawn((
            LightProbe {
                falloff: Vec3::splat(0.2),
            },
            light,
            Transform::from_xyz(x, 0.0, 0.0).with_scale(Vec3::new(24.0, 20.0, 60.0)),
        ));
    }
    if special == Special::Volume {
        let light = scene.irradiance_volume(400.0);
        scene.spawn((
            LightProbe::default(),
            light,
            Transform::from_scale(Vec3::splat(60.0)),
        ));
    }
}

/// Makes one in `every` box special, once the scene is spawned. All meshes get tangents, so that they are the same in
/// all scenes.
pub fn make_special(world: &mut World, special: Special, every: usize) {
    for (_, mesh) in world.resource_mut::<Assets<Mesh>>().iter_mut() {
        mesh.generate_tangents()
            .expect("the meshes of the boxes have all that tangents need");
        if special == Special::Lightmap {
            let uvs = mesh.attribute(Mesh::ATTRIBUTE_UV_0).cloned();
            let uvs = uvs.expect("the meshes of the boxes have UVs");
            mesh.insert_attribute(Mesh::ATTRIBUTE_UV_1, uvs);
        }
    }
    let lightmap = (special == Special::Lightmap)
        .then(|| world.resource_mut::<Assets<Image>>().add(Image::default()));
    let mut boxes = world.query::<(Entity, &MeshMaterial3d<StandardMaterial>, &Transform)>();
    let boxes: Vec<_> = boxes
        .iter(world)
        .filter(|(_, _, transform)| transform.translation.y > 0.0)
        .map(|(entity, material, _)| (entity, material.id()))
        .collect();
    for (index, (entity, material)) in boxes.into_iter().step_by(every).enumerate() {
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        let material = materials.get_mut(material).expect("it was just made");
        special.apply(index, material.into_inner());
        let mut sample = world.entity_mut(entity);
        if special.has_layers() {
            sample.insert(RenderLayers::from_layers(&[0, 1]));
        }
        if matches!(special, Special::Motion | Special::Everything) {
            sample.insert(Moving);
        }
        if let Some(image) = &lightmap {
            sample.insert(Lightmap {
                image: image.clone(),
                ..default()
            });
        }
    }
    if special.has_layers() {
        // The sun lights all boxes all the same.
        let mut suns = world.query_filtered::<Entity, With<DirectionalLight>>();
        for sun in suns.iter(world).collect::<Vec<_>>() {
            world.entity_mut(sun).insert(RenderLayers::layer(0));
        }
    }
    if special == Special::Decal {
        let image = world.resource_mut::<Assets<Image>>().add(Image::default());
        world.spawn((
            ClusteredDecal {
                base_color_texture: Some(image),
                ..default()
            },
            Transform::from_xyz(0.0, 0.5, 0.0).looking_to(Vec3::NEG_Y, Vec3::Z),
        ));
    }
}
