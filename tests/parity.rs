//! Pictures of lean cameras beside Bevy forward's.

mod common;

use bevy::{
    camera::{ClearColorConfig, ScalingMode, Viewport},
    light::{AmbientLight, NotShadowReceiver},
    material::OpaqueRendererMethod,
    pbr::Lightmap,
    prelude::*,
};
use bevy_lean_deferred::prelude::*;
use common::{
    headless::{Headless, Picture},
    lean::{build, judge, report, set_lean, settled},
    scenes::{self, LEAST_PSNR, Scene},
};

const SIZE: UVec2 = UVec2::new(320, 240);

fn scene_named(name: &str) -> &'static Scene {
    scenes::all()
        .find(|scene| scene.name == name)
        .expect("a scene of that name")
}

/// Renders a scene forward, then lean in the same app, and compares.
fn compare(scene: &Scene, size: UVec2) -> Result<(), String> {
    let mut headless = build(size, scene.build);
    let forward = settled(&mut headless);
    set_lean(&mut headless, true);
    let lean = settled(&mut headless);
    let name = if size == SIZE {
        scene.name.into()
    } else {
        format!("{}_{}x{}", scene.name, size.x, size.y)
    };
    judge(&name, &forward, &lean, scene.least_psnr)
}

/// All scenes, or those whose name has one of the words of `PARITY_SCENE`, which commas separate.
#[test]
fn lean_pictures_match_forward() {
    let only = std::env::var("PARITY_SCENE").unwrap_or_default();
    report(
        scenes::all()
            .filter(|scene| only.split(',').any(|word| scene.name.contains(word)))
            .map(|scene| compare(scene, SIZE)),
    );
}

#[test]
fn odd_sizes_match_forward() {
    report(
        [UVec2::new(1, 1), UVec2::new(3, 5), UVec2::new(317, 211)]
            .map(|size| compare(scene_named("many_lights_of_all_kinds"), size)),
    );
}

/// Bevy's forward does not draw materials with an explicit `Deferred` on a camera without `DeferredPrepass`. A lean
/// camera draws all of them: as forward does those that leave the choice to it.
#[test]
fn explicitly_deferred_materials_look_as_others_do_forward() {
    let glow = LinearRgba::rgb(0.1, 0.4, 0.1);
    report(
        [("deferred", LinearRgba::BLACK), ("deferred_emissive", glow)].map(|(name, emissive)| {
            let mut headless = build(SIZE, |s| {
                s.among_lean(StandardMaterial {
                    base_color: Color::srgb(0.8, 0.2, 0.15),
                    emissive,
                    ..default()
                });
                s.sun(true);
                s.default_camera(());
            });
            let forward = settled(&mut headless);
            let mut materials = headless.world().resource_mut::<Assets<StandardMaterial>>();
            for (_, material) in materials.iter_mut() {
                material.opaque_render_method = OpaqueRendererMethod::Deferred;
            }
            set_lean(&mut headless, true);
            let lean = settled(&mut headless);
            judge(name, &forward, &lean, LEAST_PSNR)
        }),
    );
}

