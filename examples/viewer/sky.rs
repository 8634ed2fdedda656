//! Sun and environment light.

use bevy::{
    light::{EnvironmentMapLight, GeneratedEnvironmentMapLight},
    prelude::*,
};

use kit::example::{
    made_up_sky::made_up_sky,
    model::check_readable,
    switch::{Environment, SwitchedLight},
};

/// Prefiltered maps; `None` for a procedural sky that Bevy filters.
#[derive(Resource, Clone)]
pub struct SkyFiles(Option<(String, String)>);

impl SkyFiles {
    /// Reports unreadable files before a window opens.
    pub fn new(diffuse: Option<String>, specular: Option<String>) -> Result<Self, String> {
        if diffuse.is_some() != specular.is_some() {
            return Err("--diffuse and --specular are of use only together".into());
        }
        let files = diffuse.zip(specular);
        if let Some((diffuse, specular)) = &files {
            check_readable(diffuse)?;
            check_readable(specular)?;
        }
        Ok(Self(files))
    }
}

pub fn spawn_sun(mut commands: Commands) {
    commands.spawn((
        SwitchedLight,
        DirectionalLight {
            illuminance: 5_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(2.0, 4.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

/// Lights the camera by the maps, or without.
pub fn light(
    mut commands: Commands,
    files: Res<SkyFiles>,
    camera: Single<(Entity, &Environment), Changed<Environment>>,
    asset_server: Res<AssetServer>,
    mut images: ResMut<Assets<Image>>,
) {
    let (camera, environment) = *camera;
    let mut camera = commands.entity(camera);
    camera.remove::<(EnvironmentMapLight, GeneratedEnvironmentMapLight)>();
    if !environment.is_on {
        return;
    }
    match &files.0 {
        Some((diffuse, specular)) => {
            let load = |path: &String| {
                asset_server.load(std::path::absolute(path).unwrap_or_else(|_| path.into()))
            };
            camera.insert(EnvironmentMapLight {
                diffuse_map: load(diffuse),
                specular_map: load(specular),
                intensity: 900.0,
                ..default()
            });
        }
        None => {
            camera.insert(GeneratedEnvironmentMapLight {
                environment_map: images.add(made_up_sky()),
                intensity: 900.0,
                ..default()
            });
        }
    }
}
