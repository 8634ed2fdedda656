//! Cosines that rounding moves out of range, and vectors that it leaves without length, cause no NaN.

use bevy::{
    asset::RenderAssetUsages,
    camera::ScalingMode,
    light::RectLight,
    mesh::{Indices, PrimitiveTopology, VertexAttributeValues},
    prelude::*,
};
use kit::{
    hdr::light,
    headless::{Headless, Picture},
    lean::{build, judge, report, set_lean, settled, show},
    own_process::in_own_process,
    random::Random,
    scenes::{LEAST_PSNR, SceneBuilder, build::ambient},
};

const SIZE: UVec2 = UVec2::splat(32);

/// Height of the view, in metres.
const HEIGHT: f32 = 4.0;

/// Cards of these materials in stripes half a tile wide, in front of an orthographic camera turned by `rotation`. All of their normals are
/// `normal` in view space.
fn stripes(
    s: &mut SceneBuilder,
    rotation: Quat,
    normal: Vec3,
    materials: impl IntoIterator<Item = StandardMaterial>,
) {
    let width = HEIGHT / 8.0;
    for (i, material) in materials.into_iter().enumerate() {
        let (low, high) = (
            Vec2::new(i as f32 * width, 0.0) - HEIGHT / 2.0,
            Vec2::new((i + 1) as f32 * width, HEIGHT) - HEIGHT / 2.0,
        );
        let corners = [
            low,
            Vec2::new(high.x, low.y),
            high,
            Vec2::new(low.x, high.y),
        ];
        let mesh = Mesh::new(
            PrimitiveTopology::TriangleList,
            RenderAssetUsages::default(),
        )
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_POSITION,
            corners.map(|corner| corner.extend(0.0)).to_vec(),
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![normal; 4])
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_TANGENT,
            vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4],
        )
        .with_inserted_indices(Indices::U16(vec![0, 1, 2, 0, 2, 3]));
        s.mesh(mesh, material, Transform::from_rotation(rotation));
    }
    s.camera(
        Transform::from_rotation(rotation).with_translation(rotation * Vec3::Z * 10.0),
        Projection::Orthographic(OrthographicProjection {
            scaling_mode: ScalingMode::FixedVertical {
                viewport_height: HEIGHT,
            },
            ..OrthographicProjection::default_3d()
        }),
    );
}

/// One material of each kind, each next to plain ones.
fn materials() -> [StandardMaterial; 8] {
    let plain = || StandardMaterial {
        emissive: LinearRgba::rgb(0.02, 0.05, 0.02),
        perceptual_roughness: 0.6,
        ..Color::srgb(0.6, 0.5, 0.4).into()
    };
    [
        plain(),
        StandardMaterial {
            clearcoat: 1.0,
            ..plain()
        },
        plain(),
        StandardMaterial {
            anisotropy_strength: 0.7,
            ..plain()
        },
        plain(),
        StandardMaterial {
            diffuse_transmission: 0.7,
            thickness: 0.2,
            ..plain()
        },
        plain(),
        StandardMaterial {
            reflectance: 0.9,
            ..plain()
        },
    ]
}

/// The first two have axes along those of the world, the others random ones.
fn rotations() -> impl Iterator<Item = Quat> {
    let mut random = Random::new(11);
    let others: Vec<Quat> = (0..6)
        .map(|_| {
            let mut part = || random.range(-1.0, 1.0);
            Quat::from_xyzw(part(), part(), part(), part()).normalize()
        })
        .collect();
    let axes = [
        Quat::IDENTITY,
        Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2),
    ];
    // In the last of these, forward's own N·V is above 1.
    axes.into_iter().chain([others[0], others[5]])
}

/// The light is finite, and the picture is the same for each rotation of the scene, which changes only rounding.
fn compare(
    headless: &mut Headless,
    name: &str,
    least_psnr: f64,
    scene: impl Fn(&mut SceneBuilder, Quat),
) {
    let mut first: Option<Picture> = None;
    report(rotations().enumerate().flat_map(|(i, rotation)| {
        show(headless, |s| scene(s, rotation));
        set_lean(headless, true);
        let picture = settled(headless);
        let broken = light(headless).not_finite();
        let name = format!("{name}_{i}");
        println!("{name}: {broken} pixels are not finite");
        let finite = match broken {
            0 => Ok(()),
            _ => Err(format!("{name}: {broken} pixels are not finite")),
        };
        let first = first.get_or_insert_with(|| picture.clone());
        [finite, judge(&name, first, &picture, least_psnr)]
    }));
}

