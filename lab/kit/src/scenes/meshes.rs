//! Every kind of mesh and mesh instance.

use bevy::{
    asset::RenderAssetUsages,
    camera::visibility::{NoCpuCulling, NoFrustumCulling, RenderLayers, VisibilityRange},
    mesh::{
        Indices, PrimitiveTopology, VertexAttributeValues,
        morph::{MeshMorphWeights, MorphAttributes},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
    render::batching::NoAutomaticBatching,
};

use super::{
    Scene, SceneBuilder,
    build::{ambient, default_camera_transform, material},
};

pub const SCENES: &[Scene] = &[
    Scene::new("skinned", |s| {
        s.floor();
        skinned(s);
        lit(s);
    }),
    Scene::new("morph_targets", |s| {
        s.floor();
        morphed(s);
        lit(s);
    }),
    Scene::new("many_instances", |s| {
        instances(s, || ());
        unshadowed(s);
    })
    .nightly(),
    Scene::new("many_instances_shadow", |s| {
        instances(s, || ());
        lit(s);
    }),
    // One to three pixels high: depth has no neighbour from which the surface's normal can be reconstructed.
    Scene::new("shadows_on_edge", |s| {
        s.floor();
        let eye = default_camera_transform().translation;
        for i in 0..8 {
            let step = i as f32;
            s.mesh(
                Plane3d::default().mesh().size(0.6, 1.0),
                Color::srgb(0.9, 0.8, 0.7),
                Transform::from_xyz(step * 0.7 - 2.6, eye.y - 0.08 - 0.03 * step, -0.5),
            );
        }
        lit(s);
    })
    .allow(50.0, "stricter: where these shadow themselves it is 47.8 dB"),
    Scene::new("no_automatic_batching", |s| {
        instances(s, || NoAutomaticBatching);
        unshadowed(s);
    }),
    Scene::new("no_frustum_culling", |s| {
        instances(s, || NoFrustumCulling);
        unshadowed(s);
    })
    .nightly(),
    Scene::new("no_cpu_culling", |s| {
        instances(s, || NoCpuCulling);
        s.sun(false);
        s.default_camera((ambient(), NoCpuCulling));
    }),
    Scene::new("mirrored_and_stretched", |s| {
        s.floor();
        for (x, scale) in [
            (-2.0, Vec3::new(-1.0, 1.0, 1.0)),
            (0.0, Vec3::new(0.5, 2.0, 1.2)),
            (2.0, Vec3::new(1.6, -0.6, 0.7)),
        ] {
            s.mesh(
                Torus::new(0.25, 0.6),
                red(),
                Transform::from_xyz(x, 0.9, 0.0)
                    .with_rotation(Quat::from_rotation_x(0.7))
                    .with_scale(scale),
            );
        }
        lit(s);
    }),
    Scene::new("without_normals", |s| {
        s.floor();
        let mut mesh = Mesh::from(Cuboid::from_length(1.4));
        mesh.remove_attribute(Mesh::ATTRIBUTE_NORMAL);
        s.mesh(mesh, red(), Transform::from_xyz(0.0, 0.8, 0.0));
        lit(s);
    })
    .nightly(),
    Scene::new("without_uvs", |s| {
        s.floor();
        let mut mesh = Mesh::from(Cuboid::from_length(1.4));
        mesh.remove_attribute(Mesh::ATTRIBUTE_UV_0);
        let checker = s.checker([255; 4], [0, 0, 0, 255]);
        s.mesh(
            mesh,
            StandardMaterial {
                base_color_texture: Some(checker),
                ..red()
            },
            Transform::from_xyz(0.0, 0.8, 0.0),
        );
        lit(s);
    })
    .nightly(),
    Scene::new("positions_only", |s| {
        s.floor();
        let mut mesh = Mesh::from(Cuboid::from_length(1.4));
        mesh.remove_attribute(Mesh::ATTRIBUTE_UV_0);
        mesh.remove_attribute(Mesh::ATTRIBUTE_NORMAL);
        s.mesh(mesh, red(), Transform::from_xyz(0.0, 0.8, 0.0));
        lit(s);
    }),
    Scene::new("lines", |s| {
        s.floor();
        wires(s, PrimitiveTopology::LineList);
        lit(s);
    }),
    Scene::new("line_strip", |s| {
        s.floor();
        wires(s, PrimitiveTopology::LineStrip);
        lit(s);
    })
    .nightly(),
    Scene::new("points", |s| {
        s.floor();
        wires(s, PrimitiveTopology::PointList);
        lit(s);
    })
    .nightly(),
    Scene::new("triangle_strip", |s| {
        s.floor();
        let count = 40u16;
        let mut positions = Vec::new();
        let mut normals = Vec::new();
        for i in 0..count {
            let angle = f32::from(i / 2) * 0.25 - 2.4;
            let (sin, cos) = angle.sin_cos();
            positions.push([1.5 * sin, if i % 2 == 0 { 0.1 } else { 1.5 }, 1.5 * cos]);
            normals.push([sin, 0.0, cos]);
        }
        let mesh = Mesh::new(
            PrimitiveTopology::TriangleStrip,
            RenderAssetUsages::default(),
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
        .with_inserted_indices(Indices::U16((0..count).collect()));
        s.mesh(
            mesh,
            StandardMaterial {
                double_sided: true,
                cull_mode: None,
                ..red()
            },
            Transform::default(),
        );
        lit(s);
    })
    .allow(
        42.0,
        "a sheet without thickness at the terminator: whether it shadows itself hangs on the last bit of the bias, which \
         follows the facet here and the interpolated normal in forward (55.9 dB on llvmpipe, 44.0 on an H200)",
    ),
    Scene::new("far_from_origin", |s| {
        s.solids();
        let offset = Vec3::new(10_000.0, 20.0, -10_000.0);
        let world = s.world();
        for mut transform in world.query::<&mut Transform>().iter_mut(world) {
            transform.translation += offset;
        }
        s.sun(true);
        let mut camera = default_camera_transform();
        camera.translation += offset;
        s.camera(camera, ambient());
    }),
    Scene::new("visibility_range_crossfade", |s| {
        crossfade(s);
        unshadowed(s);
    })
    .nightly(),
    Scene::new("visibility_range_crossfade_shadow", |s| {
        crossfade(s);
        lit(s);
    })
    .allow(
        42.0,
        "dithered pixels have no neighbours of their own surface to find the geometric normal from; it offsets the \
         shadow look-up",
    ),
    Scene::new("render_layers", |s| {
        s.floor();
        for (x, layer) in [(-1.5, 0), (0.0, 1), (1.5, 2)] {
            let ball = s.mesh(Sphere::new(0.7), red(), Transform::from_xyz(x, 0.7, 0.0));
            s.world()
                .entity_mut(ball)
                .insert(RenderLayers::layer(layer));
        }
        s.sun(true);
        s.default_camera((ambient(), RenderLayers::from_layers(&[0, 2])));
    })
    .nightly(),
    Scene::new("nan_position", |s| {
        s.floor();
        let mut mesh = Sphere::new(0.8).mesh().uv(48, 24);
        if let Some(VertexAttributeValues::Float32x3(positions)) =
            mesh.attribute_mut(Mesh::ATTRIBUTE_POSITION)
        {
            positions[600] = [f32::NAN; 3];
        }
        let ball = s.mesh(mesh, red(), Transform::from_xyz(0.0, 0.8, 0.0));
        s.world().entity_mut(ball).insert(NoFrustumCulling);
        lit(s);
    }),
    Scene::new("zero_normals", |s| {
        s.floor();
        broken_normals(s, [0.0; 3]);
        lit(s);
    })
    .nightly(),
    Scene::new("nan_normals", |s| {
        s.floor();
        broken_normals(s, [f32::NAN; 3]);
        lit(s);
    })
    .allow(
        25.0,
        "Bevy makes NaN pixels of NaN normals, lean takes them for +Y",
    ),
];

fn red() -> StandardMaterial {
    material((0.8, 0.2, 0.15), 0.0, 0.5)
}

fn lit(s: &mut SceneBuilder) {
    s.sun(true);
    s.default_camera(ambient());
}

fn unshadowed(s: &mut SceneBuilder) {
    s.sun(false);
    s.default_camera(ambient());
}

/// Balls that cross-fade into boxes.
fn crossfade(s: &mut SceneBuilder) {
    s.floor();
    for (mesh, start, end) in [
        (Mesh::from(Sphere::new(0.8)), 0.0..0.0, 4.0..8.0),
        (Cuboid::from_length(1.2).into(), 4.0..8.0, 50.0..60.0),
    ] {
        for x in [-1.5, 1.5] {
            let entity = s.mesh(mesh.clone(), red(), Transform::from_xyz(x, 0.8, 0.0));
            s.world().entity_mut(entity).insert(VisibilityRange {
                start_margin: start.clone(),
                end_margin: end.clone(),
                use_aabb: false,
            });
        }
    }
}

/// A bent column with two joints, the upper one turned. Returns the upper joint.
pub fn skinned(s: &mut SceneBuilder) -> Entity {
    let mut mesh = Mesh::from(Cylinder::new(0.4, 2.0).mesh().segments(20));
    let Some(VertexAttributeValues::Float32x3(positions)) =
        mesh.attribute(Mesh::ATTRIBUTE_POSITION)
    else {
        panic!("a built cylinder has positions");
    };
    let weights: Vec<[f32; 4]> = positions
        .iter()
        .map(|p| {
            let upper = (p[1] * 0.5 + 0.5).clamp(0.0, 1.0);
            [1.0 - upper, upper, 0.0, 0.0]
        })
        .collect();
    let joints = vec![[0u16, 1, 0, 0]; weights.len()];
    mesh.insert_attribute(
        Mesh::ATTRIBUTE_JOINT_INDEX,
        VertexAttributeValues::Uint16x4(joints),
    );
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights);

    let inverse_bindposes = s.add(SkinnedMeshInverseBindposes::from(vec![
        Mat4::from_translation(Vec3::Y),
        Mat4::IDENTITY,
    ]));
    let lower = s.spawn(Transform::from_xyz(-0.5, 0.0, 0.0));
    let upper = s.spawn((
        Transform::from_xyz(0.0, 1.0, 0.0).with_rotation(Quat::from_rotation_z(-1.1)),
        ChildOf(lower),
    ));
    let column = s.mesh(mesh, red(), Transform::default());
    s.world().entity_mut(column).insert((
        SkinnedMesh {
            inverse_bindposes,
            joints: vec![lower, upper],
        },
        NoFrustumCulling,
    ));
    upper
}

/// A ball with two morph targets: one flattens it, the other pulls it to the right. Returns the ball.
pub fn morphed(s: &mut SceneBuilder) -> Entity {
    let mut mesh = Sphere::new(0.8).mesh().uv(48, 24);
    let Some(VertexAttributeValues::Float32x3(positions)) =
        mesh.attribute(Mesh::ATTRIBUTE_POSITION)
    else {
        panic!("a built sphere has positions");
    };
    let target = |f: fn(Vec3) -> Vec3| {
        positions.iter().map(move |p| {
            let p = Vec3::from_array(*p);
            MorphAttributes::new(f(p), Vec3::ZERO, Vec3::ZERO)
        })
    };
    let targets = target(|p| Vec3::new(0.0, -p.y, 0.0))
        .chain(target(|p| Vec3::new(p.x.max(0.0) * 2.0, 0.0, 0.0)))
        .collect();
    mesh.set_morph_targets(targets);
    let ball = s.mesh(mesh, red(), Transform::from_xyz(0.0, 0.8, 0.0));
    s.world().entity_mut(ball).insert(MeshMorphWeights::Value {
        weights: vec![0.5, 0.8],
    });
    ball
}

/// 256 boxes of one mesh and four materials, on a floor.
fn instances<B: Bundle>(s: &mut SceneBuilder, extra: fn() -> B) {
    s.floor();
    let mesh = s.add::<Mesh>(Cuboid::from_length(0.3));
    let materials = [
        (0.8, 0.2, 0.15),
        (0.2, 0.5, 0.8),
        (0.3, 0.7, 0.4),
        (0.9, 0.8, 0.3),
    ]
    .map(|color| s.add::<StandardMaterial>(material(color, 0.0, 0.5)));
    for i in 0..256 {
        let (x, z) = ((i % 16) as f32, (i / 16) as f32);
        let position = Vec3::new(x * 0.45 - 3.4, 0.15 + 0.1 * (i % 7) as f32, z * 0.45 - 3.4);
        s.spawn((
            Mesh3d(mesh.clone()),
            MeshMaterial3d(materials[i % 4].clone()),
            Transform::from_translation(position),
            extra(),
        ));
    }
}

/// A helix of lines or points.
fn wires(s: &mut SceneBuilder, topology: PrimitiveTopology) {
    let helix = |i: u32| {
        let angle = i as f32 * 0.08;
        Vec3::new(angle.cos(), 0.2 + i as f32 * 0.004, angle.sin())
    };
    let positions: Vec<Vec3> = (0..400).map(helix).collect();
    let normals = vec![Vec3::Y; positions.len()];
    let mesh = Mesh::new(topology, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals);
    s.mesh(mesh, red(), Transform::default());
}

/// Two balls, one intact and one with some broken normals.
fn broken_normals(s: &mut SceneBuilder, normal: [f32; 3]) {
    let mut mesh = Sphere::new(0.8).mesh().uv(48, 24);
    s.mesh(mesh.clone(), red(), Transform::from_xyz(-1.2, 0.8, 0.0));
    if let Some(VertexAttributeValues::Float32x3(normals)) =
        mesh.attribute_mut(Mesh::ATTRIBUTE_NORMAL)
    {
        for broken in normals.iter_mut().skip(500).step_by(3).take(80) {
            *broken = normal;
        }
    }
    s.mesh(mesh, red(), Transform::from_xyz(1.2, 0.8, 0.0));
}
