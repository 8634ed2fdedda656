//! Loads a level into an app.

use std::{
    collections::HashMap,
    path::Path,
    time::{Duration, Instant},
};

use bevy::{
    asset::{RecursiveDependencyLoadState, UntypedAssetId},
    gltf::{GltfAssetLabel, GltfMaterialName},
    light::cluster::GlobalClusterSettings,
    prelude::*,
    world_serialization::WorldAssetRoot,
};

use super::{
    file::{Level, View},
    framing::framing_view,
    lightmaps::add_lightmaps,
    lights::set_up_lights,
};
use crate::{
    example::model::{FRAMES_UNTIL_BOUNDS, NO_MESH, first_line},
    headless::Headless,
    scenes::boxes::reserve_clusters,
};

/// Time limit of loading: images of large levels take a development build this long to decode.
const PATIENCE: Duration = Duration::from_secs(600);

/// Contents of a level in an app.
#[derive(Clone, Debug)]
pub struct LoadedLevel {
    /// Those of `level.json`, else the cameras of the glTF file, else one of the whole model.
    pub views: Vec<View>,
    /// Number of point and spot lights.
    pub lights: usize,
    /// Number of meshes with a lightmap.
    pub lightmapped: usize,
    /// Names of materials in the glTF file.
    pub material_names: HashMap<UntypedAssetId, String>,
}

impl Level {
    /// Spawns the level, without a camera, and waits until all of it is loaded.
    pub fn spawn(&self, headless: &mut Headless) -> Result<LoadedLevel, String> {
        reserve_clusters(&mut headless.world().resource_mut::<GlobalClusterSettings>());
        let scene = headless
            .world()
            .resource::<AssetServer>()
            .load(GltfAssetLabel::Scene(0).from_asset(self.path.clone()));
        headless.world().spawn(WorldAssetRoot(scene.clone()));
        wait_for(headless, &scene, &self.path)?;
        let framing = (0..FRAMES_UNTIL_BOUNDS).find_map(|_| {
            headless.frames(1);
            framing_view(headless.world())
        });
        let framing = framing.ok_or_else(|| format!("{}: {NO_MESH}", self.path.display()))?;
        let cameras = take_cameras(headless.world());
        let folder = self.path.with_file_name("lightmaps");
        let lightmapped = add_lightmaps(headless, &folder, self.file.lightmap_exposure)?;
        let lights = set_up_lights(headless.world(), self, lightmapped > 0);
        let views = [&self.file.views, &cameras]
            .into_iter()
            .find(|views| !views.is_empty());
        Ok(LoadedLevel {
            views: views.map_or_else(|| vec![View::of(&framing)], Clone::clone),
            lights,
            lightmapped,
            material_names: material_names(headless.world()),
        })
    }
}

fn material_names(world: &mut World) -> HashMap<UntypedAssetId, String> {
    let mut meshes = world.query::<(&MeshMaterial3d<StandardMaterial>, &GltfMaterialName)>();
    let names = meshes
        .iter(world)
        .map(|(material, name)| (material.id().untyped(), name.0.clone()));
    names.collect()
}

/// Despawns the cameras of the glTF file, and returns their views.
fn take_cameras(world: &mut World) -> Vec<View> {
    let mut cameras = world.query_filtered::<(Entity, &GlobalTransform), With<Camera>>();
    let cameras: Vec<_> = cameras
        .iter(world)
        .map(|(camera, place)| (camera, View::of(&place.compute_transform())))
        .collect();
    for (camera, _) in &cameras {
        // It may have been despawned with its parent.
        if let Ok(camera) = world.get_entity_mut(*camera) {
            camera.despawn();
        }
    }
    cameras.into_iter().map(|(_, view)| view).collect()
}

/// Runs frames until the asset and all that it depends on are loaded. `path` names it in errors.
pub(super) fn wait_for<A: Asset>(
    headless: &mut Headless,
    asset: &Handle<A>,
    path: &Path,
) -> Result<(), String> {
    let started = Instant::now();
    while started.elapsed() < PATIENCE {
        headless.frames(1);
        let assets = headless.world().resource::<AssetServer>();
        match assets.get_recursive_dependency_load_state(asset) {
            Some(RecursiveDependencyLoadState::Loaded) => return Ok(()),
            Some(RecursiveDependencyLoadState::Failed(error)) => {
                return Err(format!("{}: {}", path.display(), first_line(&error)));
            }
            _ => std::thread::sleep(Duration::from_millis(5)),
        }
    }
    let seconds = PATIENCE.as_secs();
    Err(format!("{}: not loaded after {seconds} s", path.display()))
}
