//! Lean cameras that `bsn!` spawns.

use bevy::{camera::Hdr, prelude::*};
use bevy_lean_deferred::{
    effects::{LeanScreenSpaceGiAdvanced, auto_exposure::MeteringPattern},
    prelude::*,
};
use kit::{
    headless::Headless, lean::active_lean_views, log_watch, own_process::in_own_process,
    scenes::SceneBuilder,
};

fn camera() -> impl Scene {
    bsn! {
        Camera3d
        LeanScreenSpaceAmbientOcclusion { resolution: LeanResolution::Half }
        LeanScreenSpaceGi {
            radius: 6.0,
            advanced: LeanScreenSpaceGiAdvanced { falloff: 0.25 },
        }
        LeanScreenSpaceReflections
        LeanSubsurfaceScattering
        LeanAutoExposure { pattern: MeteringPattern::Spot { radius: 0.25 } }
        MeteredExposure
        LeanMemory
        LeanForwardMeshes
        template_value(Transform::from_xyz(0.0, 2.0, 6.0).looking_at(Vec3::Y, Vec3::Y))
    }
}

#[test]
fn a_camera_with_all_components() {
    in_own_process(|| {
        let mut headless = Headless::new(UVec2::new(96, 64));
        let mut scene = SceneBuilder {
            headless: &mut headless,
        };
        scene.solids();
        scene.sun(true);
        let target = headless.render_target();
        // The patch of a scene: the radius and the fields of `advanced` stay.
        let scene = bsn! {
            camera()
            LeanScreenSpaceGi { quality: LeanQuality::High }
        };
        let mut camera = (headless.world())
            .spawn_scene(scene)
            .expect("it depends on no asset");
        let camera = camera.insert(target).id();
        headless.settle();
        headless.frames(8);
        assert_eq!(active_lean_views(&mut headless), 1);

        let camera = headless.world().entity(camera);
        let gi = LeanScreenSpaceGi {
            radius: 6.0,
            quality: LeanQuality::High,
            advanced: LeanScreenSpaceGiAdvanced {
                falloff: 0.25,
                ..default()
            },
            ..default()
        };
        assert_eq!(camera.get::<LeanScreenSpaceGi>(), Some(&gi));
        let exposure = LeanAutoExposure {
            pattern: MeteringPattern::Spot { radius: 0.25 },
            ..default()
        };
        assert_eq!(camera.get::<LeanAutoExposure>(), Some(&exposure));
        // Components that the effects require or change.
        assert!(camera.contains::<LeanDeferred>() && camera.contains::<Hdr>());
        assert_eq!(camera.get::<Msaa>(), Some(&Msaa::Off));

        let status = camera.get::<LeanStatus>().expect("it has effects");
        assert_eq!(status.diffuse_gi, EffectStatus::On);
        assert_eq!(status.reflections, EffectStatus::On);
        assert_eq!(status.auto_exposure, EffectStatus::On);
        let memory = camera.get::<LeanMemory>().expect("it has one");
        assert!(memory.total() > 0);
        log_watch::assert_validation_layer_silent();
    });
}
