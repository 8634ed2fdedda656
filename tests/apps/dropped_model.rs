//! A file dropped onto a window replaces the model. A file that cannot be shown changes only the message.

use core::time::Duration;
use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use bevy::{prelude::*, window::FileDragAndDrop};
use bevy_panorbit_camera::PanOrbitCamera;
use kit::{
    example::{
        dropped_model::{DropMessage, DroppedModelPlugin},
        model::{self, ModelPath, Viewpoint},
    },
    headless::Headless,
};

use crate::viewer_errors::{folder, gltf, write};

/// The loading part of the viewer, without its window.
fn viewer(file: &Path) -> Headless {
    let path = file.to_string_lossy().into_owned();
    let mut headless = Headless::with(UVec2::splat(32), |app| {
        app.insert_resource(ModelPath(Some(path)))
            .insert_resource(Viewpoint {
                yaw: 0.0,
                pitch: 0.0,
                zoom: 1.0,
            })
            .add_plugins(DroppedModelPlugin)
            .add_systems(
                Startup,
                (model::spawn_model, |mut commands: Commands| {
                    commands.spawn((Camera3d::default(), PanOrbitCamera::default()));
                }),
            )
            .add_systems(Update, model::watch_loading);
    });
    headless.frames(1);
    wait_until(&mut headless, |world| focus(world).x > 0.0);
    headless
}

/// A triangle from `x` to `x + 1`.
fn triangle(x: f32) -> String {
    let moved = format!(r#"{{ "mesh": 0, "translation": [{x}, 0, 0] }}"#);
    gltf("[{}]").replacen(r#"{ "mesh": 0 }"#, &moved, 1)
}

/// Drops a file and waits until it is shown or reported as bad.
fn drop_file(headless: &mut Headless, path_buf: PathBuf) {
    let window = Entity::PLACEHOLDER;
    let dropped = FileDragAndDrop::DroppedFile { window, path_buf };
    headless.world().write_message(dropped);
    headless.frames(1);
    wait_until(headless, |world| {
        let message = &world.resource::<DropMessage>().0;
        !message
            .as_ref()
            .is_some_and(|text| text.ends_with("loading"))
    });
    headless.frames(4);
}

fn wait_until(headless: &mut Headless, condition: impl Fn(&mut World) -> bool) {
    let start = Instant::now();
    while !condition(headless.world()) {
        assert!(
            start.elapsed() < Duration::from_secs(60),
            "it takes too long"
        );
        headless.frames(1);
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn focus(world: &mut World) -> Vec3 {
    let mut cameras = world.query::<&PanOrbitCamera>();
    cameras.single(world).expect("there is one camera").focus
}

fn meshes(world: &mut World) -> usize {
    world.query::<&Mesh3d>().iter(world).count()
}

#[test]
fn dropped_files() {
    let folder = folder("dropped_files");
    write(&folder, "first.gltf", &triangle(0.0));
    write(&folder, "second.gltf", &triangle(10.0));
    write(&folder, "third.gltf", &triangle(20.0));
    write(&folder, "model.obj", "");
    write(&folder, "broken.glb", "glTF, but then something else");
    write(
        &folder,
        "empty.gltf",
        r#"{ "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0] }], "nodes": [{}] }"#,
    );
    let untextured = r#"[{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
    "textures": [{ "source": 0 }],
    "images": [{ "uri": "nowhere.png" }]"#;
    write(&folder, "untextured.gltf", &gltf(untextured));

    let mut headless = viewer(&folder.join("first.gltf"));
    assert_eq!(focus(headless.world()).x, 0.5);

    drop_file(&mut headless, folder.join("second.gltf"));
    let world = headless.world();
    assert_eq!(world.resource::<DropMessage>().0, None);
    assert_eq!((focus(world).x, meshes(world)), (10.5, 1));

    for (file, why) in [
        ("nowhere.glb", "os error 2"),
        ("model.obj", "not a .gltf or .glb file"),
        ("broken.glb", "invalid glTF file"),
        ("empty.gltf", "holds no mesh"),
        ("untextured.gltf", "nowhere.png"),
    ] {
        drop_file(&mut headless, folder.join(file));
        let world = headless.world();
        let message = world.resource::<DropMessage>().0.clone();
        let message = message.unwrap_or_default();
        assert!(
            message.contains(file) && message.contains(why),
            "{file}: {message}"
        );
        assert_eq!((focus(world).x, meshes(world)), (10.5, 1), "{file}");
        let path = world.resource::<ModelPath>().0.clone();
        assert!(
            path.is_some_and(|path| path.ends_with("second.gltf")),
            "{file}"
        );
        assert_eq!(headless.app.should_exit(), None, "{file}");
    }

    drop_file(&mut headless, folder.join("third.gltf"));
    let world = headless.world();
    assert_eq!(world.resource::<DropMessage>().0, None);
    assert_eq!((focus(world).x, meshes(world)), (20.5, 1));
}
