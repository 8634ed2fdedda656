//! The street or a model.

use bevy::prelude::*;
use bevy_panorbit_camera::PanOrbitCamera;
use kit::{
    example::{
        made_up_sky::made_up_sky,
        model::{self, ModelPath},
        panel::fixed_panel,
        run::SceneReady,
    },
    scenes::boxes,
};
use street::{Detail, StreetPlugin, sky};

use crate::{
    companions::CompanionsPlugin,
    settings::{Street, walk_or_stand},
};

/// Spawns the scene.
pub struct ScenePlugin {
    pub model: ModelPath,
    /// glTF file of a figure that walks among the people.
    pub figure: Option<String>,
    pub detail: Detail,
}

impl Plugin for ScenePlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(self.model.clone());
        if self.model.0.is_none() {
            app.add_plugins((
                StreetPlugin {
                    detail: self.detail,
                },
                fixed_panel::<Street>("street"),
            ))
            .add_systems(Startup, (prepare_camera, reserve_clusters))
            .add_systems(Update, (stand, walk_or_stand));
            match self.figure.clone() {
                Some(path) => _ = app.add_plugins(CompanionsPlugin { path }),
                None => _ = app.insert_resource(SceneReady),
            }
        } else {
            app.insert_resource(model::Viewpoint {
                yaw: 0.45,
                pitch: 0.25,
                zoom: 1.0,
            })
            .add_systems(Startup, (model::spawn_model, light_model))
            .add_systems(Update, model::watch_loading);
        }
    }
}

fn prepare_camera(
    mut commands: Commands,
    mut images: ResMut<Assets<Image>>,
    camera: Single<Entity, With<Camera3d>>,
) {
    let light = sky::light(&mut images);
    commands.entity(*camera).insert((sky::air(), light));
}

/// Reserves room for thousands of lights in Bevy's lists, from the first frame on.
fn reserve_clusters(mut settings: ResMut<bevy::light::cluster::GlobalClusterSettings>) {
    boxes::reserve_clusters(&mut settings);
}

/// Moves the camera when the panel or a picture has another viewpoint.
fn stand(
    camera: Single<(&Street, &mut Transform, &mut PanOrbitCamera), With<Camera3d>>,
    mut stands_at: Local<Option<street::Viewpoint>>,
) {
    let (settings, mut transform, mut orbit) = camera.into_inner();
    let wanted = settings.place.viewpoint();
    if stands_at.replace(wanted) == Some(wanted) {
        return;
    }
    let street::Viewpoint { eye, target } = wanted;
    let from = (eye - target).normalize_or(Vec3::Z);
    let viewpoint = model::Viewpoint {
        yaw: from.x.atan2(from.z),
        pitch: from.y.asin(),
        zoom: 1.0,
    };
    let distance = eye.distance(target);
    model::stand(&mut transform, &mut orbit, target, viewpoint, distance);
}

/// Spawns daylight: a sky and a sun.
fn light_model(
    mut commands: Commands,
    mut images: ResMut<Assets<Image>>,
    camera: Single<Entity, With<Camera3d>>,
) {
    commands
        .entity(*camera)
        .insert(GeneratedEnvironmentMapLight {
            environment_map: images.add(made_up_sky()),
            intensity: 1_500.0,
            ..default()
        });
    commands.spawn((
        DirectionalLight {
            illuminance: 8_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(1.0, 2.0, 1.5).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}
