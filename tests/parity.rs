//! Pictures of lean cameras beside Bevy forward's.

mod common;

use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;
use common::{
    headless::Headless,
    metrics::difference,
    scenes::{self, Scene, SceneBuilder},
};

const SIZE: UVec2 = UVec2::new(320, 240);

/// Renders a scene forward, then lean in the same app, and compares.
fn compare(scene: &Scene) -> Result<String, String> {
    let mut headless = Headless::new(SIZE);
    (scene.build)(&mut SceneBuilder {
        headless: &mut headless,
    });
    headless.settle();
    let forward = headless.capture();

    let cameras: Vec<Entity> = headless
        .world()
        .query_filtered::<Entity, With<Camera3d>>()
        .iter(headless.app.world())
        .collect();
    for camera in cameras {
        headless
            .world()
            .entity_mut(camera)
            .insert(LeanDeferred::default());
    }
    headless.settle();
    let lean = headless.capture();

    if let Some(folder) = std::env::var_os("PARITY_PICTURES") {
        let folder = std::path::Path::new(&folder);
        forward.save(folder.join(format!("{}_forward.png", scene.name)));
        lean.save(folder.join(format!("{}_lean.png", scene.name)));
    }
    let difference = difference(&forward, &lean);
    let line = format!("{:28} {difference}", scene.name);
    println!("{line}");
    if difference.psnr < scene.least_psnr {
        return Err(format!("{line}, less than {} dB", scene.least_psnr));
    }
    Ok(line)
}

#[test]
fn lean_pictures_match_forward() {
    let only = std::env::var("PARITY_SCENE").ok();
    let failures: Vec<String> = scenes::all()
        .filter(|scene| only.as_ref().is_none_or(|only| scene.name.contains(only)))
        .filter_map(|scene| compare(scene).err())
        .collect();
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}
