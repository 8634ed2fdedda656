//! People who walk up and down the street, some under umbrellas: skinned meshes.

mod body;
pub mod walk;

use bevy::{
    mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    prelude::*,
};
use fastrand::Rng;

use crate::{
    detail::Detail,
    geometry::Geometry,
    ground::{KERB, KERB_HEIGHT},
    materials::{COLORS, Materials},
    stage::Stage,
};
use body::JOINTS;
use walk::Walker;

/// Nobody comes nearer to the cameras than this, in metres along z.
pub const NEAREST: f32 = 4.6;

pub fn spawn(stage: &mut Stage, materials: &Materials, detail: Detail) {
    let meshes = [false, true].map(|holds| stage.meshes.add(body::mesh(holds)));
    let unposed: Vec<Mat4> = JOINTS
        .map(|joint| Mat4::from_translation(-joint.place()))
        .into();
    let bind_poses = stage
        .bind_poses
        .add(SkinnedMeshInverseBindposes::from(unposed));
    let umbrella = umbrella(stage);
    let mut random = Rng::with_seed(31);
    for number in 0..detail.figures {
        let has_umbrella = random.f32() < 0.55;
        let walker = Walker {
            lane: lane(number, &mut random),
            towards_us: random.bool(),
            speed: 0.9 + 0.5 * random.f32(),
            far: detail.far + 3.0,
            near: NEAREST,
            way: detail.length() * (number as f32 + random.f32()) / detail.figures as f32,
        };
        let height = 0.92 + 0.16 * random.f32();
        let root = stage
            .commands
            .spawn((
                walker.transform().with_scale(Vec3::splat(height)),
                Visibility::default(),
            ))
            .id();
        let joints = spawn_joints(&mut stage.commands, root);
        let coat = &materials.coats[random.usize(0..COLORS)];
        stage.commands.spawn((
            Mesh3d(meshes[usize::from(has_umbrella)].clone()),
            MeshMaterial3d(coat.clone()),
            SkinnedMesh {
                inverse_bindposes: bind_poses.clone(),
                joints: joints.clone(),
            },
            ChildOf(root),
        ));
        if has_umbrella {
            let color = &materials.umbrellas[random.usize(0..COLORS)];
            for (mesh, material) in umbrella.iter().zip([color, &materials.trim]) {
                stage.commands.spawn((
                    Mesh3d(mesh.clone()),
                    MeshMaterial3d(material.clone()),
                    ChildOf(root),
                ));
            }
        }
        stage.commands.entity(root).insert((
            walker,
            walk::Joints(joints),
            walk::HoldsUmbrella(has_umbrella),
        ));
    }
}

/// Position across the street, and height on the pavements. Nobody walks where the cameras are.
fn lane(number: usize, random: &mut Rng) -> Vec2 {
    let side = if number.is_multiple_of(2) { 1.0 } else { -1.0 };
    match number % 6 {
        0 | 1 => Vec2::new(side * (KERB + 0.9 + 0.2 * random.f32()), KERB_HEIGHT),
        _ => Vec2::new(side * (0.7 + 1.5 * random.f32()), 0.0),
    }
}

fn spawn_joints(commands: &mut Commands, root: Entity) -> Vec<Entity> {
    let mut joints: Vec<Entity> = Vec::new();
    for joint in JOINTS {
        let parent = joint.parent.map_or(root, |parent| joints[parent]);
        let entity = commands.spawn((joint.local(), Visibility::default(), ChildOf(parent)));
        joints.push(entity.id());
    }
    joints
}

/// Cloth and stick, above a right hand.
fn umbrella(stage: &mut Stage) -> [Handle<Mesh>; 2] {
    let top = body::HAND + Vec3::new(0.06, 0.95, -0.08);
    let mut cloth = Geometry::default();
    cloth.cone(top - Vec3::Y * 0.13, top, [0.42, 0.02], 8);
    cloth.cone(top - Vec3::Y * 0.3, top - Vec3::Y * 0.13, [0.6, 0.42], 8);
    let mut stick = Geometry::default();
    stick.bar(body::HAND - Vec3::Y * 0.1, top + Vec3::Y * 0.05, 0.012, 6);
    [cloth, stick].map(|part| stage.meshes.add(part.mesh()))
}
