//! Every kind of material, on every shape.

use bevy::{
    camera::{ClearColorConfig, ScalingMode},
    material::OpaqueRendererMethod,
    prelude::*,
};
use kit::{
    headless::Picture,
    lean::{build, judge, report, set_lean, settled},
    own_process::in_own_process,
    scenes::LEAST_PSNR,
};

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

/// A card, a ball and a mirrored ball of each kind of material, each in its own cell, cover the same pixels with the same mean colour as in
/// forward.
#[test]
fn no_mesh_is_lost() {
    in_own_process(|| {
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

        // Number and mean colour of the pixels drawn to. The corner of a cell is background, which is dithered.
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
    });
}
