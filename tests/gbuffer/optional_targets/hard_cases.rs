//! Pictures against forward where surfaces change, overlap or emit light that is hard to store.

use bevy::{
    camera::{ClearColorConfig, Viewport},
    core_pipeline::prepass::DepthPrepass,
    light::AmbientLight,
    prelude::*,
    render::occlusion_culling::OcclusionCulling,
};
use bevy_lean_deferred::{gbuffer::GBufferTargets, prelude::*};

use super::{SIZE, forward_draws, usage};
use kit::{
    headless::{Headless, Picture},
    lean::{active_lean_views, build, judge, judge_film, report, set_lean, settled, show},
    metrics::difference,
    own_process::in_own_process,
    scenes::{LEAST_PSNR, SceneBuilder, build::material},
};

fn ambient() -> AmbientLight {
    AmbientLight {
        brightness: 400.0,
        ..default()
    }
}

fn ball() -> Mesh {
    Sphere::new(0.5)
        .mesh()
        .uv(32, 16)
        .with_generated_tangents()
        .expect("a sphere has all that tangents need")
}

/// Material number `i` of a sequence of all kinds.
fn special(i: usize) -> StandardMaterial {
    let base = material(
        (0.75, 0.35, 0.2),
        (i % 3) as f32 * 0.5,
        0.2 + 0.1 * (i % 5) as f32,
    );
    match i % 9 {
        0 => StandardMaterial {
            emissive: LinearRgba::rgb(0.2, 0.5, 0.1),
            ..base
        },
        1 => StandardMaterial {
            reflectance: 1.0,
            ..base
        },
        2 => StandardMaterial {
            clearcoat: 1.0,
            clearcoat_perceptual_roughness: 0.1,
            ..base
        },
        3 => StandardMaterial {
            anisotropy_strength: 0.8,
            anisotropy_rotation: 0.5,
            metallic: 1.0,
            ..base
        },
        4 => StandardMaterial {
            diffuse_transmission: 0.7,
            thickness: 0.1,
            ..base
        },
        5 => StandardMaterial {
            unlit: true,
            ..base
        },
        6 => base,
        7 => StandardMaterial {
            emissive: LinearRgba::rgb(0.1, 0.1, 0.4),
            clearcoat: 0.6,
            ..base
        },
        // Drawn by forward.
        _ => StandardMaterial {
            specular_tint: Color::srgb(0.2, 0.9, 0.2),
            reflectance: 1.0,
            ..base
        },
    }
}

/// Renders a scene forward and lean, and compares.
fn compare(
    name: &str,
    headless: &mut Headless,
    scene: impl FnOnce(&mut SceneBuilder),
) -> Result<(), String> {
    show(headless, scene);
    let forward = settled(headless);
    compare_with(name, &forward, headless)
}

/// Renders lean and compares with `forward`.
fn compare_with(name: &str, forward: &Picture, headless: &mut Headless) -> Result<(), String> {
    set_lean(headless, true);
    let lean = settled(headless);
    judge(name, forward, &lean, LEAST_PSNR)
}

/// Each kind of surface behind, in front of and through each other kind.
fn overlapping(s: &mut SceneBuilder) {
    s.floor();
    for row in 0..9 {
        for column in 0..9 {
            let (x, z) = (column as f32 - 4.0, 4.0 - row as f32);
            s.mesh(
                ball(),
                special(row * 2 + column),
                Transform::from_xyz(x * 0.7, 0.5 + 0.1 * row as f32, z * 0.6),
            );
        }
    }
    s.sun(true);
}

/// In the second phase of culling, plain meshes are drawn in front of special ones that are already drawn.
#[test]
#[ignore = "nightly: combines special surfaces and occlusion culling"]
fn culling_in_two_phases_matches_forward() {
    in_own_process(|| {
        let mut headless = build(SIZE, |s| {
            overlapping(s);
            s.default_camera((ambient(), DepthPrepass, OcclusionCulling));
        });
        // Back and forth, so that meshes hidden in one frame are in front in the next.
        let around = |world: &mut World, frame: usize| {
            let angle = if frame.is_multiple_of(2) { 0.4 } else { -2.0 };
            let mut cameras = world.query_filtered::<&mut Transform, With<Camera3d>>();
            let mut transform = cameras.single_mut(world).expect("one camera");
            *transform = Transform::from_xyz(6.0 * f32::sin(angle), 2.0, 6.0 * f32::cos(angle))
                .looking_at(Vec3::Y * 0.4, Vec3::Y);
        };
        headless.settle();
        let forward = headless.film(6, around);
        set_lean(&mut headless, true);
        headless.settle();
        let lean = headless.film(6, around);
        report(judge_film("two_phases", &forward, &lean, LEAST_PSNR));
    });
}

