//! Every property of `StandardMaterial` that the G-buffer carries.

use bevy::{
    light::AmbientLight,
    math::Affine2,
    mesh::{UvChannel, VertexAttributeValues},
    pbr::ParallaxMappingMethod,
    prelude::*,
    render::render_resource::TextureFormat,
};

use super::{
    Scene, SceneBuilder,
    build::{ambient, material},
};

pub const SCENES: &[Scene] = &[
    Scene::new("base_color_texture", |s| {
        let checker = s.checker([230, 60, 40, 255], [40, 90, 200, 255]);
        samples(
            s,
            StandardMaterial {
                base_color: Color::srgb(0.9, 1.0, 0.8),
                base_color_texture: Some(checker),
                ..default()
            },
        );
    })
    .nightly(),
    Scene::new("normal_map", |s| normal_map(s, false))
    .nightly(),
    Scene::new("normal_map_flipped_y", |s| normal_map(s, true)),
    Scene::new("metallic_roughness_texture", |s| {
        let texture = s.image(64, TextureFormat::Rgba8Unorm, |u, v| {
            [0, (u * 255.0) as u8, (v * 255.0) as u8, 255]
        });
        samples(
            s,
            StandardMaterial {
                base_color: Color::srgb(0.9, 0.7, 0.4),
                metallic: 1.0,
                perceptual_roughness: 1.0,
                metallic_roughness_texture: Some(texture),
                ..default()
            },
        );
    }),
    Scene::new("occlusion_texture", |s| {
        let texture = s.image(64, TextureFormat::Rgba8Unorm, |u, _| {
            [(u * 255.0) as u8, 255, 255, 255]
        });
        s.samples(StandardMaterial {
            base_color: Color::srgb(0.8, 0.8, 0.8),
            occlusion_texture: Some(texture),
            ..default()
        });
        s.default_camera(AmbientLight {
            brightness: 1500.0,
            ..default()
        });
    }),
    Scene::new("parallax_occlusion", |s| {
        parallax(s, ParallaxMappingMethod::Occlusion)
    })
    .nightly(),
    Scene::new("parallax_relief", |s| {
        parallax(s, ParallaxMappingMethod::Relief { max_steps: 5 })
    }),
    Scene::new("alpha_mask", |s| holes(s, AlphaMode::Mask(0.5), false)),
    Scene::new("alpha_to_coverage", |s| {
        holes(s, AlphaMode::AlphaToCoverage, false)
    }),
    Scene::new("alpha_mask_shadow", |s| {
        holes(s, AlphaMode::Mask(0.5), true)
    })
    .nightly(),
    Scene::new("double_sided", |s| backs(s, true, false, true))
    .nightly(),
    Scene::new("double_sided_normal_map", |s| backs(s, true, true, false)),
    Scene::new("double_sided_normal_map_shadow", |s| {
        backs(s, true, true, true)
    })
    .allow(
        25.0,
        "Bevy offsets its shadow look-up along the normal of the front face even on the back of a mesh with tangents, \
         so that backs shadow themselves; lean offsets towards the viewer",
    )
    .nightly(),
    Scene::new("cull_none_single_sided", |s| backs(s, false, false, true)),
    Scene::new("uv_transform", |s| {
        let checker = s.checker([240, 200, 60, 255], [60, 60, 90, 255]);
        samples(
            s,
            StandardMaterial {
                base_color_texture: Some(checker),
                uv_transform: Affine2::from_scale_angle_translation(
                    Vec2::new(0.6, 0.3),
                    0.5,
                    Vec2::new(0.2, 0.1),
                ),
                ..default()
            },
        );
    }),
    Scene::new("vertex_colors", |s| {
        s.floor();
        let mut mesh = Sphere::new(1.0).mesh().uv(48, 24);
        let colors: Vec<[f32; 4]> = positions(&mesh)
            .iter()
            .map(|p| [0.5 + 0.5 * p[0], 0.5 + 0.5 * p[1], 0.5 + 0.5 * p[2], 1.0])
            .collect();
        mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, colors);
        s.mesh(mesh, Color::WHITE, Transform::from_xyz(0.0, 1.0, 0.0));
        s.sun(true);
        s.default_camera(ambient());
    }),
    Scene::new("second_uvs", |s| {
        let checker = s.checker([230, 60, 40, 255], [240, 240, 220, 255]);
        s.floor();
        s.mesh(
            cube_with_second_uvs(),
            StandardMaterial {
                base_color_texture: Some(checker),
                base_color_channel: UvChannel::Uv1,
                ..default()
            },
            Transform::from_xyz(0.0, 0.8, 0.0),
        );
        s.sun(true);
        s.default_camera(ambient());
    }),
    Scene::new("extreme_albedos", |s| {
        grid(s, 8, |i| {
            const ALBEDOS: [[f32; 3]; 8] = [
                [0.0, 0.0, 0.0],
                [1.0, 1.0, 1.0],
                [0.02, 0.02, 0.02],
                [0.06, 0.03, 0.01],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [0.0, 0.0, 1.0],
                [1.0, 1.0, 0.0],
            ];
            StandardMaterial {
                base_color: Color::srgb_from_array(ALBEDOS[i]),
                perceptual_roughness: 0.7,
                ..default()
            }
        })
    }),
    Scene::new("albedo_out_of_range", |s| {
        grid(s, 4, |i| StandardMaterial {
            base_color: Color::linear_rgb([2.0, 1.0, -0.5, 0.5][i], 0.5, [0.2, 4.0, 0.4, -1.0][i]),
            ..default()
        })
    }),
    Scene::new("metallic_out_of_range", |s| {
        grid(s, 4, |i| {
            material((0.8, 0.6, 0.3), [-0.5, 0.0, 1.0, 2.0][i], 0.4)
        })
    })
    .nightly(),
    Scene::new("roughness_out_of_range", |s| {
        grid(s, 4, |i| {
            material((0.8, 0.6, 0.3), 0.5, [-0.5, 0.0, 1.0, 2.0][i])
        })
    })
    .nightly(),
    Scene::new("metallic_roughness_steps", |s| {
        grid(s, 8, |i| {
            material((0.8, 0.6, 0.3), (i % 4) as f32 / 3.0, 0.1 + 0.1 * i as f32)
        })
    })
    .nightly(),
];

