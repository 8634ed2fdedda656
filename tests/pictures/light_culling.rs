//! All modes of light culling give each pixel the same light, and lose none.

use bevy::{
    camera::{ScalingMode, Viewport, visibility::RenderLayers},
    prelude::*,
};
use bevy_lean_deferred::{LightCulling, prelude::*, view::LeanDeferredAdvanced};
use half::f16;
use kit::{
    hdr::{Light, keep_light_of_views, kept_light},
    headless::{Headless, Picture},
    lean::{active_lean_views, change_cameras, judge, report, settled, show},
    own_process::in_own_process,
    random::Random,
    scenes::{LEAST_PSNR, SceneBuilder},
};

const SIZE: UVec2 = UVec2::new(200, 150);

const CULLING: [LightCulling; 3] = [
    LightCulling::PerPixel,
    LightCulling::Subgroup,
    LightCulling::SharedMemory,
];

/// The picture, and each camera's light before post-processing.
fn lean(headless: &mut Headless, light_culling: LightCulling) -> (Picture, Vec<Light>) {
    change_cameras(headless, |camera| {
        camera.insert(LeanDeferred {
            advanced: LeanDeferredAdvanced {
                light_culling,
                ..default()
            },
            ..default()
        });
    });
    keep_light_of_views(headless);
    let picture = settled(headless);
    let world = headless.world();
    let mut cameras = world.query_filtered::<Entity, With<Camera3d>>();
    let cameras: Vec<Entity> = cameras.iter(world).collect();
    let light = cameras
        .into_iter()
        .map(|camera| kept_light(headless, camera).expect("each camera shows light"));
    (picture, light.collect())
}

/// Rank of a half float among all of them. Both zeros have one rank, and so has any NaN.
fn place(half: f32) -> i32 {
    let bits = i32::from(f16::from_f32(half).to_bits());
    match bits {
        _ if half.is_nan() => i32::MAX,
        0x8000.. => 0x8000 - bits,
        _ => bits,
    }
}

/// Number of pixels that differ by more than one half-float step in some channel. One step is due to Bevy: where the GPU fills clusters,
/// the order of their lights, and so of the sum of light, changes from frame to frame.
fn pixels_apart(a: &[Light], b: &[Light]) -> usize {
    let steps = |(a, b): (&f32, &f32)| place(*a).saturating_sub(place(*b)).unsigned_abs();
    let pairs = a.iter().zip(b);
    let texels = pairs.flat_map(|(a, b)| a.texels.iter().zip(&b.texels));
    texels
        .filter(|(a, b)| a.iter().zip(*b).any(|pair| steps(pair) > 1))
        .count()
}

/// Renders the scene in each mode, and compares the results with one another and, if `like_forward`, with forward.
fn compare(
    headless: &mut Headless,
    name: &str,
    like_forward: bool,
    scene: impl FnOnce(&mut SceneBuilder),
) -> Vec<Result<(), String>> {
    show(headless, scene);
    let forward = settled(headless);
    let shown = CULLING.map(|culling| lean(headless, culling));
    assert!(active_lean_views(headless) > 0, "{name} is not lean");
    let mut results = Vec::new();
    for (culling, (_, light)) in CULLING.iter().zip(&shown).skip(1) {
        let apart = pixels_apart(&shown[0].1, light);
        println!("{name:24} {culling:?}: {apart} pixels are not the same");
        if apart > 0 {
            results.push(Err(format!("{name}, {culling:?}: {apart} pixels")));
        }
    }
    if like_forward {
        results.push(judge(name, &forward, &shown[0].0, LEAST_PSNR));
    }
    results
}

/// Lights of all kinds, many of whose spheres end within a tile.
fn lights(scene: &mut SceneBuilder, count: usize, seed: u64) {
    let mut random = Random::new(seed);
    for i in 0..count {
        let position = Vec3::new(
            random.range(-5.0, 5.0),
            random.range(0.2, 2.5),
            random.range(-5.0, 5.0),
        );
        let color = Color::hsl(random.range(0.0, 360.0), 0.8, 0.6);
        let range = random.range(0.5, 3.0);
        let radius = if i % 4 == 0 { 0.1 } else { 0.0 };
        if i % 3 == 0 {
            let target =
                position + Vec3::new(random.range(-1.0, 1.0), -1.0, random.range(-1.0, 1.0));
            scene.spawn((
                SpotLight {
                    color,
                    range,
                    radius,
                    intensity: 30_000.0,
                    outer_angle: random.range(0.1, 1.5),
                    inner_angle: 0.05,
                    ..default()
                },
                Transform::from_translation(position).looking_at(target, Vec3::X),
            ));
        } else {
            scene.spawn((
                PointLight {
                    color,
                    range,
                    radius,
                    intensity: 10_000.0,
                    ..default()
                },
                Transform::from_translation(position),
            ));
        }
    }
}

