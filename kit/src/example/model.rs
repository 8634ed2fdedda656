//! Loading a glTF file, and standing the camera before it.
//!

use bevy::{
    asset::RecursiveDependencyLoadState,
    camera::primitives::Aabb,
    gltf::GltfAssetLabel,
    prelude::*,
    world_serialization::{WorldAsset, WorldAssetRoot},
};
use bevy_panorbit_camera::PanOrbitCamera;

use super::run::SceneReady;

/// The file to show, none for the built-in scene.
#[derive(Resource, Clone)]
pub struct ModelPath(pub Option<String>);

/// Where the camera first stands.
#[derive(Resource, Clone, Copy)]
pub struct Viewpoint {
    /// Around the model, in radians.
    pub yaw: f32,
    /// Above the model, in radians.
    pub pitch: f32,
    /// How many times nearer than it would stand.
    pub zoom: f32,
}

/// What is being loaded, and is to be framed after that; none for meshes that are there already.
#[derive(Resource)]
pub struct LoadingModel(pub Option<Handle<WorldAsset>>);

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

/// Whether a built-in scene takes the place of a file.
pub fn is_builtin(path: Res<ModelPath>) -> bool {
    path.0.is_none()
}

pub fn spawn_model(mut commands: Commands, path: Res<ModelPath>, asset_server: Res<AssetServer>) {
    let Some(path) = &path.0 else {
        return;
    };
    // Assets are found relative to a folder of their own; the user means the working directory.
    let path = std::path::absolute(path).unwrap_or_else(|_| path.into());
    let scene = asset_server.load(GltfAssetLabel::Scene(0).from_asset(path));
    commands.spawn(WorldAssetRoot(scene.clone()));
    commands.insert_resource(LoadingModel(Some(scene)));
}

/// Once everything is loaded, frames it; quits with an error if it cannot be loaded.
pub fn watch_loading(
    mut commands: Commands,
    loading: Option<Res<LoadingModel>>,
    path: Res<ModelPath>,
    asset_server: Res<AssetServer>,
    bounds: Query<(&Aabb, &GlobalTransform), With<Mesh3d>>,
    mut camera: Single<(&mut Transform, &mut PanOrbitCamera)>,
    viewpoint: Res<Viewpoint>,
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
    stand(transform, orbit, center, *viewpoint, distance);
    commands.remove_resource::<LoadingModel>();
    commands.insert_resource(SceneReady);
}

/// Turns an orbiting camera to `focus`.
pub fn stand(
    transform: &mut Transform,
    orbit: &mut PanOrbitCamera,
    focus: Vec3,
    viewpoint: Viewpoint,
    distance: f32,
) {
    let distance = distance / viewpoint.zoom;
    let direction = Quat::from_rotation_y(viewpoint.yaw) * Quat::from_rotation_x(-viewpoint.pitch);
    *transform = Transform::from_translation(focus + direction * Vec3::Z * distance)
        .looking_at(focus, Vec3::Y);
    orbit.focus = focus;
    orbit.target_focus = focus;
    orbit.yaw = Some(viewpoint.yaw);
    orbit.pitch = Some(viewpoint.pitch);
    orbit.radius = Some(distance);
    orbit.target_yaw = viewpoint.yaw;
    orbit.target_pitch = viewpoint.pitch;
    orbit.target_radius = distance;
}
