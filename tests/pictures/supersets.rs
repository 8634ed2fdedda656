//! Pictures of cameras that general lighting pipelines light.

use bevy::{
    light::{AmbientLight, ShadowFilteringMethod},
    pbr::{ContactShadows, DistanceFog, FogFalloff, ScreenSpaceAmbientOcclusion},
    prelude::*,
};
use bevy_lean_deferred::{
    LeanDeferred, LeanResolution, LeanScreenSpaceAmbientOcclusion, LeanScreenSpaceGi,
    LeanScreenSpaceReflections, effects::ambient_occlusion::OcclusionFilter,
    lighting::CompiledLighting,
};
use kit::{
    headless::{Headless, Picture, small_shadow_maps},
    lean::{compile_lighting, is_lit_by_general, judge, report, set_lean, settled, show},
    own_process::in_own_process,
    scenes::{self, Scene, SceneBuilder, daily},
};

use super::parity::{SIZE, compare_all};

/// Least PSNR in dB between pictures by general pipelines and those that fit: shadows at their edges round differently.
const LEAST_PSNR: f64 = 55.0;

/// As [`LEAST_PSNR`], where pipelines differ in nothing but the filter of shadow maps: with another filter it is 56.6 dB.
const LEAST_PSNR_OF_FILTERS: f64 = 65.0;
/// As [`LEAST_PSNR`], with effects that follow their last frame.
const LEAST_PSNR_OF_EFFECTS: f64 = 45.0;

fn general_app(size: UVec2) -> Headless {
    Headless::with(size, |app| {
        small_shadow_maps(app);
        compile_lighting(app, CompiledLighting::General);
    })
}

/// Compares the scenes with Bevy's pictures, as `parity.rs` does.
fn match_forward(scenes: impl Iterator<Item = &'static Scene>) {
    let headless = Headless::with(SIZE, |app| compile_lighting(app, CompiledLighting::General));
    compare_all(headless, scenes);
}

#[test]
fn general_pipelines_light_as_forward_does() {
    in_own_process(|| match_forward(daily(scenes::LIGHTS)));
}

#[test]
#[ignore = "nightly: lights are compared daily"]
fn general_pipelines_light_materials_as_forward_does() {
    in_own_process(|| match_forward(daily(scenes::MATERIALS)));
}

#[test]
#[ignore = "nightly: lights are compared daily"]
fn general_pipelines_light_special_materials_as_forward_does() {
    in_own_process(|| match_forward(daily(scenes::SPECIAL_MATERIALS)));
}

#[test]
#[ignore = "nightly: lights are compared daily"]
fn general_pipelines_light_views_as_forward_does() {
    in_own_process(|| match_forward(daily(scenes::VIEWS)));
}

/// A change of the camera or of the scene. It may add a light.
type Change = fn(&mut World, Entity);

#[derive(Component)]
struct Added;

fn remove_added(world: &mut World, _: Entity) {
    let mut added = world.query_filtered::<Entity, With<Added>>();
    let added: Vec<Entity> = added.iter(world).collect();
    for light in added {
        world.despawn(light);
    }
}

