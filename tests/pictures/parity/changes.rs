//! Changes at run time and their inverses.

use bevy::{
    light::{AmbientLight, NotShadowReceiver},
    pbr::Lightmap,
    prelude::*,
};
use kit::{
    headless::Headless,
    lean::{build, judge, report, set_lean, settled},
    own_process::in_own_process,
    scenes::LEAST_PSNR,
};

const SIZE: UVec2 = UVec2::new(160, 120);

/// Entities and assets that the changes act on.
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

/// Changes, each with its inverse.
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
        // Partly shades the subject.
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

/// A lean camera shows each change within a few frames, without being switched.
#[test]
fn changes_at_run_time_match_forward() {
    in_own_process(|| {
        let (mut headless, subject) = scene_to_change();
        let unchanged = settled(&mut headless);

        set_lean(&mut headless, true);
        settled(&mut headless);
        let few_frames_after = |headless: &mut Headless, change: Change| {
            change(headless.world(), &subject);
            headless.frames(4);
            headless.capture()
        };
        let lean: Vec<_> = CHANGES
            .iter()
            .map(|(_, change, undo)| {
                [change, undo].map(|change| few_frames_after(&mut headless, *change))
            })
            .collect();

        set_lean(&mut headless, false);
        settled(&mut headless);
        let mut results = Vec::new();
        for ((name, change, undo), [to, from]) in CHANGES.iter().zip(lean) {
            change(headless.world(), &subject);
            let forward = settled(&mut headless);
            assert!(forward.rgba != unchanged.rgba, "{name} changes nothing");
            results.push(judge(&format!("to_{name}"), &forward, &to, LEAST_PSNR));

            undo(headless.world(), &subject);
            let forward = settled(&mut headless);
            assert!(forward.rgba == unchanged.rgba, "{name} cannot be undone");
            results.push(judge(
                &format!("from_{name}"),
                &unchanged,
                &from,
                LEAST_PSNR,
            ));
        }
        report(results);
    });
}
