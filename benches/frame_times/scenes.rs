//! The scenes of the bench.

use bevy::{
    camera::primitives::Aabb, ecs::system::RunSystemOnce, gltf::GltfAssetLabel,
    light::cluster::GlobalClusterSettings, prelude::*, world_serialization::WorldAssetRoot,
};

use crate::special::{self, Special};
use kit::{
    headless::Headless,
    scenes::boxes::{self, Boxes},
};

/// A named scene; `spawn` makes everything but the camera.
pub struct BenchScene {
    pub name: String,
    kind: Kind,
}

enum Kind {
    Boxes(Boxes),
    /// With what is special, and every how many boxes.
    SpecialBoxes(Boxes, Special, usize),
    Gltf {
        path: String,
    },
}

/// The built-in scenes, and one for each of the comma-separated glTF files.
pub fn all(gltf: &str) -> Vec<BenchScene> {
    let boxes = [
        ("boxes_64", Boxes::full(64)),
        ("boxes_512", Boxes::full(512)),
        ("small_boxes_32", Boxes::small(32)),
    ]
    .map(|(name, boxes)| BenchScene {
        name: name.into(),
        kind: Kind::Boxes(boxes),
    });
    let files = gltf.split(',').filter(|path| !path.is_empty());
    let models = files.map(|path| BenchScene {
        name: std::path::Path::new(path)
            .file_stem()
            .map_or("gltf".into(), |stem| stem.to_string_lossy().into_owned()),
        kind: Kind::Gltf { path: path.into() },
    });
    let special = special::SCENES.map(|(name, special, every)| BenchScene {
        name: name.into(),
        kind: Kind::SpecialBoxes(Boxes::full(64), special, every),
    });
    let small = BenchScene {
        name: "small_targets_all".into(),
        kind: Kind::SpecialBoxes(Boxes::small(32), Special::Everything, 1),
    };
    boxes
        .into_iter()
        .chain(special)
        .chain([small])
        .chain(models)
        .collect()
}

impl BenchScene {
    /// What is special about it.
    pub fn special(&self) -> Special {
        match self.kind {
            Kind::SpecialBoxes(_, special, _) => special,
            _ => Special::Nothing,
        }
    }

    /// Whether it shows what the optional targets cost, rather than how renderers compare.
    pub fn is_special(&self) -> bool {
        matches!(self.kind, Kind::SpecialBoxes(..))
    }

    /// Spawns the scene and returns where its camera stands.
    pub fn spawn(&self, headless: &mut Headless) -> Transform {
        match &self.kind {
            Kind::Boxes(boxes) => {
                spawn_boxes(headless.world(), *boxes);
                boxes::camera_transform(*boxes)
            }
            Kind::SpecialBoxes(boxes, special, every) => {
                spawn_boxes(headless.world(), *boxes);
                special::make_special(headless.world(), *special, *every);
                boxes::camera_transform(*boxes)
            }
            Kind::Gltf { path } => spawn_gltf(headless, path),
        }
    }
}

fn spawn_boxes(world: &mut World, boxes: Boxes) {
    boxes::reserve_clusters(&mut world.resource_mut::<GlobalClusterSettings>());
    world
        .run_system_once(
            move |mut commands: Commands,
                  mut meshes: ResMut<Assets<Mesh>>,
                  mut materials: ResMut<Assets<StandardMaterial>>| {
                boxes::spawn(&mut commands, &mut meshes, &mut materials, boxes);
            },
        )
        .expect("the boxes need only asset stores");
}

fn spawn_gltf(headless: &mut Headless, path: &str) -> Transform {
    let path = std::path::absolute(path).expect("a path has an absolute form");
    let scene = headless
        .world()
        .resource::<AssetServer>()
        .load(GltfAssetLabel::Scene(0).from_asset(path));
    headless.world().spawn(WorldAssetRoot(scene.clone()));
    headless.world().spawn((
        DirectionalLight {
            illuminance: 8_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(3.0, 8.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    for _ in 0..2000 {
        headless.frames(1);
        std::thread::sleep(std::time::Duration::from_millis(5));
        let world = headless.world();
        if world
            .resource::<AssetServer>()
            .is_loaded_with_dependencies(&scene)
        {
            break;
        }
    }
    headless.frames(5);
    let mut bounds: Option<(Vec3, Vec3)> = None;
    let world = headless.world();
    let mut query = world.query::<(&Aabb, &GlobalTransform)>();
    for (aabb, transform) in query.iter(world) {
        let center = transform.transform_point(aabb.center.into());
        let radius = transform.radius_vec3a(aabb.half_extents);
        let (low, high) = bounds.unwrap_or((center, center));
        bounds = Some((low.min(center - radius), high.max(center + radius)));
    }
    let (low, high) = bounds.expect("the glTF scene holds at least one mesh");
    let (center, size) = ((low + high) / 2.0, (high - low).length());
    Transform::from_translation(center + Vec3::new(0.35, 0.25, 1.0) * size * 0.55)
        .looking_at(center, Vec3::Y)
}