fn point_light(scene: &mut SceneBuilder, range: f32, intensity: f32, position: Vec3) {
    scene.spawn((
        PointLight {
            range,
            intensity,
            ..default()
        },
        Transform::from_translation(position),
    ));
}

/// One app shows several scenes, but not so many that their frames fill the memory.
fn compare_all(scenes: &[fn(&mut Headless) -> Vec<Result<(), String>>]) {
    let headless = &mut Headless::new(SIZE);
    report(scenes.iter().flat_map(|&scene| scene(headless)));
}

#[test]
fn all_modes_give_the_same_light() {
    in_own_process(|| {
        compare_all(&[
            many_lights,
            from_close_to_far,
            light_from_behind,
            other_views,
        ])
    });
}

#[test]
#[ignore = "nightly: further lights and views"]
fn all_modes_give_the_same_light_of_further_lights() {
    in_own_process(|| {
        compare_all(&[
            hundreds_of_lights_on_a_pixel,
            lights_with_layers,
            hostile_ranges,
            narrow_cones,
            sheared_cameras,
        ]);
    });
}

fn many_lights(headless: &mut Headless) -> Vec<Result<(), String>> {
    compare(headless, "many", true, |s| {
        s.solids();
        lights(s, 120, 1);
        s.default_camera(());
    })
}

/// More lights in a cluster than invocations in a workgroup.
fn hundreds_of_lights_on_a_pixel(headless: &mut Headless) -> Vec<Result<(), String>> {
    compare(headless, "on_a_pixel", true, |s| {
        s.solids();
        for i in 0..200 {
            let angle = i as f32 * 0.37;
            let position = Vec3::new(angle.cos(), 1.0 + 0.005 * i as f32, angle.sin());
            point_light(s, 20.0, 300.0, position);
        }
        s.default_camera(());
    })
}

fn lights_with_layers(headless: &mut Headless) -> Vec<Result<(), String>> {
    compare(headless, "layers", false, |s| {
        s.solids();
        lights(s, 60, 2);
        let world = s.world();
        let mut all = world.query_filtered::<Entity, With<PointLight>>();
        let all: Vec<Entity> = all.iter(world).collect();
        for (i, light) in all.into_iter().enumerate() {
            let layer = RenderLayers::layer(i % 2);
            world.entity_mut(light).insert(layer);
        }
        s.default_camera(RenderLayers::from_layers(&[0, 1]));
    })
}

fn from_close_to_far(headless: &mut Headless) -> Vec<Result<(), String>> {
    compare(headless, "close_to_far", true, |s| {
        s.mesh(
            Plane3d::default().mesh().size(2e4, 2e4),
            StandardMaterial::default(),
            Transform::default(),
        );
        // Its edges lie directly in front of surfaces that are kilometres away.
        s.mesh(
            Torus::new(0.004, 0.012),
            StandardMaterial::default(),
            Transform::from_xyz(0.0, 1.0, -0.03).with_rotation(Quat::from_rotation_x(1.2)),
        );
        lights(s, 60, 3);
        point_light(s, 0.1, 20.0, Vec3::new(0.01, 1.02, 0.0));
        point_light(s, 5e3, 1e12, Vec3::new(0.0, 500.0, -5e3));
        // The camera is inside its sphere.
        point_light(s, 4.0, 2_000.0, Vec3::Y);
        s.camera(
            Transform::from_translation(Vec3::Y),
            Projection::Perspective(PerspectiveProjection {
                near: 0.005,
                ..default()
            }),
        );
    })
}

fn hostile_ranges(headless: &mut Headless) -> Vec<Result<(), String>> {
    let with = |range: f32| {
        move |s: &mut SceneBuilder| {
            s.solids();
            lights(s, 20, 4);
            point_light(s, range, 50_000.0, Vec3::new(0.0, 2.0, 0.0));
            s.default_camera(());
        }
    };
    [
        ("range_0", 0.0, true),
        ("range_infinite", f32::INFINITY, false),
        ("range_nan", f32::NAN, false),
    ]
    .into_iter()
    .flat_map(|(name, range, like_forward)| compare(headless, name, like_forward, with(range)))
    .collect()
}

