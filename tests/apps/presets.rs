//! Presets on a rendered camera: the device runs their effects, and what a preset lacks is removed.

use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;
use kit::{headless::Headless, log_watch, own_process::in_own_process, scenes::SceneBuilder};

/// Applies the preset of the system's input to all 3D cameras.
fn apply(
    In(preset): In<LeanPreset>,
    cameras: Query<Entity, With<Camera3d>>,
    mut commands: Commands,
) {
    for camera in &cameras {
        preset.apply(&mut commands.entity(camera));
    }
}

#[test]
fn each_preset_runs() {
    in_own_process(|| {
        let mut headless = Headless::new(UVec2::new(96, 64));
        let mut scene = SceneBuilder {
            headless: &mut headless,
        };
        scene.solids();
        scene.sun(true);
        let camera = scene.default_camera(LeanMemory::default());
        let mut memory = Vec::new();
        for preset in LeanPreset::ALL.into_iter().chain([LeanPreset::Low]) {
            let world = headless.world();
            world
                .run_system_cached_with(apply, preset)
                .expect("it runs");
            headless.settle();
            headless.frames(4);

            let world = headless.world();
            let status = world.get::<LeanStatus>(camera).expect("it has effects");
            let is_on = |has_effect| match has_effect {
                true => EffectStatus::On,
                false => EffectStatus::Absent,
            };
            let has_gi = preset >= LeanPreset::High;
            let expected = LeanStatus {
                deferred: EffectStatus::On,
                ambient_occlusion: is_on(!has_gi),
                diffuse_gi: is_on(has_gi),
                reflections: is_on(has_gi),
                // Nothing in view scatters light, or the device cannot.
                subsurface: status.subsurface.clone(),
                auto_exposure: EffectStatus::Absent,
            };
            assert_eq!(*status, expected, "{preset}");
            let scatters = status.subsurface != EffectStatus::Absent;
            assert_eq!(scatters, preset >= LeanPreset::Medium, "{preset}");
            memory.push(
                world
                    .get::<LeanMemory>(camera)
                    .expect("it is there")
                    .total(),
            );
        }
        // The same as before, so nothing is left of the presets in between.
        assert_eq!(memory.first(), memory.last(), "{memory:?}");
        assert!(memory[..4].is_sorted(), "{memory:?}");
        log_watch::assert_validation_layer_silent();
    });
}

/// The table of memory in `docs/presets.md`: MiB of a camera without surfaces that scatter light, or that need optional targets.
#[test]
#[ignore = "nightly: large pictures take minutes on a software renderer"]
fn memory_is_as_tabulated() {
    in_own_process(|| {
        let page = include_str!("../../docs/presets.md");
        let mut rows = LeanPreset::ALL.map(|preset| format!("| `{preset:?}` |"));
        for size in [(1280, 800), (1920, 1080), (3840, 2160)] {
            let mut headless = Headless::new(size.into());
            let mut scene = SceneBuilder {
                headless: &mut headless,
            };
            scene.solids();
            let camera = scene.default_camera(LeanMemory::default());
            for (preset, row) in LeanPreset::ALL.into_iter().zip(&mut rows) {
                let world = headless.world();
                world
                    .run_system_cached_with(apply, preset)
                    .expect("it runs");
                headless.settle();
                let memory = headless.world().get::<LeanMemory>(camera);
                let bytes = memory.expect("it is there").total();
                row.push_str(&format!(" {:.1} |", bytes as f64 / f64::from(1 << 20)));
            }
        }
        println!("{}", rows.join("\n"));
        for row in rows {
            assert!(page.contains(&row), "docs/presets.md lacks {row}");
        }
    });
}

/// A camera that is despawned in the same frame is no reason to panic.
#[test]
fn a_camera_that_is_gone() {
    let mut world = World::new();
    let camera = world.spawn_empty().id();
    let mut commands = world.commands();
    commands.entity(camera).despawn();
    LeanPreset::High.apply(&mut commands.entity(camera));
    world.flush();
    assert!(world.get_entity(camera).is_err());
}