fn unlit_colours_match_forward(headless: &mut Headless) -> Result<(), String> {
    compare("unlit_colours", headless, |s| {
        let gradient = s.image(
            256,
            bevy::render::render_resource::TextureFormat::Rgba8UnormSrgb,
            |u, v| {
                [
                    (u * 255.0) as u8,
                    (v * 255.0) as u8,
                    (u * v * 60.0) as u8,
                    255,
                ]
            },
        );
        for (i, brightness) in [0.02, 1.0, 30.0].into_iter().enumerate() {
            s.mesh(
                Rectangle::new(1.8, 3.0),
                StandardMaterial {
                    base_color: Color::linear_rgb(brightness, brightness, brightness),
                    base_color_texture: Some(gradient.clone()),
                    unlit: true,
                    ..default()
                },
                Transform::from_xyz(i as f32 * 1.9 - 1.9, 0.8, 0.0),
            );
        }
        s.default_camera(());
    })
}

#[test]
fn bright_and_broken_emission_and_unlit_colours_match_forward() {
    in_own_process(|| {
        let mut headless = Headless::new(SIZE);
        report([unlit_colours_match_forward(&mut headless)]);
        let emissive = [
            LinearRgba::rgb(1e6, 1e6, 1e6),
            LinearRgba::rgb(1e6, 0.0, 0.0),
            LinearRgba::rgb(-2.0, 0.3, 0.3),
            LinearRgba::rgb(1e-6, 1e-6, 1e-6),
        ];
        let bright = |s: &mut SceneBuilder| {
            s.floor();
            for (i, emissive) in emissive.into_iter().enumerate() {
                let x = i as f32 - 1.5;
                s.mesh(
                    ball(),
                    StandardMaterial {
                        base_color: Color::BLACK,
                        emissive,
                        ..default()
                    },
                    Transform::from_xyz(x, 0.5, 0.0),
                );
                s.mesh(
                    Cuboid::from_length(0.5),
                    material((0.0, 0.0, 0.0), 0.0, 1.0),
                    Transform::from_xyz(x + 0.5, 0.25, 0.5),
                );
            }
            s.sun(false);
            s.default_camera(ambient());
        };
        show(&mut headless, bright);
        let forward = settled(&mut headless);
        if !forward.rgba.chunks(4).any(|pixel| pixel == [255; 4]) {
            println!("skipped: emission beyond half floats: forward's own is black on this device");
            return;
        }
        report([compare_with("bright_emission", &forward, &mut headless)]);
    });
}

/// The lean picture shows a surface without emission, or with the largest that can be stored, where forward's is NaN.
#[test]
fn emission_that_is_not_a_number_is_black_and_infinite_emission_bright() {
    in_own_process(|| {
        let mut headless = Headless::new(SIZE);
        let dark = {
            show(&mut headless, |s| {
                s.floor();
                let clay = material((0.6, 0.5, 0.4), 0.0, 0.5);
                s.mesh(ball(), clay, Transform::from_xyz(0.0, 0.5, 0.0));
                s.sun(true);
                s.default_camera(ambient());
            });
            set_lean(&mut headless, true);
            settled(&mut headless)
        };
        let mut picture = |emissive: f32| {
            show(&mut headless, |s| {
                s.floor();
                let glow = StandardMaterial {
                    emissive: LinearRgba::rgb(emissive, 0.5, 0.5),
                    ..material((0.6, 0.5, 0.4), 0.0, 0.5)
                };
                s.mesh(ball(), glow, Transform::from_xyz(0.0, 0.5, 0.0));
                s.sun(true);
                s.default_camera(ambient());
            });
            set_lean(&mut headless, true);
            let picture = settled(&mut headless);
            assert!(!forward_draws(&headless));
            picture
        };
        let difference = difference(&dark, &picture(f32::NAN));
        assert!(difference.psnr > 60.0, "{difference}");

        let bright = picture(f32::INFINITY);
        let center = (bright.size.y / 2 * bright.size.x + bright.size.x / 2) as usize * 4;
        assert!(
            bright.rgba[center] > 250,
            "{:?}",
            &bright.rgba[center..center + 4]
        );
    });
}