fn other_views(headless: &mut Headless) -> Vec<Result<(), String>> {
    let orthographic = |s: &mut SceneBuilder| {
        s.solids();
        lights(s, 60, 5);
        s.default_camera(Projection::Orthographic(OrthographicProjection {
            scaling_mode: ScalingMode::FixedVertical {
                viewport_height: 6.0,
            },
            ..OrthographicProjection::default_3d()
        }));
    };
    let viewports = |s: &mut SceneBuilder| {
        s.solids();
        lights(s, 60, 6);
        for (order, x) in [0, 93].into_iter().enumerate() {
            s.default_camera(Camera {
                order: order as isize,
                viewport: Some(Viewport {
                    physical_position: UVec2::new(x, 11),
                    physical_size: UVec2::new(93, 130),
                    ..default()
                }),
                ..default()
            });
        }
    };
    let usual = |s: &mut SceneBuilder| {
        s.solids();
        lights(s, 60, 7);
        s.default_camera(());
    };
    let single = &mut Headless::new(UVec2::ONE);
    [
        compare(headless, "orthographic", true, orthographic),
        compare(headless, "viewports", true, viewports),
        compare(single, "a_pixel", false, usual),
    ]
    .concat()
}

/// Transmitted light is gathered a thickness behind the surface, within reach of lights that reach no pixel.
fn light_from_behind(headless: &mut Headless) -> Vec<Result<(), String>> {
    compare(headless, "from_behind", true, |s| {
        let mut random = Random::new(8);
        s.floor();
        for i in 0..12 {
            let card = StandardMaterial {
                diffuse_transmission: 0.9,
                thickness: [0.0, 0.3, 1.2, 2.5][i % 4],
                ..Color::hsl(40.0 * i as f32, 0.4, 0.6).into()
            };
            let (column, row) = ((i % 4) as f32, (i / 4) as f32);
            s.mesh(
                Rectangle::new(1.3, 1.3),
                card,
                Transform::from_xyz(1.4 * column - 2.1, 0.5 + 1.4 * row, 0.0),
            );
        }
        for i in 0..60 {
            let position = Vec3::new(
                random.range(-3.0, 3.0),
                random.range(0.1, 4.0),
                random.range(-3.2, -0.8),
            );
            if i % 2 == 0 {
                point_light(s, random.range(0.5, 1.2), 30_000.0, position);
            } else {
                // Shines along the cards.
                s.spawn((
                    SpotLight {
                        range: 3.0,
                        intensity: 100_000.0,
                        outer_angle: random.range(0.1, 0.6),
                        inner_angle: 0.05,
                        ..default()
                    },
                    Transform::from_translation(position)
                        .looking_to(Vec3::new(random.range(-1.0, 1.0), 1.0, 0.4), Vec3::Z),
                ));
            }
        }
        s.camera(
            Transform::from_xyz(0.0, 2.0, 5.0).looking_at(Vec3::Y * 1.8, Vec3::Y),
            (),
        );
    })
}

/// Cones as narrow as cosines can represent.
fn narrow_cones(headless: &mut Headless) -> Vec<Result<(), String>> {
    compare(headless, "narrow_cones", false, |s| {
        s.solids();
        let mut random = Random::new(9);
        for _ in 0..200 {
            let mut within = |size: f32| random.range(-size, size);
            let target = Vec3::new(within(3.0), 0.5 + within(0.5), within(2.0));
            let away = Vec3::new(within(20.0), 25.0 + within(10.0), within(20.0));
            s.spawn((
                SpotLight {
                    range: 100.0,
                    intensity: 1e12,
                    outer_angle: random.range(0.0, 0.004),
                    inner_angle: 0.0,
                    ..default()
                },
                Transform::from_translation(away).looking_at(target, Vec3::X),
            ));
        }
        s.default_camera(());
    })
}

/// Distances in the view space of sheared cameras differ from those in the world.
fn sheared_cameras(headless: &mut Headless) -> Vec<Result<(), String>> {
    let scales = [Vec3::new(0.5, 1.5, 1.0), Vec3::new(0.5, 1.5, 1.118)];
    let results = scales.into_iter().flat_map(|scale| {
        compare(headless, &format!("sheared_{}", scale.z), false, |s| {
            s.solids();
            lights(s, 120, 10);
            let turned = Transform::from_xyz(0.0, 1.0, 3.0)
                .with_rotation(Quat::from_rotation_z(core::f32::consts::FRAC_PI_4));
            let camera = s.camera(turned, ());
            let parent = s.spawn(Transform::from_scale(scale));
            s.world().entity_mut(parent).add_child(camera);
        })
    });
    results.collect()
}