pub(super) fn red() -> StandardMaterial {
    material((0.8, 0.2, 0.15), 0.0, 0.5)
}

/// [`SceneBuilder::samples`] in sun and ambient light.
fn samples(s: &mut SceneBuilder, material: StandardMaterial) {
    s.samples(material);
    s.sun(true);
    s.default_camera(ambient());
}

fn normal_map(s: &mut SceneBuilder, flip_normal_map_y: bool) {
    let bumps = s.bumps();
    samples(
        s,
        StandardMaterial {
            base_color: Color::srgb(0.7, 0.65, 0.6),
            perceptual_roughness: 0.4,
            normal_map_texture: Some(bumps),
            flip_normal_map_y,
            ..default()
        },
    );
}

fn parallax(s: &mut SceneBuilder, parallax_mapping_method: ParallaxMappingMethod) {
    let depth = s.tiled_image(128, TextureFormat::Rgba8Unorm, |u, v| {
        let wave = |x: f32| (x * 5.0 * std::f32::consts::TAU).sin();
        [(127.0 + 127.0 * wave(u) * wave(v)) as u8; 4]
    });
    let checker = s.checker([230, 160, 90, 255], [90, 60, 40, 255]);
    samples(
        s,
        StandardMaterial {
            base_color_texture: Some(checker),
            depth_map: Some(depth),
            parallax_depth_scale: 0.15,
            parallax_mapping_method,
            max_parallax_layer_count: 32.0,
            ..default()
        },
    );
}

/// A checkerboard with low alpha on every other square, seen from both sides.
fn holes(s: &mut SceneBuilder, alpha_mode: AlphaMode, shadows: bool) {
    let checker = s.checker([230, 60, 40, 255], [40, 90, 200, 40]);
    s.samples(StandardMaterial {
        base_color_texture: Some(checker),
        alpha_mode,
        double_sided: true,
        cull_mode: None,
        ..default()
    });
    s.sun(shadows);
    s.default_camera(ambient());
}

/// Cards without culling, from the front and from behind.
fn backs(s: &mut SceneBuilder, double_sided: bool, normal_map: bool, shadows: bool) {
    s.floor();
    let bumps = s.bumps();
    let thin = StandardMaterial {
        double_sided,
        cull_mode: None,
        normal_map_texture: normal_map.then_some(bumps),
        ..red()
    };
    let mut card = Mesh::from(Rectangle::new(1.6, 1.6));
    if normal_map {
        card.generate_tangents()
            .expect("a rectangle has all that tangents need");
    }
    for (x, angle) in [(-1.8, 0.3), (0.0, 3.4), (1.8, 2.6)] {
        s.mesh(
            card.clone(),
            thin.clone(),
            Transform::from_xyz(x, 0.9, 0.0).with_rotation(Quat::from_rotation_y(angle)),
        );
    }
    s.sun(shadows);
    s.default_camera(ambient());
}

/// Balls in two rows.
fn grid(s: &mut SceneBuilder, count: usize, material: impl Fn(usize) -> StandardMaterial) {
    s.floor();
    for i in 0..count {
        let (column, row) = ((i % 4) as f32, (i / 4) as f32);
        s.mesh(
            Sphere::new(0.55).mesh().uv(48, 24),
            material(i),
            Transform::from_xyz(column * 1.3 - 1.95, 0.55, 0.9 - row * 1.5),
        );
    }
    s.sun(true);
    s.default_camera(ambient());
}

fn positions(mesh: &Mesh) -> Vec<[f32; 3]> {
    match mesh.attribute(Mesh::ATTRIBUTE_POSITION) {
        Some(VertexAttributeValues::Float32x3(positions)) => positions.clone(),
        _ => panic!("a built mesh has positions"),
    }
}

/// A cube whose second UVs are the first, swapped and halved.
pub fn cube_with_second_uvs() -> Mesh {
    let mut mesh = Mesh::from(Cuboid::from_length(1.4));
    let Some(VertexAttributeValues::Float32x2(uvs)) = mesh.attribute(Mesh::ATTRIBUTE_UV_0) else {
        panic!("a built cuboid has UVs");
    };
    let second: Vec<[f32; 2]> = uvs.iter().map(|uv| [uv[1] * 0.5, uv[0] * 0.5]).collect();
    mesh.insert_attribute(Mesh::ATTRIBUTE_UV_1, second);
    mesh
}