#[test]
#[ignore = "nightly: the same materials, a thousand of them"]
fn a_thousand_materials_match_forward() {
    in_own_process(|| {
        let mut headless = Headless::new(SIZE);
        let result = compare("a_thousand_materials", &mut headless, |s| {
            let mesh = s.add::<Mesh>(
                Sphere::new(0.12)
                    .mesh()
                    .uv(12, 6)
                    .with_generated_tangents()
                    .expect("a sphere has all that tangents need"),
            );
            s.floor();
            for i in 0..1000 {
                let mut material = special(i % 8);
                material.base_color = Color::hsl(i as f32 * 0.36, 0.6, 0.5);
                let material = s.add::<StandardMaterial>(material);
                let (x, z) = ((i % 40) as f32, (i / 40) as f32);
                s.spawn((
                    Mesh3d(mesh.clone()),
                    MeshMaterial3d(material),
                    Transform::from_xyz(x * 0.2 - 4.0, 0.12, 2.5 - z * 0.25),
                ));
            }
            // Without shadows: a software renderer takes long enough for a thousand draws.
            s.sun(false);
            s.default_camera(ambient());
        });
        report([result]);
        assert!(!forward_draws(&headless));
        let all = GBufferTargets::EMISSIVE | GBufferTargets::SPECIALIZATION;
        assert_eq!(usage(&mut headless).targets, all);
    });
}

/// No frame lacks the mesh or shows its old look, however its material changes.
#[test]
fn a_material_of_another_kind_in_each_frame_matches_forward() {
    in_own_process(|| {
        let mut handle = Handle::default();
        let mut headless = build(SIZE, |s| {
            s.floor();
            handle = s.add::<StandardMaterial>(special(6));
            let mesh = s.add::<Mesh>(ball());
            s.spawn((
                Mesh3d(mesh),
                MeshMaterial3d(handle.clone()),
                Transform::from_xyz(0.0, 0.8, 0.5).with_scale(Vec3::splat(2.0)),
            ));
            s.sun(true);
            s.default_camera(ambient());
        });
        let change = |world: &mut World, frame: usize| {
            let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
            *materials.get_mut(&handle).expect("it is there") = special(frame);
        };
        headless.settle();
        let forward = headless.film(27, change);
        set_lean(&mut headless, true);
        // The first round creates targets and pipelines; the others reuse them.
        let lean = headless.film(27, change);
        report(judge_film("changing", &forward, &lean, LEAST_PSNR));
    });
}

/// Special surfaces match forward on one camera, then on one of two, on both, on the other alone, and on none again.
#[test]
#[ignore = "nightly: combines special surfaces and shared targets"]
fn special_surfaces_on_two_cameras_match_forward() {
    in_own_process(|| {
        let mut headless = Headless::new(SIZE);
        report([compare("overlapping_kinds", &mut headless, |s| {
            overlapping(s);
            s.default_camera(ambient());
        })]);
        let mut cameras = Vec::new();
        show(&mut headless, |s| {
            overlapping(s);
            for order in 0..2 {
                let left = SIZE.x / 2 * order;
                cameras.push(s.default_camera((
                    ambient(),
                    Camera {
                        order: order as isize,
                        viewport: Some(Viewport {
                            physical_position: UVec2::new(left, 0),
                            physical_size: UVec2::new(SIZE.x / 2, SIZE.y),
                            ..default()
                        }),
                        clear_color: if order == 0 {
                            ClearColorConfig::Default
                        } else {
                            ClearColorConfig::None
                        },
                        ..default()
                    },
                )));
            }
        });
        let forward = settled(&mut headless);
        report(
            [[true, false], [true, true], [false, true], [false, false]].map(|lean| {
                for (&camera, lean) in cameras.iter().zip(lean) {
                    let mut camera = headless.world().entity_mut(camera);
                    if lean {
                        camera.insert(LeanDeferred::default());
                    } else {
                        camera.remove::<LeanDeferred>();
                    }
                }
                let picture = settled(&mut headless);
                let views = active_lean_views(&mut headless);
                assert_eq!(views, lean.into_iter().filter(|lean| *lean).count());
                let least = if views == 0 {
                    f64::INFINITY
                } else {
                    LEAST_PSNR
                };
                judge(&format!("cameras_{lean:?}"), &forward, &picture, least)
            }),
        );
    });
}