/// Changes, each with its inverse.
const CHANGES: &[(&str, Change, Change)] = &[
    (
        "fog",
        |world, camera| {
            world.entity_mut(camera).insert(DistanceFog {
                falloff: FogFalloff::Exponential { density: 0.12 },
                ..default()
            });
        },
        |world, camera| {
            world.entity_mut(camera).remove::<DistanceFog>();
        },
    ),
    (
        "contact_shadows",
        |world, camera| {
            world.entity_mut(camera).insert(ContactShadows::default());
        },
        |world, camera| {
            world.entity_mut(camera).remove::<ContactShadows>();
        },
    ),
    (
        "ssao",
        |world, camera| {
            let ssao = ScreenSpaceAmbientOcclusion::default();
            world.entity_mut(camera).insert(ssao);
        },
        |world, camera| {
            let mut camera = world.entity_mut(camera);
            camera.remove::<ScreenSpaceAmbientOcclusion>();
        },
    ),
    (
        "occlusion",
        |world, camera| {
            let occlusion = LeanScreenSpaceAmbientOcclusion::default();
            world.entity_mut(camera).insert(occlusion);
        },
        |world, camera| {
            let mut camera = world.entity_mut(camera);
            camera.remove::<LeanScreenSpaceAmbientOcclusion>();
        },
    ),
    (
        "wide_occlusion",
        |world, camera| {
            let mut occlusion = LeanScreenSpaceAmbientOcclusion {
                resolution: LeanResolution::Full,
                ..default()
            };
            occlusion.advanced.filter = OcclusionFilter::Wide;
            occlusion.advanced.edge_aware = false;
            occlusion.direct_light = 0.5;
            world.entity_mut(camera).insert(occlusion);
        },
        |world, camera| {
            let mut camera = world.entity_mut(camera);
            camera.remove::<LeanScreenSpaceAmbientOcclusion>();
        },
    ),
    (
        "shadow_filter",
        |world, camera| {
            let filter = ShadowFilteringMethod::Hardware2x2;
            world.entity_mut(camera).insert(filter);
        },
        |world, camera| {
            let mut camera = world.entity_mut(camera);
            camera.remove::<ShadowFilteringMethod>();
        },
    ),
    (
        "gi",
        |world, camera| {
            let gi = LeanScreenSpaceGi::default();
            world.entity_mut(camera).insert(gi);
        },
        |world, camera| {
            world.entity_mut(camera).remove::<LeanScreenSpaceGi>();
        },
    ),
    (
        "spot_light",
        |world, _| {
            world.spawn((
                SpotLight {
                    intensity: 900_000.0,
                    shadow_maps_enabled: true,
                    ..default()
                },
                Transform::from_xyz(-2.0, 3.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
                Added,
            ));
        },
        remove_added,
    ),
];

/// A scene with a sun and ambient light, and its camera.
fn scene(s: &mut SceneBuilder) -> Entity {
    s.solids();
    let sun = s.sun(true);
    s.world()
        .get_mut::<DirectionalLight>(sun)
        .expect("it is one")
        .contact_shadows_enabled = true;
    s.default_camera((
        LeanDeferred::default(),
        AmbientLight {
            brightness: 500.0,
            ..default()
        },
    ))
}

/// Nothing of a part is left in the picture after it is gone, although the same pipelines go on.
#[test]
fn what_a_scene_lost_leaves_no_light() {
    in_own_process(|| {
        let mut headless = general_app(UVec2::new(160, 120));
        let camera = scene(&mut SceneBuilder {
            headless: &mut headless,
        });
        let without = settled(&mut headless);
        let results = CHANGES.iter().map(|(name, change, undo)| {
            change(headless.world(), camera);
            let with = settled(&mut headless);
            assert!(is_lit_by_general(&mut headless), "{name}");
            assert!(with.rgba != without.rgba, "{name} changes nothing");
            undo(headless.world(), camera);
            let again = settled(&mut headless);
            assert!(is_lit_by_general(&mut headless), "without {name}");
            judge(&format!("without_{name}"), &without, &again, LEAST_PSNR)
        });
        let results: Vec<_> = results.collect();
        report(results);
    });
}

/// Applies the change of that name, or its inverse.
fn apply(headless: &mut Headless, camera: Entity, name: &str, is_undone: bool) {
    let mut changes = CHANGES.iter();
    let (_, change, undo) = changes.find(|(other, ..)| *other == name).expect(name);
    let change = if is_undone { undo } else { change };
    change(headless.world(), camera);
}

/// Pipelines that fitted a scene light it without what it lost, as those do that fit then.
#[test]
fn pipelines_that_fitted_skip_what_a_scene_lost() {
    in_own_process(|| {
        let mut results = Vec::new();
        let effects = ["fog", "contact_shadows", "ssao", "gi", "spot_light"];
        for parts in [&effects[..], &["occlusion"]] {
            // Compiles lighting in the first frames only.
            let mut headless = Headless::with_compilation(UVec2::new(160, 120), true, |app| {
                small_shadow_maps(app);
                compile_lighting(app, CompiledLighting::All);
            });
            let camera = scene(&mut SceneBuilder {
                headless: &mut headless,
            });
            for name in parts {
                apply(&mut headless, camera, name, false);
            }
            headless.frames(40);
            for name in parts {
                apply(&mut headless, camera, name, true);
                let by_others = settled(&mut headless);
                assert!(!is_lit_by_general(&mut headless), "without {name}");
                compile_lighting(&mut headless.app, CompiledLighting::Fitting);
                let fitting = settled(&mut headless);
                compile_lighting(&mut headless.app, CompiledLighting::All);
                let least = if parts.contains(&"gi") && *name != "gi" && *name != "spot_light" {
                    LEAST_PSNR_OF_EFFECTS
                } else {
                    LEAST_PSNR
                };
                let name = format!("lost_{name}");
                results.push(judge(&name, &fitting, &by_others, least));
            }
        }
        report(results);
    });
}

/// A picture by pipelines that fit, and one by general ones.
fn by_both(headless: &mut Headless) -> [Picture; 2] {
    [CompiledLighting::Fitting, CompiledLighting::General].map(|compiled| {
        compile_lighting(&mut headless.app, compiled);
        let picture = settled(headless);
        let is_general = compiled == CompiledLighting::General;
        assert_eq!(is_lit_by_general(headless), is_general);
        picture
    })
}

/// The filter of shadow maps is a setting of the camera, which general pipelines read from a uniform.
#[test]
fn general_pipelines_filter_shadows_as_those_that_fit() {
    in_own_process(|| {
        let mut headless = general_app(UVec2::new(160, 120));
        let mut pictures = Vec::new();
        let mut results = Vec::new();
        for filter in [
            ShadowFilteringMethod::Hardware2x2,
            ShadowFilteringMethod::Gaussian,
            ShadowFilteringMethod::Temporal,
        ] {
            show(&mut headless, |s| {
                let camera = scene(s);
                s.spawn((
                    PointLight {
                        intensity: 400_000.0,
                        shadow_maps_enabled: true,
                        ..default()
                    },
                    Transform::from_xyz(-1.0, 2.5, 1.5),
                ));
                s.world().entity_mut(camera).insert(filter);
            });
            let [fitting, general] = by_both(&mut headless);
            let name = format!("shadows_{filter:?}");
            results.push(judge(&name, &fitting, &general, LEAST_PSNR_OF_FILTERS));
            assert!(
                !pictures.contains(&fitting.rgba),
                "{filter:?} is as another"
            );
            pictures.push(fitting.rgba);
        }
        report(results);
    });
}

/// Light of the crate's effects, which forward has not.
#[test]
fn general_pipelines_add_the_light_of_effects() {
    in_own_process(|| {
        let mut headless = general_app(UVec2::new(160, 120));
        let mut results = Vec::new();
        for resolution in LeanResolution::ALL {
            show(&mut headless, |s| {
                let camera = scene(s);
                s.world()
                    .entity_mut(camera)
                    .insert(LeanScreenSpaceAmbientOcclusion {
                        resolution,
                        direct_light: 0.5,
                        ..default()
                    });
            });
            let [fitting, general] = by_both(&mut headless);
            let name = format!("occlusion_{resolution:?}");
            results.push(judge(&name, &fitting, &general, LEAST_PSNR));
        }
        show(&mut headless, |s| {
            let camera = scene(s);
            s.world().entity_mut(camera).insert((
                LeanScreenSpaceGi::default(),
                LeanScreenSpaceReflections::default(),
            ));
        });
        let [fitting, general] = by_both(&mut headless);
        results.push(judge(
            "gi_and_reflections",
            &fitting,
            &general,
            LEAST_PSNR_OF_EFFECTS,
        ));
        report(results);
    });
}

/// Thickness and shadows decide where light enters a surface from behind: without shadows, that is along the shading normal.
#[test]
fn light_enters_from_behind_as_in_pipelines_that_fit() {
    in_own_process(|| {
        let mut headless = general_app(UVec2::new(160, 120));
        let mut results = Vec::new();
        for has_shadows in [false, true] {
            show(&mut headless, |s| {
                s.samples(StandardMaterial {
                    diffuse_transmission: 0.8,
                    thickness: 0.5,
                    ..default()
                });
                s.sun(has_shadows);
                s.spawn((
                    PointLight {
                        intensity: 400_000.0,
                        ..default()
                    },
                    Transform::from_xyz(0.0, 1.5, -2.5),
                ));
                s.default_camera(());
            });
            set_lean(&mut headless, true);
            let [fitting, general] = by_both(&mut headless);
            let name = format!("transmission_shadows_{has_shadows}");
            results.push(judge(&name, &fitting, &general, LEAST_PSNR));
        }
        report(results);
    });
}
