//! Pictures of lean cameras against Bevy forward's.

mod changes;
mod kinds;

use bevy::{
    camera::{ClearColorConfig, Viewport},
    material::OpaqueRendererMethod,
    prelude::*,
};
use bevy_lean_deferred::{LightCulling, prelude::*, view::LeanDeferredAdvanced};
use kit::{
    headless::{Headless, target_image},
    lean::{change_cameras, judge, report, set_lean, settled, show},
    own_process::in_own_process,
    scenes::{self, LEAST_PSNR, Scene, daily, nightly},
    skipped::{on_swiftshader, skips_without_binding_arrays},
};

pub const SIZE: UVec2 = UVec2::new(320, 240);

fn scene_named(name: &str) -> &'static Scene {
    let mut scenes = scenes::ALL.into_iter().flatten();
    scenes
        .find(|scene| scene.name == name)
        .expect("a scene of that name")
}

/// Renders a scene forward, then lean in the same app, and compares.
fn compare(headless: &mut Headless, scene: &Scene) -> Result<(), String> {
    show(headless, scene.build);
    let forward = settled(headless);
    set_lean(headless, true);
    let lean = settled(headless);
    let size = headless.size;
    if scene.needs_binding_arrays {
        skips_without_binding_arrays(headless.device(), scene.name);
    }
    let name = if size == SIZE {
        scene.name.into()
    } else {
        format!("{}_{}x{}", scene.name, size.x, size.y)
    };
    let least_psnr = match scene.name {
        // Bevy's own deferred path reaches 16.1 dB there.
        "one_metre_to_one_kilometre" => {
            on_swiftshader(16.0, scene.least_psnr, "depth across large triangles")
        }
        "taa" => on_swiftshader(44.5, scene.least_psnr, "TAA"),
        _ => scene.least_psnr,
    };
    judge(&name, &forward, &lean, least_psnr)
}

/// An app with Bevy's default sizes of shadow maps. Scenes that are not about the edges of shadows have small ones, which halve the time.
fn app() -> Headless {
    Headless::with(SIZE, |_| {})
}

/// Compares all of `scenes`, or those whose name contains one of the comma-separated words of `PARITY_SCENE`.
pub fn compare_all(mut headless: Headless, scenes: impl Iterator<Item = &'static Scene>) {
    let only = std::env::var("PARITY_SCENE").unwrap_or_default();
    report(
        scenes
            .filter(|scene| only.split(',').any(|word| scene.name.contains(word)))
            .map(|scene| compare(&mut headless, scene)),
    );
}

#[test]
fn lights_match_forward() {
    in_own_process(|| {
        compare_all(app(), daily(scenes::LIGHTS));
    });
}

#[test]
fn materials_match_forward() {
    in_own_process(|| {
        compare_all(app(), daily(scenes::MATERIALS));
    });
}

#[test]
fn forward_materials_match_forward() {
    in_own_process(|| {
        compare_all(Headless::new(SIZE), daily(scenes::FORWARD_MATERIALS));
    });
}

#[test]
fn special_materials_match_forward() {
    in_own_process(|| {
        compare_all(Headless::new(SIZE), daily(scenes::SPECIAL_MATERIALS));
    });
}

#[test]
fn meshes_match_forward() {
    in_own_process(|| {
        compare_all(app(), daily(scenes::MESHES));
    });
}

#[test]
fn views_match_forward() {
    in_own_process(|| {
        compare_all(Headless::new(SIZE), daily(scenes::VIEWS));
    });
}

#[test]
#[ignore = "nightly: combinations of what other scenes show"]
fn lights_and_materials_of_further_scenes_match_forward() {
    in_own_process(|| {
        let all = [scenes::LIGHTS, scenes::MATERIALS, scenes::FORWARD_MATERIALS];
        compare_all(app(), all.into_iter().flat_map(nightly));
    });
}

#[test]
#[ignore = "nightly: combinations of what other scenes show"]
fn special_materials_of_further_scenes_match_forward() {
    in_own_process(|| compare_all(Headless::new(SIZE), nightly(scenes::SPECIAL_MATERIALS)));
}

#[test]
#[ignore = "nightly: combinations of what other scenes show"]
fn meshes_and_views_of_further_scenes_match_forward() {
    in_own_process(|| {
        let all = [scenes::MESHES, scenes::VIEWS];
        compare_all(app(), all.into_iter().flat_map(nightly));
    });
}

#[test]
fn odd_sizes_match_forward() {
    in_own_process(|| {
        let scene = scene_named("many_lights_of_all_kinds");
        let sizes = [UVec2::new(1, 1), UVec2::new(3, 5), UVec2::new(317, 211)];
        let headless = &mut app();
        report(sizes.map(|size| {
            let mut images = headless.world().resource_mut::<Assets<Image>>();
            headless.target = images.add(target_image(size));
            headless.size = size;
            compare(headless, scene)
        }));
    });
}