#[test]
#[ignore = "nightly: three more cases of rounding"]
fn turned_cards_are_lit_alike() {
    in_own_process(|| {
        let headless = &mut Headless::new(SIZE);
        cards_seen_from_straight_before(headless);
        cards_under_a_rectangular_light(headless);
        light_from_straight_ahead(headless);
        lights_on_the_surface(headless);
    });
}

/// N·V is slightly above 1.
fn cards_seen_from_straight_before(headless: &mut Headless) {
    compare(headless, "straight_before", LEAST_PSNR, |s, rotation| {
        stripes(s, rotation, Vec3::Z, materials());
        s.spawn((
            DirectionalLight {
                illuminance: 3_000.0,
                ..default()
            },
            Transform::from_rotation(rotation),
        ));
    });
}

/// The camera is in the middle of a ball whose normals point at it: N·V is slightly above 1 in many pixels. Each tile has coated surfaces,
/// so that the same shader lights the others.
#[test]
fn plain_surfaces_beside_coated_ones() {
    in_own_process(|| {
        let mut headless = build(UVec2::splat(96), |s| {
            let [plain, coated, ..] = materials();
            let mut ball: Mesh = Sphere::new(10.0).mesh().uv(64, 32);
            ball.invert_winding().expect("it has indices");
            if let Some(VertexAttributeValues::Float32x3(normals)) =
                ball.attribute_mut(Mesh::ATTRIBUTE_NORMAL)
            {
                for normal in normals {
                    *normal = normal.map(|x| -x);
                }
            }
            s.mesh(ball, plain, Transform::default());
            for i in 0..14 {
                let x = (i as f32 - 6.5) * 0.6;
                let bar = Cuboid::new(0.06, 12.0, 0.06);
                s.mesh(bar, coated.clone(), Transform::from_xyz(x, 0.0, -5.0));
            }
            s.camera(Transform::default(), ambient());
        });
        set_lean(&mut headless, true);
        settled(&mut headless);
        let broken = light(&mut headless).not_finite();
        println!("{broken} pixels are not finite");
        assert_eq!(broken, 0);
    });
}

/// The lobes of rectangular lights are rotated towards the viewer, and from straight above that rotation is arbitrary.
fn cards_under_a_rectangular_light(headless: &mut Headless) {
    compare(headless, "rectangular", LEAST_PSNR, |s, rotation| {
        stripes(s, rotation, Vec3::Z, materials());
        s.spawn((
            RectLight {
                intensity: 40_000.0,
                width: 2.0,
                height: 1.0,
                ..default()
            },
            Transform::from_rotation(rotation).with_translation(rotation * Vec3::Z * 2.0),
        ));
    });
}

/// Normals point away from the viewer and light comes from behind, so that L is -V; and from the viewer's side, through the surface.
fn light_from_straight_ahead(headless: &mut Headless) {
    compare(headless, "straight_ahead", LEAST_PSNR, |s, rotation| {
        stripes(s, rotation, Vec3::NEG_Z, materials());
        for turn in [0.0, core::f32::consts::PI] {
            s.spawn((
                DirectionalLight {
                    illuminance: 3_000.0,
                    ..default()
                },
                Transform::from_rotation(rotation * Quat::from_rotation_y(turn)),
            ));
        }
    });
}

/// The surface passes through the centre of each of these: for a few pixels rounding decides the direction of their light.
fn lights_on_the_surface(headless: &mut Headless) {
    compare(headless, "on_the_surface", 20.0, |s, rotation| {
        stripes(s, rotation, Vec3::Z, materials());
        let pixel = HEIGHT / SIZE.y as f32;
        for i in 0..8 {
            let middle = Vec2::splat(0.5) + Vec2::new(4.0 * i as f32 + 1.0, 9.0);
            let place = (middle * pixel - HEIGHT / 2.0).extend(0.0);
            s.spawn((
                PointLight {
                    radius: 0.1,
                    intensity: 20_000.0,
                    ..default()
                },
                Transform::from_translation(rotation * place),
            ));
        }
    });
}
