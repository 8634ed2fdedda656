//! Loading the model, and standing the camera before it.

use bevy::{
    asset::RecursiveDependencyLoadState,
    camera::primitives::Aabb,
    gltf::GltfAssetLabel,
    prelude::*,
    world_serialization::{WorldAsset, WorldAssetRoot},
};
use bevy_panorbit_camera::PanOrbitCamera;

/// The file to show, none for the built-in scene.
#[derive(Resource, Clone)]
pub struct ModelPath(pub Option<String>);

/// Where the camera first stands, in radians around and above the model.
#[derive(Resource, Clone, Copy)]
pub struct CameraAngles {
    pub yaw: f32,
    pub pitch: f32,
}

/// There once the model is spawned and the camera stands before it.
#[derive(Resource)]
pub struct ModelReady;

#[derive(Resource)]
pub struct LoadingModel(Option<Handle<WorldAsset>>);

/// Says what is wrong with the model's file before a window opens.
pub fn check_file(path: &str) -> Result<(), String> {
    let extension = std::path::Path::new(path)
        .extension()
        .map(|extension| extension.to_string_lossy().to_lowercase());
    if !matches!(extension.as_deref(), Some("gltf" | "glb")) {
        return Err(format!("{path}: not a .gltf or .glb file"));
    }
    check_readable(path)
}

pub fn check_readable(path: &str) -> Result<(), String> {
    std::fs::File::open(path)
        .map(|_| ())
        .map_err(|error| format!("{path}: {error}"))
}

pub fn spawn_model(
    mut commands: Commands,
    path: Res<ModelPath>,
    asset_server: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let Some(path) = &path.0 else {
        spawn_builtin(&mut commands, &mut meshes, &mut materials);
        commands.insert_resource(LoadingModel(None));
        return;
    };
    // Assets are found relative to a folder of their own; the user means the working directory.
    let path = std::path::absolute(path).unwrap_or_else(|_| path.into());
    let scene = asset_server.load(GltfAssetLabel::Scene(0).from_asset(path));
    commands.spawn(WorldAssetRoot(scene.clone()));
    commands.insert_resource(LoadingModel(Some(scene)));
}

/// A row of balls from rough dielectric to smooth metal on a floor.
fn spawn_builtin(
    commands: &mut Commands,
    meshes: &mut Assets<Mesh>,
    materials: &mut Assets<StandardMaterial>,
) {
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(9.0, 5.0))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgb(0.45, 0.43, 0.4),
            perceptual_roughness: 0.6,
            ..default()
        })),
    ));
    let ball = meshes.add(Sphere::new(0.5).mesh().uv(64, 32));
    for row in 0..2 {
        for column in 0..6 {
            commands.spawn((
                Mesh3d(ball.clone()),
                MeshMaterial3d(materials.add(StandardMaterial {
                    base_color: Color::hsl(column as f32 * 55.0, 0.65, 0.55),
                    metallic: row as f32,
                    perceptual_roughness: 0.1 + column as f32 * 0.17,
                    ..default()
                })),
                Transform::from_xyz((column as f32 - 2.5) * 1.3, 0.5, (row as f32 - 0.5) * 1.6),
            ));
        }
    }
}

/// Once everything is loaded, frames it; quits with an error if it cannot be loaded.
pub fn watch_loading(
    mut commands: Commands,
    loading: Option<Res<LoadingModel>>,
    path: Res<ModelPath>,
    asset_server: Res<AssetServer>,
    bounds: Query<(&Aabb, &GlobalTransform), With<Mesh3d>>,
    mut camera: Single<(&mut Transform, &mut PanOrbitCamera)>,
    angles: Res<CameraAngles>,
    mut exit: MessageWriter<AppExit>,
    mut frames_without_mesh: Local<u32>,
) {
    let Some(loading) = loading else {
        return;
    };
    let mut quit = |why: &str| {
        eprintln!("error: {}: {why}", path.0.as_deref().unwrap_or_default());
        exit.write(AppExit::error());
        commands.remove_resource::<LoadingModel>();
    };
    if let Some(scene) = &loading.0 {
        match asset_server.get_recursive_dependency_load_state(scene) {
            Some(RecursiveDependencyLoadState::Loaded) => {}
            // Also if only a texture is missing: Bevy does not draw materials that lack one.
            Some(RecursiveDependencyLoadState::Failed(error)) => {
                // A backtrace may follow the first line.
                quit(error.to_string().lines().next().unwrap_or_default());
                return;
            }
            _ => return,
        }
    }
    if bounds.is_empty() {
        *frames_without_mesh += 1;
        if *frames_without_mesh > 20 {
            quit("its first scene holds no mesh");
        }
        return;
    }

    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for (aabb, transform) in &bounds {
        let center = transform.transform_point(aabb.center.into());
        let radius = transform.radius_vec3a(aabb.half_extents);
        low = low.min(center - radius);
        high = high.max(center + radius);
    }
    let (center, radius) = ((low + high) / 2.0, (high - low).length() * 0.5);
    let distance = radius * 1.5;

    let (transform, orbit) = &mut *camera;
    let direction = Quat::from_rotation_y(angles.yaw) * Quat::from_rotation_x(-angles.pitch);
    **transform = Transform::from_translation(center + direction * Vec3::Z * distance)
        .looking_at(center, Vec3::Y);
    orbit.focus = center;
    orbit.target_focus = center;
    orbit.yaw = Some(angles.yaw);
    orbit.pitch = Some(angles.pitch);
    orbit.radius = Some(distance);
    orbit.target_yaw = angles.yaw;
    orbit.target_pitch = angles.pitch;
    orbit.target_radius = distance;
    commands.remove_resource::<LoadingModel>();
    commands.insert_resource(ModelReady);
}
