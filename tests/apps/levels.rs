//! Levels as the bench `levels` loads them: lightmaps, lights, views, and the meshes that a lean camera leaves to forward.

use std::path::Path;

use bevy::{camera::Hdr, pbr::Lightmap, prelude::*};
use bevy_lean_deferred::{gbuffer::ForwardReason, prelude::*};
use kit::{
    headless::Headless,
    lean::{judge, report, set_lean, settled},
    levels::{Level, View, write_room},
};

use crate::viewer_errors::{folder, gltf, write};

fn open(folder: &Path) -> Level {
    let file = folder.join("scene.gltf");
    Level::open(&file.to_string_lossy()).expect("it was just written")
}

#[test]
fn a_lightmapped_level_is_loaded_and_looks_like_forward() {
    let folder = folder("a_lightmapped_level");
    write_room(&folder).expect("the room can be written");
    let level = open(&folder);
    assert_eq!(level.name, "room");
    let mut headless = Headless::new(UVec2::new(96, 64));
    let loaded = level.spawn(&mut headless).expect("the room loads");
    assert_eq!(
        (loaded.views.len(), loaded.lights, loaded.lightmapped),
        (2, 3, 1)
    );

    let world = headless.world();
    let mut lights = world.query::<&PointLight>();
    // The maps have the light of all lamps. Colours of lights are linear in glTF files.
    assert!(
        lights
            .iter(world)
            .all(|light| !light.affects_lightmapped_mesh_diffuse)
    );
    let warm = LinearRgba::rgb(1.0, 0.6, 0.3);
    assert!(lights.iter(world).any(|light| {
        let color = light.color.to_linear();
        color.to_vec3().abs_diff_eq(warm.to_vec3(), 1e-4)
    }));
    let mut meshes = world.query::<(&MeshMaterial3d<StandardMaterial>, Has<Lightmap>)>();
    let meshes: Vec<_> = meshes
        .iter(world)
        .map(|(material, has)| (material.id(), has))
        .collect();
    let materials = world.resource::<Assets<StandardMaterial>>();
    for (material, has_lightmap) in meshes {
        let exposure = materials.get(material).map(|m| m.lightmap_exposure);
        let expected = if has_lightmap { 2.0 } else { 1.0 };
        assert_eq!(exposure, Some(expected));
    }

    let target = headless.render_target();
    let camera = headless
        .world()
        .spawn((
            Camera3d::default(),
            Hdr,
            Msaa::Off,
            target,
            level.exposure(),
            loaded.views[0].transform(),
            LeanForwardMeshes::default(),
        ))
        .id();
    let forward = settled(&mut headless);
    set_lean(&mut headless, true);
    let lean = settled(&mut headless);
    let meshes = headless.world().get::<LeanForwardMeshes>(camera);
    let meshes = meshes.expect("it was spawned with the camera");
    assert_eq!(meshes.counts, [(ForwardReason::Blended, 1)]);
    let (material, _) = meshes.first[0];
    assert_eq!(
        loaded.material_names.get(&material).map(String::as_str),
        Some("pane")
    );
    report([judge("level", &forward, &lean, 45.0)]);
}

#[test]
fn a_gltf_file_alone_has_a_sun_and_a_view() {
    let folder = folder("a_gltf_file_alone");
    write(&folder, "scene.gltf", &gltf("[{}]"));
    let level = open(&folder);
    assert_eq!(level.name, "scene");
    let mut headless = Headless::new(UVec2::splat(32));
    let loaded = level.spawn(&mut headless).expect("the triangle loads");
    assert_eq!((loaded.views.len(), loaded.lightmapped), (1, 0));
    let View { position, target } = loaded.views[0];
    assert!(position[2] > target[2]);
    let world = headless.world();
    let mut suns = world.query::<&DirectionalLight>();
    assert_eq!(suns.iter(world).count(), 1);
}

#[test]
fn a_missing_lightmap_is_named() {
    let folder = folder("a_missing_lightmap");
    write_room(&folder).expect("the room can be written");
    std::fs::remove_file(folder.join("lightmaps/room.png")).expect("it was just written");
    let mut headless = Headless::new(UVec2::splat(32));
    let error = open(&folder).spawn(&mut headless);
    let error = error.expect_err("a file is missing");
    assert!(error.contains("lightmaps/room.png"), "{error}");
}
