//! Loads a glTF file and frames it with the camera.

use bevy::{
    asset::{AssetLoadError, RecursiveDependencyLoadState},
    camera::primitives::Aabb,
    gltf::{GltfAssetLabel, GltfLoaderSettings},
    prelude::*,
    world_serialization::{WorldAsset, WorldAssetRoot},
};
use bevy_panorbit_camera::PanOrbitCamera;

use super::run::SceneReady;

/// The file to show; none for the built-in scene.
#[derive(Resource, Clone)]
pub struct ModelPath(pub Option<String>);

/// Initial position of the camera.
#[derive(Resource, Clone, Copy)]
pub struct Viewpoint {
    /// Angle around the model, in radians.
    pub yaw: f32,
    /// Angle above the model, in radians.
    pub pitch: f32,
    /// Factor by which the camera is nearer than the framing distance.
    pub zoom: f32,
}

impl Viewpoint {
    /// A viewpoint whose angles are in degrees.
    pub fn from_degrees(yaw: f32, pitch: f32, zoom: f32) -> Self {
        Self {
            yaw: yaw.to_radians(),
            pitch: pitch.to_radians(),
            zoom,
        }
    }
}

/// The scene that is loading and will then be framed; none for meshes that exist already.
#[derive(Resource)]
pub struct LoadingModel(pub Option<Handle<WorldAsset>>);

/// Marks the model or a part of the built-in scene, which is despawned when another file is shown.
#[derive(Component)]
pub struct ShownModel;

/// Error for a file without anything visible.
pub const NO_MESH: &str = "its first scene holds no mesh";

/// Frames after loading within which meshes get their bounds.
pub const FRAMES_UNTIL_BOUNDS: u32 = 20;

/// Checks the model's file before a window opens.
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

/// True if the built-in scene is shown.
pub fn is_builtin(path: Res<ModelPath>) -> bool {
    path.0.is_none()
}

pub fn spawn_model(mut commands: Commands, path: Res<ModelPath>, asset_server: Res<AssetServer>) {
    let Some(path) = &path.0 else {
        return;
    };
    let scene = load(&asset_server, path);
    commands.spawn((ShownModel, WorldAssetRoot(scene.clone())));
    commands.insert_resource(LoadingModel(Some(scene)));
}

/// Loads the first scene of a file, without its cameras.
pub fn load(asset_server: &AssetServer, path: &str) -> Handle<WorldAsset> {
    // Asset paths are relative to the asset folder; the user means the working directory.
    let path = std::path::absolute(path).unwrap_or_else(|_| path.into());
    asset_server
        .load_builder()
        .with_settings(|settings: &mut GltfLoaderSettings| settings.load_cameras = false)
        .load(GltfAssetLabel::Scene(0).from_asset(path))
}

/// First line of an error, without its backtrace.
pub fn first_line(error: &AssetLoadError) -> String {
    let text = error.to_string();
    text.lines().next().unwrap_or_default().into()
}

/// Frames the model once everything is loaded; quits with an error if loading fails.
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
            // Also if only a texture is missing: Bevy does not draw materials without their textures.
            Some(RecursiveDependencyLoadState::Failed(error)) => {
                quit(&first_line(&error));
                return;
            }
            _ => return,
        }
    }
    let (transform, orbit) = &mut *camera;
    if !frame(bounds.iter(), transform, orbit, *viewpoint) {
        *frames_without_mesh += 1;
        if *frames_without_mesh > FRAMES_UNTIL_BOUNDS {
            quit(NO_MESH);
        }
        return;
    }
    commands.remove_resource::<LoadingModel>();
    commands.insert_resource(SceneReady);
}

/// Frames all meshes with the camera. Returns false if there are none.
pub fn frame<'a>(
    bounds: impl Iterator<Item = (&'a Aabb, &'a GlobalTransform)>,
    transform: &mut Transform,
    orbit: &mut PanOrbitCamera,
    viewpoint: Viewpoint,
) -> bool {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for (aabb, place) in bounds {
        let center = place.transform_point(aabb.center.into());
        let radius = place.radius_vec3a(aabb.half_extents);
        low = low.min(center - radius);
        high = high.max(center + radius);
    }
    if low.x > high.x {
        return false;
    }
    let (center, radius) = ((low + high) / 2.0, (high - low).length() * 0.5);
    stand(transform, orbit, center, viewpoint, radius * 1.5);
    true
}

/// Points an orbiting camera at `focus`.
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
