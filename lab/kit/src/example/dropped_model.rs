//! Files dropped onto the window.

use bevy::{
    asset::RecursiveDependencyLoadState,
    camera::primitives::Aabb,
    prelude::*,
    window::FileDragAndDrop,
    world_serialization::{WorldAsset, WorldAssetRoot},
};
use bevy_panorbit_camera::PanOrbitCamera;

use super::model::{self, LoadingModel, ModelPath, ShownModel, Viewpoint};

/// Opens a glTF file dropped onto a window and shows it in place of every [`ShownModel`]. A file that cannot be shown leaves the old model
/// in place; [`DropMessage`] says why.
pub struct DroppedModelPlugin;

impl Plugin for DroppedModelPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<DropMessage>()
            .add_systems(Update, (read_drops, show_loaded, frame_shown).chain());
    }
}

/// Message about the last dropped file; none once it is shown.
#[derive(Resource, Default)]
pub struct DropMessage(pub Option<String>);

/// A dropped file that is loading, while the old model is still shown.
#[derive(Resource)]
struct Dropped {
    path: String,
    scene: Handle<WorldAsset>,
}

/// Frames since the new model was spawned, while its meshes have no bounds to frame yet.
#[derive(Resource, Default)]
struct Unframed(u32);

fn read_drops(
    mut commands: Commands,
    mut drops: MessageReader<FileDragAndDrop>,
    asset_server: Res<AssetServer>,
    mut message: ResMut<DropMessage>,
) {
    for drop in drops.read() {
        let FileDragAndDrop::DroppedFile { path_buf, .. } = drop else {
            continue;
        };
        let path = path_buf.to_string_lossy().into_owned();
        message.0 = Some(match model::check_file(&path) {
            Ok(()) => {
                let scene = model::load(&asset_server, &path);
                let text = format!("{path}: loading");
                commands.insert_resource(Dropped { path, scene });
                text
            }
            Err(why) => why,
        });
    }
}

fn show_loaded(
    mut commands: Commands,
    dropped: Option<Res<Dropped>>,
    asset_server: Res<AssetServer>,
    scenes: Res<Assets<WorldAsset>>,
    shown: Query<Entity, With<ShownModel>>,
    mut message: ResMut<DropMessage>,
) {
    let Some(dropped) = dropped else {
        return;
    };
    let scene = &dropped.scene;
    let fault = match asset_server.get_recursive_dependency_load_state(scene) {
        Some(RecursiveDependencyLoadState::Loaded) => {
            (!scenes.get(scene).is_some_and(holds_mesh)).then(|| model::NO_MESH.into())
        }
        Some(RecursiveDependencyLoadState::Failed(error)) => Some(model::first_line(&error)),
        _ => return,
    };
    commands.remove_resource::<Dropped>();
    if let Some(fault) = fault {
        message.0 = Some(format!("{}: {fault}", dropped.path));
        return;
    }
    message.0 = None;
    for model in &shown {
        commands.entity(model).despawn();
    }
    commands.spawn((ShownModel, WorldAssetRoot(scene.clone())));
    // The earlier model, which was still to be framed, is gone.
    commands.remove_resource::<LoadingModel>();
    commands.insert_resource(ModelPath(Some(dropped.path.clone())));
    commands.init_resource::<Unframed>();
}

/// True if the scene contains a mesh entity.
fn holds_mesh(scene: &WorldAsset) -> bool {
    let world = &scene.world;
    world.component_id::<Mesh3d>().is_some_and(|mesh| {
        let mut archetypes = world.archetypes().iter();
        archetypes.any(|archetype| archetype.contains(mesh) && !archetype.is_empty())
    })
}

/// Frames the shown model with the camera. Without bounds the camera stays.
fn frame_shown(
    mut commands: Commands,
    unframed: Option<ResMut<Unframed>>,
    bounds: Query<(&Aabb, &GlobalTransform), With<Mesh3d>>,
    mut camera: Single<(&mut Transform, &mut PanOrbitCamera)>,
    viewpoint: Res<Viewpoint>,
) {
    let Some(mut unframed) = unframed else {
        return;
    };
    let (transform, orbit) = &mut *camera;
    if model::frame(bounds.iter(), transform, orbit, *viewpoint) {
        commands.remove_resource::<Unframed>();
        commands.insert_resource(super::run::SceneReady);
        return;
    }
    unframed.0 += 1;
    if unframed.0 > model::FRAMES_UNTIL_BOUNDS {
        commands.remove_resource::<Unframed>();
    }
}
