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
