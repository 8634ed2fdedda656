//! The scenes of the bench.

use bevy::{
    gltf::GltfAssetLabel, light::cluster::GlobalClusterSettings, prelude::*,
    world_serialization::WorldAssetRoot,
};

use crate::special::{self, Special};
use kit::{
    headless::Headless,
    levels::framing_view,
    scenes::{
        SceneBuilder,
        boxes::{self, Boxes, LightField},
        build::default_camera_transform,
        forward_materials,
    },
};

/// A named scene.
pub struct BenchScene {
    pub name: String,
    kind: Kind,
}

enum Kind {
    Boxes(Boxes),
    /// Boxes, some of which are special: one in so many.
    SpecialBoxes(Boxes, Special, usize),
    /// Three blended cards among solids, under a sun and 64 lamps.
    Cards,
    Gltf {
        path: String,
    },
    /// Many copies of one model, and lights.
    Crowd {
        path: String,
        point_lights: u32,
    },
}

/// The built-in scenes, one for each of the comma-separated glTF files, and those with a crowd of a model.
pub fn all(gltf: &str, crowd: Option<&str>) -> Vec<BenchScene> {
    let boxes = [
        ("boxes_1", Boxes::full(0)),
        ("boxes_64", Boxes::full(64)),
        ("boxes_512", Boxes::full(512)),
        ("boxes_4096_short", short(4096)),
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
    let crowds = crowd.into_iter().flat_map(|path| {
        [64, 512].map(|point_lights| BenchScene {
            name: format!("crowd_{point_lights}"),
            kind: Kind::Crowd {
                path: path.into(),
                point_lights,
            },
        })
    });
    let small = BenchScene {
        name: "small_targets_all".into(),
        kind: Kind::SpecialBoxes(Boxes::small(32), Special::Everything, 1),
    };
    let cards = BenchScene {
        name: "glass_cards".into(),
        kind: Kind::Cards,
    };
    boxes
        .into_iter()
        .chain(special)
        .chain([small, cards])
        .chain(models)
        .chain(crowds)
        .collect()
}

impl BenchScene {
    /// The special property of some of the boxes.
    pub fn special(&self) -> Special {
        match self.kind {
            Kind::SpecialBoxes(_, special, _) => special,
            _ => Special::Nothing,
        }
    }

    /// Tells if the scene shows the cost of a kind of mesh or light, rather than comparing renderers.
    pub fn is_special(&self) -> bool {
        matches!(self.kind, Kind::SpecialBoxes(..) | Kind::Cards)
    }

    /// Spawns the scene and returns the camera's transform.
    pub fn spawn(&self, headless: &mut Headless) -> Transform {
        match &self.kind {
            Kind::Boxes(boxes) => {
                boxes::spawn_into(headless.world(), *boxes);
                boxes::camera_transform(*boxes)
            }
            Kind::SpecialBoxes(boxes, special, every) => {
                boxes::spawn_into(headless.world(), *boxes);
                special::make_special(headless.world(), *special, *every);
                special::spawn_probes(&mut SceneBuilder { headless }, *special);
                boxes::camera_transform(*boxes)
            }
            Kind::Cards => {
                let mut scene = SceneBuilder { headless };
                forward_materials::cards(&mut scene, AlphaMode::Blend);
                scene.sun(true);
                scene.lamps();
                default_camera_transform()
            }
            Kind::Gltf { path } => spawn_gltf(headless, path),
            Kind::Crowd { path, point_lights } => spawn_crowd(headless, path, *point_lights),
        }
    }
}

/// Spawns 12 × 12 copies of the model at 2.5 times its size, 1.6 m apart.
fn spawn_crowd(headless: &mut Headless, path: &str, point_lights: u32) -> Transform {
    let mut scene = SceneBuilder { headless };
    boxes::reserve_clusters(&mut scene.world().resource_mut::<GlobalClusterSettings>());
    scene.mesh(
        Plane3d::default().mesh().size(60.0, 60.0),
        StandardMaterial {
            base_color: Color::srgb(0.6, 0.6, 0.6),
            perceptual_roughness: 0.6,
            ..default()
        },
        Transform::default(),
    );
    let lights = LightField {
        count: point_lights,
        spread: Vec2::new(20.0, 8.0),
        ..default()
    };
    lights.spawn(&mut scene.world().commands());
    let places = (0..12).flat_map(|i| {
        (0..12).map(move |j| {
            let [x, z] = [i, j].map(|n| 1.6 * (n as f32 - 5.5));
            Transform::from_xyz(x, 0.0, z).with_scale(Vec3::splat(2.5))
        })
    });
    spawn_models(headless, path, places);
    Transform::from_xyz(3.0, 2.6, 7.0).looking_at(Vec3::new(0.0, 0.6, 0.0), Vec3::Y)
}

/// Boxes under this many lights of a quarter of the range.
fn short(point_lights: u32) -> Boxes {
    Boxes {
        range: 1.25,
        ..Boxes::full(point_lights)
    }
}

/// Spawns a glTF scene at each place and a sun, and waits until everything has loaded.
fn spawn_models(headless: &mut Headless, path: &str, places: impl IntoIterator<Item = Transform>) {
    let path = std::path::absolute(path).expect("a path has an absolute form");
    let scene = headless
        .world()
        .resource::<AssetServer>()
        .load(GltfAssetLabel::Scene(0).from_asset(path));
    for place in places {
        headless
            .world()
            .spawn((WorldAssetRoot(scene.clone()), place));
    }
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
}

fn spawn_gltf(headless: &mut Headless, path: &str) -> Transform {
    spawn_models(headless, path, [Transform::default()]);
    framing_view(headless.world()).expect("the glTF scene holds at least one mesh")
}