#[test]
fn a_lean_camera_leaves_others_of_its_target_alone() {
    let rects = [
        URect::new(0, 0, 151, SIZE.y),
        URect::new(151, 0, SIZE.x, SIZE.y),
    ];
    for lean in 0..2 {
        let mut cameras = Vec::new();
        let mut headless = build(SIZE, |s| {
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
        let before = settled(&mut headless);
        headless
            .world()
            .entity_mut(cameras[lean])
            .insert(LeanDeferred::default());
        let after = settled(&mut headless);
        let changed = |rect: URect| before.crop(rect) != after.crop(rect);
        assert!(changed(rects[lean]), "camera {lean} is not lean at all");
        assert!(
            !changed(rects[1 - lean]),
            "lean camera {lean} changed the other one's picture"
        );
    }
}

/// A camera that draws over an earlier one's picture, one of both lean.
#[test]
fn a_lean_and_a_forward_camera_share_a_picture() {
    report((0..2).map(|lean| {
        let mut cameras = Vec::new();
        let mut headless = build(SIZE, |s| {
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
        let forward = settled(&mut headless);
        headless
            .world()
            .entity_mut(cameras[lean])
            .insert(LeanDeferred::default());
        let mixed = settled(&mut headless);
        judge(
            &format!("over_another_lean_{lean}"),
            &forward,
            &mixed,
            LEAST_PSNR,
        )
    }));
}

#[test]
fn removing_the_component_gives_back_forward() {
    for name in [
        "many_lights_of_all_kinds",
        "emissive",
        "alpha_mask",
        "bevy_ssao",
        "all_prepasses",
        "occlusion_culling",
        "split_screen",
    ] {
        let mut headless = build(SIZE, scene_named(name).build);
        let before = settled(&mut headless);
        set_lean(&mut headless, true);
        let lean = settled(&mut headless);
        set_lean(&mut headless, false);
        let after = settled(&mut headless);
        assert!(lean.rgba != before.rgba, "{name} was never lean");
        assert!(after.rgba == before.rgba, "{name} is not as before");
    }
}

/// What the run-time changes act on.
struct Subject {
    entity: Entity,
    materials: [Handle<StandardMaterial>; 3],
    meshes: [Handle<Mesh>; 2],
    lightmap: Handle<Image>,
}

#[derive(Component)]
struct Added;

type Change = fn(&mut World, &Subject);

fn edit(world: &mut World, subject: &Subject, change: fn(&mut StandardMaterial)) {
    let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
    change(
        &mut materials
            .get_mut(&subject.materials[0])
            .expect("kept alive"),
    );
}

fn remove_added(world: &mut World, _: &Subject) {
    let added: Vec<Entity> = world
        .query_filtered::<Entity, With<Added>>()
        .iter(world)
        .collect();
    added.into_iter().for_each(|entity| {
        world.despawn(entity);
    });
}

/// Each with its inverse.
const CHANGES: &[(&str, Change, Change)] = &[
    (
        "emissive",
        |w, s| edit(w, s, |m| m.emissive = LinearRgba::rgb(0.2, 0.6, 0.2)),
        |w, s| edit(w, s, |m| m.emissive = LinearRgba::BLACK),
    ),
    (
        "base_color",
        |w, s| edit(w, s, |m| m.base_color = Color::srgb(0.1, 0.8, 0.3)),
        |w, s| edit(w, s, |m| m.base_color = Color::srgb(0.8, 0.2, 0.15)),
    ),
    (
        "blended",
        |w, s| {
            edit(w, s, |m| {
                m.alpha_mode = AlphaMode::Blend;
                m.base_color.set_alpha(0.5);
            })
        },
        |w, s| {
            edit(w, s, |m| {
                m.alpha_mode = AlphaMode::Opaque;
                m.base_color.set_alpha(1.0);
            })
        },
    ),
    (
        "not_shadow_receiver",
        |w, s| {
            w.entity_mut(s.entity).insert(NotShadowReceiver);
        },
        |w, s| {
            w.entity_mut(s.entity).remove::<NotShadowReceiver>();
        },
    ),
    (
        "lightmap",
        |w, s| {
            let image = s.lightmap.clone();
            w.entity_mut(s.entity)
                .insert(Lightmap { image, ..default() });
        },
        |w, s| {
            w.entity_mut(s.entity).remove::<Lightmap>();
        },
    ),
    (
        "point_light",
        |w, _| {
            w.spawn((
                PointLight {
                    intensity: 900_000.0,
                    shadow_maps_enabled: true,
                    ..default()
                },
                Transform::from_xyz(-2.0, 2.5, 1.5),
                Added,
            ));
        },
        remove_added,
    ),
    (
        "rect_light",
        |w, _| {
            w.spawn((
                RectLight {
                    intensity: 900_000.0,
                    width: 2.0,
                    height: 1.0,
                    ..default()
                },
                Transform::from_xyz(0.0, 2.5, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
                Added,
            ));
        },
        remove_added,
    ),
    (
        "new_mesh",
        |w, s| {
            w.spawn((
                Mesh3d(s.meshes[1].clone()),
                MeshMaterial3d(s.materials[1].clone()),
                Transform::from_xyz(0.0, 0.6, 2.0),
                Added,
            ));
        },
        remove_added,
    ),
    (
        "hidden",
        |w, s| {
            w.entity_mut(s.entity).insert(Visibility::Hidden);
        },
        |w, s| {
            w.entity_mut(s.entity).insert(Visibility::Visible);
        },
    ),
    (
        "other_lean_material",
        |w, s| swap_material(w, s, 1),
        |w, s| swap_material(w, s, 0),
    ),
    (
        "other_forward_material",
        |w, s| swap_material(w, s, 2),
        |w, s| swap_material(w, s, 0),
    ),
    (
        "other_mesh",
        |w, s| swap_mesh(w, s, 1),
        |w, s| swap_mesh(w, s, 0),
    ),
];

fn swap_material(world: &mut World, subject: &Subject, to: usize) {
    let material = subject.materials[to].clone();
    world
        .entity_mut(subject.entity)
        .insert(MeshMaterial3d(material));
}

fn swap_mesh(world: &mut World, subject: &Subject, to: usize) {
    let mesh = subject.meshes[to].clone();
    world.entity_mut(subject.entity).insert(Mesh3d(mesh));
}

fn scene_to_change() -> (Headless, Subject) {
    let mut subject = None;
    let headless = build(SIZE, |s| {
        s.solids();
        s.sun(true);
        // Shades the subject in part.
        let clay = scenes_material(Color::srgb(0.5, 0.5, 0.5));
        s.mesh(
            Cuboid::new(3.0, 0.1, 0.4),
            clay,
            Transform::from_xyz(0.6, 2.2, 1.6),
        );
        let materials = [
            s.add(scenes_material(Color::srgb(0.8, 0.2, 0.15))),
            s.add(scenes_material(Color::srgb(0.9, 0.9, 0.2))),
            s.add(StandardMaterial {
                clearcoat: 1.0,
                ..scenes_material(Color::srgb(0.2, 0.2, 0.9))
            }),
        ];
        let meshes = [
            Sphere::new(0.8).mesh().uv(48, 24),
            Cuboid::from_length(1.1).into(),
        ]
        .map(|mut mesh| {
            let uvs = mesh.attribute(Mesh::ATTRIBUTE_UV_0).cloned();
            mesh.insert_attribute(Mesh::ATTRIBUTE_UV_1, uvs.expect("built meshes have UVs"));
            s.add::<Mesh>(mesh)
        });
        let lightmap = s.checker([200, 40, 40, 255], [40, 40, 200, 255]);
        let entity = s.spawn((
            Mesh3d(meshes[0].clone()),
            MeshMaterial3d(materials[0].clone()),
            Transform::from_xyz(0.0, 0.9, 0.8),
        ));
        s.default_camera(AmbientLight {
            brightness: 500.0,
            ..default()
        });
        subject = Some(Subject {
            entity,
            materials,
            meshes,
            lightmap,
        });
    });
    (headless, subject.expect("it was built"))
}

fn scenes_material(base_color: Color) -> StandardMaterial {
    StandardMaterial {
        base_color,
        lightmap_exposure: 2000.0,
        ..default()
    }
}

/// Each change is seen by a lean camera within a few frames, without switching it over.
#[test]
fn changes_at_run_time_match_forward() {
    let (mut headless, subject) = scene_to_change();
    let unchanged = settled(&mut headless);
    let mut results = Vec::new();
    for (name, change, undo) in CHANGES {
        let few_frames_later = |headless: &mut Headless| {
            headless.frames(8);
            headless.capture()
        };
        set_lean(&mut headless, true);
        settled(&mut headless);

        change(headless.world(), &subject);
        let lean = few_frames_later(&mut headless);
        set_lean(&mut headless, false);
        let forward = settled(&mut headless);
        assert!(forward.rgba != unchanged.rgba, "{name} changes nothing");
        results.push(judge(&format!("to_{name}"), &forward, &lean, LEAST_PSNR));

        set_lean(&mut headless, true);
        settled(&mut headless);
        undo(headless.world(), &subject);
        let lean = few_frames_later(&mut headless);
        results.push(judge(
            &format!("from_{name}"),
            &unchanged,
            &lean,
            LEAST_PSNR,
        ));
        set_lean(&mut headless, false);
        let forward = settled(&mut headless);
        assert!(forward.rgba == unchanged.rgba, "{name} cannot be undone");
    }
    report(results);
}

/// One material of each kind.
fn material_kinds() -> Vec<(&'static str, StandardMaterial)> {
    type Edit = fn(&mut StandardMaterial);
    let kinds: [(&str, Edit); 22] = [
        ("plain", |_| {}),
        ("metal", |m| m.metallic = 1.0),
        ("mask", |m| m.alpha_mode = AlphaMode::Mask(0.5)),
        ("coverage", |m| m.alpha_mode = AlphaMode::AlphaToCoverage),
        ("blend", |m| m.alpha_mode = AlphaMode::Blend),
        ("premultiplied", |m| m.alpha_mode = AlphaMode::Premultiplied),
        ("add", |m| m.alpha_mode = AlphaMode::Add),
        ("emissive", |m| m.emissive = LinearRgba::rgb(0.2, 0.2, 0.2)),
        ("unlit", |m| m.unlit = true),
        ("clearcoat", |m| m.clearcoat = 1.0),
        ("anisotropy", |m| m.anisotropy_strength = 0.8),
        ("reflectance", |m| m.reflectance = 0.9),
        ("tint", |m| m.specular_tint = Color::srgb(1.0, 0.0, 0.0)),
        ("specular_transmission", |m| m.specular_transmission = 0.5),
        ("diffuse_transmission", |m| m.diffuse_transmission = 0.5),
        ("no_fog", |m| m.fog_enabled = false),
        ("depth_bias", |m| m.depth_bias = 1.0),
        ("double_sided", |m| {
            m.double_sided = true;
            m.cull_mode = None;
        }),
        ("forward", |m| {
            m.opaque_render_method = OpaqueRendererMethod::Forward;
        }),
        ("auto", |m| {
            m.opaque_render_method = OpaqueRendererMethod::Auto;
        }),
        ("too_bright", |m| {
            m.base_color = Color::linear_rgb(2.0, 0.5, 0.1)
        }),
        ("masked_emissive", |m| {
            m.alpha_mode = AlphaMode::Mask(0.5);
            m.emissive = LinearRgba::rgb(0.2, 0.2, 0.2);
        }),
    ];
    let count = kinds.len() as f32;
    kinds
        .into_iter()
        .enumerate()
        .map(|(i, (name, edit))| {
            let mut material = StandardMaterial {
                base_color: Color::hsl(360.0 * i as f32 / count, 0.8, 0.5),
                ..default()
            };
            edit(&mut material);
            (name, material)
        })
        .collect()
}

/// A card, a ball and a mirrored ball of each kind of material, each in a cell of its own: it covers the same pixels
/// with the same mean colour.
#[test]
fn no_mesh_is_lost() {
    const CELL: u32 = 20;
    let kinds = material_kinds();
    let shapes = [
        Mesh::from(Rectangle::new(0.7, 0.7)),
        Sphere::new(0.35).mesh().uv(24, 16),
        Sphere::new(0.35).mesh().uv(24, 16),
    ]
    .map(|mesh| {
        mesh.with_generated_tangents()
            .expect("these have all that tangents need")
    });
    let size = UVec2::new(kinds.len() as u32, shapes.len() as u32) * CELL;
    let mut headless = build(size, |s| {
        let shapes = shapes.map(|mesh| s.add::<Mesh>(mesh));
        for (column, (_, material)) in kinds.iter().enumerate() {
            let material = s.add::<StandardMaterial>(material.clone());
            for (row, mesh) in shapes.iter().enumerate() {
                let mirror = if row == 2 { -1.0 } else { 1.0 };
                s.spawn((
                    Mesh3d(mesh.clone()),
                    MeshMaterial3d(material.clone()),
                    Transform::from_xyz(column as f32 + 0.5, -(row as f32) - 0.5, 0.0)
                        .with_scale(Vec3::new(mirror, 1.0, 1.0)),
                ));
            }
        }
        s.sun(false);
        let middle = size.as_vec2() / CELL as f32 / 2.0;
        s.camera(
            Transform::from_xyz(middle.x, -middle.y, 10.0),
            (
                Projection::Orthographic(OrthographicProjection {
                    scaling_mode: ScalingMode::Fixed {
                        width: middle.x * 2.0,
                        height: middle.y * 2.0,
                    },
                    ..OrthographicProjection::default_3d()
                }),
                Camera {
                    clear_color: ClearColorConfig::Custom(Color::srgb(0.3, 0.0, 0.3)),
                    ..default()
                },
            ),
        );
    });
    let forward = settled(&mut headless);
    set_lean(&mut headless, true);
    let lean = settled(&mut headless);

    // Pixels that something was drawn to, and their mean colour. The corner of a cell is background, which is dithered.
    let content = |picture: &Picture, column: u32, row: u32| {
        let min = UVec2::new(column, row) * CELL;
        let pixels = picture.crop(URect::from_corners(min, min + CELL)).rgba;
        let is_drawn = |p: &[u8]| p.iter().zip(&pixels).any(|(a, b)| a.abs_diff(*b) > 2);
        let drawn = pixels.chunks(4).filter(|p| is_drawn(p));
        let (count, sum) = drawn.fold((0u32, Vec3::ZERO), |(count, sum), p| {
            let color = Vec3::new(p[0].into(), p[1].into(), p[2].into());
            (count + 1, sum + color)
        });
        (count, sum / count.max(1) as f32)
    };
    let mut results = vec![judge("no_mesh_is_lost", &forward, &lean, LEAST_PSNR)];
    for (column, (name, _)) in kinds.iter().enumerate() {
        for row in 0..3 {
            let (count, color) = content(&forward, column as u32, row);
            let (lean_count, lean_color) = content(&lean, column as u32, row);
            assert!(count > 100, "{name} {row} does not even show in forward");
            if count.abs_diff(lean_count) > 2 || color.distance(lean_color) > 4.0 {
                results.push(Err(format!(
                    "{name} {row}: forward {count} pixels of {color}, lean {lean_count} of {lean_color}"
                )));
            }
        }
    }
    report(results);
}
