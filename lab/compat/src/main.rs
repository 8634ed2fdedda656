//! Renders one scene on a forward and on a lean camera, with a part of it drawn by a crate of others, and compares the pictures.
//!
//! `sh lab/compat/run.sh` builds and runs it for each crate.

mod crates;

use std::path::{Path, PathBuf};

use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;
use figures::{
    benches::compat::{Compat, Measurement},
    json::{read_json, write_json},
};
use kit::{
    headless::{Headless, Picture, small_shadow_maps},
    lean::{active_lean_views, change_cameras, set_lean},
    log_watch::messages_with,
    metrics::pixel_difference,
    scenes::SceneBuilder,
};

const SIZE: UVec2 = UVec2::new(480, 270);
/// Frames until particles fly and chunks are meshed.
const WARM_UP: usize = 60;

/// Without arguments: prints the names of the crates. With a name and a file: renders, and adds the crate to the file.
fn main() {
    let crates = crates::all();
    let mut arguments = std::env::args().skip(1);
    let Some(name) = arguments.next() else {
        crates.iter().for_each(|tried| println!("{}", tried.name));
        return;
    };
    let file = PathBuf::from(arguments.next().expect("a crate and a file"));
    let tried = crates.iter().find(|tried| tried.name == name);
    let measurement = measure(tried.expect("the crate's feature is on"));

    let mut all: Compat = match file.exists() {
        true => read_json(&file).expect("the file has figures of crates"),
        false => Compat::default(),
    };
    println!("{}", Compat(vec![measurement.clone()]).table().markdown());
    measurement
        .messages
        .iter()
        .for_each(|text| println!("{text}"));
    all.set(measurement);
    write_json(&file.to_string_lossy(), &all);
}

fn measure(tried: &crates::Tried) -> Measurement {
    let bare = {
        let mut headless = Headless::new(SIZE);
        spawn_scene(&mut headless, |_| {});
        picture(&mut headless)
    };
    let mut headless = Headless::with(SIZE, |app| {
        small_shadow_maps(app);
        (tried.plugins)(app);
    });
    spawn_scene(&mut headless, tried.camera);
    (tried.spawn)(&mut SceneBuilder {
        headless: &mut headless,
    });
    headless.frames(WARM_UP);
    // Whatever moves stops, so that pictures can be compared.
    headless.world().resource_mut::<Time<Virtual>>().pause();

    let forward = picture(&mut headless);
    let before = messages_with("").len();
    set_lean(&mut headless, true);
    change_cameras(&mut headless, |camera| {
        camera.insert(LeanForwardMeshes::default());
    });
    let lean = picture(&mut headless);
    let was_lean = active_lean_views(&mut headless) == 1;
    let gone_forward = forward_meshes(&mut headless);
    // All effects, and back.
    change_cameras(&mut headless, |camera| LeanPreset::High.apply_to(camera));
    headless.settle();
    let effects = headless.capture();
    change_cameras(&mut headless, |camera| {
        camera.remove::<(
            LeanScreenSpaceAmbientOcclusion,
            LeanScreenSpaceGi,
            LeanScreenSpaceReflections,
            LeanSubsurfaceScattering,
            LeanForwardMeshes,
        )>();
    });
    set_lean(&mut headless, false);
    let back = picture(&mut headless);

    if let Some(folder) = std::env::var_os("PARITY_PICTURES") {
        let pictures = [
            ("bare", &bare),
            ("forward", &forward),
            ("lean", &lean),
            ("effects", &effects),
            ("back", &back),
        ];
        for (kind, picture) in pictures {
            picture.save(Path::new(&folder).join(format!("{}_{kind}.png", tried.name)));
        }
    }
    let drawn = |index: usize| bare.rgba[index..][..4] != forward.rgba[index..][..4];
    let psnr = |of: &dyn Fn(usize) -> bool| {
        let [forward, lean] = [&forward, &lean].map(|picture| pixels(picture, of));
        let psnr = pixel_difference(&forward, &lean).psnr;
        psnr.is_finite().then_some(psnr)
    };
    Measurement {
        device: headless.adapter_and_driver(),
        size: SIZE.into(),
        name: tried.name.into(),
        version: version(tried.package),
        shows: tried.shows.into(),
        drawn: changed(&bare, &forward),
        was_lean,
        psnr: psnr(&|_| true),
        psnr_drawn: psnr(&drawn),
        forward: gone_forward,
        changed_back: changed(&forward, &back),
        messages: messages_with("").split_off(before),
        to_do: tried.to_do.into(),
    }
}

/// Reasons and numbers of the camera's forward meshes.
fn forward_meshes(headless: &mut Headless) -> Vec<(String, usize)> {
    let world = headless.world();
    let mut cameras = world.query::<&LeanForwardMeshes>();
    let counts = cameras.iter(world).flat_map(|report| &report.counts);
    counts
        .map(|(reason, count)| (format!("{reason:?}"), *count))
        .collect()
}

/// The pixels of a picture that are wanted, by the index of their first byte, as one row.
fn pixels(picture: &Picture, is_wanted: impl Fn(usize) -> bool) -> Picture {
    let indices = (0..picture.rgba.len()).step_by(4);
    let wanted = indices.filter(|index| is_wanted(*index));
    let rgba: Vec<u8> = wanted
        .flat_map(|index| picture.rgba[index..][..4].to_vec())
        .collect();
    let size = UVec2::new(rgba.len() as u32 / 4, 1);
    Picture { size, rgba }
}

/// The version that was built.
fn version(package: &str) -> String {
    let lock = include_str!("../Cargo.lock");
    let (_, entry) = (lock.split_once(&format!("name = \"{package}\"\nversion = \"")))
        .expect("the crate is in the lock file");
    entry.split('"').next().unwrap_or_default().into()
}

/// A floor, five solids, a lamp and the sun. `prepare` changes the camera.
fn spawn_scene(headless: &mut Headless, prepare: fn(&mut EntityWorldMut)) {
    let mut scene = SceneBuilder { headless };
    let camera = scene.default_camera(bevy::camera::Exposure::INDOOR);
    prepare(&mut scene.world().entity_mut(camera));
    scene.solids();
    scene.sun(true);
    scene.spawn((
        PointLight {
            intensity: 200_000.0,
            ..default()
        },
        Transform::from_xyz(-2.0, 2.5, 2.0),
    ));
}

fn picture(headless: &mut Headless) -> Picture {
    headless.settle();
    headless.frames(4);
    headless.capture()
}

/// The share of pixels that differ.
fn changed(a: &Picture, b: &Picture) -> f64 {
    let pairs = a.rgba.chunks(4).zip(b.rgba.chunks(4));
    let differing = pairs.filter(|(a, b)| a != b).count();
    differing as f64 / (a.rgba.len() / 4) as f64
}