/// Bevy's forward does not draw materials with an explicit `Deferred` on a camera without `DeferredPrepass`. A lean camera draws them like
/// those that leave the choice to it.
#[test]
fn explicitly_deferred_materials_look_as_others_do_forward() {
    in_own_process(|| {
        let glow = LinearRgba::rgb(0.1, 0.4, 0.1);
        let headless = &mut Headless::new(SIZE);
        report(
            [("deferred", LinearRgba::BLACK), ("deferred_emissive", glow)].map(
                |(name, emissive)| {
                    show(headless, |s| {
                        s.among_lean(StandardMaterial {
                            base_color: Color::srgb(0.8, 0.2, 0.15),
                            emissive,
                            ..default()
                        });
                        s.sun(true);
                        s.default_camera(());
                    });
                    let forward = settled(headless);
                    let mut materials = headless.world().resource_mut::<Assets<StandardMaterial>>();
                    for (_, material) in materials.iter_mut() {
                        material.opaque_render_method = OpaqueRendererMethod::Deferred;
                    }
                    set_lean(headless, true);
                    let lean = settled(headless);
                    judge(name, &forward, &lean, LEAST_PSNR)
                },
            ),
        );
    });
}

#[test]
fn a_lean_camera_leaves_others_of_its_target_alone() {
    in_own_process(|| {
        let rects = [
            URect::new(0, 0, 151, SIZE.y),
            URect::new(151, 0, SIZE.x, SIZE.y),
        ];
        let headless = &mut Headless::new(SIZE);
        for lean in 0..2 {
            let mut cameras = Vec::new();
            show(headless, |s| {
                s.solids();
                s.sun(true);
                for (order, rect) in rects.iter().enumerate() {
                    cameras.push(s.default_camera(Camera {
                        order: order as isize,
                        clear_color: ClearColorConfig::Custom(Color::srgb(0.2, 0.3, order as f32)),
                        viewport: Some(Viewport {
                            physical_position: rect.min,
                            physical_size: rect.size(),
                            ..default()
                        }),
                        ..default()
                    }));
                }
            });
            let before = settled(headless);
            headless
                .world()
                .entity_mut(cameras[lean])
                .insert(LeanDeferred::default());
            let after = settled(headless);
            let changed = |rect: URect| before.crop(rect) != after.crop(rect);
            assert!(changed(rects[lean]), "camera {lean} is not lean at all");
            assert!(
                !changed(rects[1 - lean]),
                "lean camera {lean} changed the other one's picture"
            );
        }
    });
}

/// A camera draws over an earlier one's picture, and one of the two is lean.
#[test]
fn a_lean_and_a_forward_camera_share_a_picture() {
    in_own_process(|| {
        let headless = &mut Headless::new(SIZE);
        report((0..2).map(|lean| {
            let mut cameras = Vec::new();
            show(headless, |s| {
                s.solids();
                s.sun(true);
                cameras.push(s.default_camera(()));
                cameras.push(s.camera(
                    Transform::from_xyz(3.0, 1.5, 3.0).looking_at(Vec3::Y * 0.5, Vec3::Y),
                    Camera {
                        order: 1,
                        clear_color: ClearColorConfig::None,
                        ..default()
                    },
                ));
            });
            let forward = settled(headless);
            headless
                .world()
                .entity_mut(cameras[lean])
                .insert(LeanDeferred::default());
            let mixed = settled(headless);
            judge(
                &format!("over_another_lean_{lean}"),
                &forward,
                &mixed,
                LEAST_PSNR,
            )
        }));
    });
}

#[test]
fn removing_the_component_gives_back_forward() {
    in_own_process(|| {
        let mut headless = Headless::new(SIZE);
        for name in [
            "many_lights_of_all_kinds",
            "emissive",
            "alpha_mask",
            "bevy_ssao",
            "all_prepasses",
            "occlusion_culling",
            "split_screen",
        ] {
            show(&mut headless, scene_named(name).build);
            let before = settled(&mut headless);
            set_lean(&mut headless, true);
            let lean = settled(&mut headless);
            set_lean(&mut headless, false);
            let after = settled(&mut headless);
            assert!(lean.rgba != before.rgba, "{name} was never lean");
            assert!(after.rgba == before.rgba, "{name} is not as before");
        }
    });
}

/// Cameras that are children of a scaled entity: shadows are biased by unit normals, and tiles lose no light.
#[test]
fn scaled_cameras_match_forward() {
    in_own_process(|| {
        let headless = &mut Headless::new(SIZE);
        report([0.2, 3.0].map(|scale| {
            show(headless, |s| {
                s.solids();
                s.sun(true);
                for i in 0..24 {
                    let angle = i as f32 * 0.7;
                    s.spawn((
                        PointLight {
                            intensity: 30_000.0,
                            range: 2.0,
                            ..default()
                        },
                        Transform::from_xyz(3.0 * angle.cos(), 0.8, 2.0 * angle.sin()),
                    ));
                }
                let from = Transform::from_xyz(3.0, 2.5, 5.0).looking_at(Vec3::Y * 0.5, Vec3::Y);
                s.camera(from.with_scale(Vec3::splat(scale)), ());
            });
            let forward = settled(headless);
            change_cameras(headless, |camera| {
                camera.insert(LeanDeferred {
                    advanced: LeanDeferredAdvanced {
                        light_culling: LightCulling::SharedMemory,
                        ..default()
                    },
                    ..default()
                });
            });
            let lean = settled(headless);
            judge(&format!("scaled_{scale}"), &forward, &lean, LEAST_PSNR)
        }));
    });
}
