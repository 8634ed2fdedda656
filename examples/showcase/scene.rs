//! The street or a model, and the camera.

use bevy::{
    anti_alias::smaa::Smaa, camera::Hdr, post_process::bloom::Bloom, prelude::*,
    ui::IsDefaultUiCamera,
};
use bevy_panorbit_camera::PanOrbitCamera;
use kit::{
    example::{
        made_up_sky::made_up_sky,
        model::{self, ModelPath},
        run::SceneReady,
    },
    scenes::boxes,
};
use street::{Detail, StreetPlugin, sky};

use crate::{companions::CompanionsPlugin, settings::Settings};

/// Spawns the scene and its camera.
pub struct ScenePlugin {
    pub model: ModelPath,
    /// glTF file of a figure that walks among the people.
    pub figure: Option<String>,
    pub detail: Detail,
}

impl Plugin for ScenePlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(self.model.clone())
            .add_systems(PreStartup, spawn_camera);
        if self.model.0.is_none() {
            app.add_plugins(StreetPlugin {
                detail: self.detail,
            })
            .add_systems(Startup, (prepare_camera, reserve_clusters))
            .add_systems(
                Update,
                stand.run_if(resource_exists_and_changed::<Settings>),
            );
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

fn spawn_camera(mut commands: Commands) {
    commands.spawn((
        Camera3d::default(),
        Hdr,
        Msaa::Off,
        Smaa::default(),
        Bloom::NATURAL,
        IsDefaultUiCamera,
        PanOrbitCamera {
            button_orbit: MouseButton::Left,
            button_pan: MouseButton::Right,
            ..default()
        },
        Transform::default(),
    ));
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

/// Moves the camera when the viewpoint changes.
fn stand(
    settings: Res<Settings>,
    camera: Single<(&mut Transform, &mut PanOrbitCamera), With<Camera3d>>,
    mut stands_at: Local<Option<street::Viewpoint>>,
) {
    if stands_at.replace(settings.viewpoint) == Some(settings.viewpoint) {
        return;
    }
    let street::Viewpoint { eye, target } = settings.viewpoint;
    let from = (eye - target).normalize_or(Vec3::Z);
    let viewpoint = model::Viewpoint {
        yaw: from.x.atan2(from.z),
        pitch: from.y.asin(),
        zoom: 1.0,
    };
    let (mut transform, mut orbit) = camera.into_inner();
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
