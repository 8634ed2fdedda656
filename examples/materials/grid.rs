//! The samples in rows and columns, and their light.

use bevy::{
    asset::RenderAssetUsages,
    image::ImageSampler,
    light::{CascadeShadowConfigBuilder, NotShadowReceiver},
    pbr::Lightmap,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_lean_deferred::prelude::*;
use kit::example::switch::SwitchedLight;

use crate::rows::{COLUMNS, ROWS, Shape, Textures};

/// Distance between two samples, in metres.
const SPACING: f32 = 1.0;
const RADIUS: f32 = 0.4;

/// Half the width and half the height of the grid, with a margin.
pub fn half_size() -> Vec2 {
    (Vec2::new(COLUMNS as f32, ROWS.len() as f32) * SPACING + 0.3) / 2.0
}

/// Height of a row's middle.
pub fn row_height(row: usize) -> f32 {
    ((ROWS.len() - 1) as f32 / 2.0 - row as f32) * SPACING
}

pub fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut images: ResMut<Assets<Image>>,
    mut standard: ResMut<Assets<StandardMaterial>>,
    mut extended: ResMut<Assets<ExtendedStandardMaterial>>,
) {
    let shapes = [
        (Shape::Ball, Sphere::new(RADIUS).mesh().uv(64, 32)),
        (Shape::Leaf, Circle::new(RADIUS).into()),
        (Shape::ThinSlab, slab(0.02)),
        (Shape::ThickSlab, slab(0.3)),
        (Shape::Bust, bust()),
    ];
    let shapes = shapes.map(|(shape, mesh)| (shape, meshes.add(with_all_attributes(mesh))));
    let mesh_of = |shape: Shape| {
        let mut shapes = shapes.iter();
        let found = shapes.find_map(|(other, mesh)| (*other == shape).then_some(mesh));
        found.cloned().unwrap_or_default()
    };
    let textures = Textures {
        specular: images.add(specular_texture()),
        lightmap: images.add(lightmap()),
    };
    for (row, kind) in ROWS.iter().enumerate() {
        for column in 0..COLUMNS {
            let sample = (kind.sample)(column, &textures);
            let x = (column as f32 - (COLUMNS - 1) as f32 / 2.0) * SPACING;
            let mut entity = commands.spawn((
                Mesh3d(mesh_of(sample.shape)),
                Transform::from_xyz(x, row_height(row), -kind.depth),
            ));
            if sample.extension == ShadingExtension::None {
                entity.insert(MeshMaterial3d(standard.add(sample.base)));
            } else {
                entity.insert(MeshMaterial3d(extended.add(ExtendedStandardMaterial {
                    base: sample.base,
                    extension: sample.extension,
                })));
            }
            if sample.ignores_shadows {
                entity.insert(NotShadowReceiver);
            }
            if let Some(bicubic_sampling) = sample.lightmap {
                entity.insert(Lightmap {
                    image: textures.lightmap.clone(),
                    bicubic_sampling,
                    ..default()
                });
            }
        }
        if kind.has_bar {
            commands.spawn((
                Mesh3d(meshes.add(Cuboid::new(COLUMNS as f32 * SPACING, 0.1, 0.1))),
                MeshMaterial3d(standard.add(Color::srgb(0.2, 0.2, 0.2))),
                Transform::from_xyz(0.0, row_height(row) + 0.5, 0.5),
            ));
        }
        if kind.has_light_behind {
            for x in [-3.0, 0.0, 3.0] {
                commands.spawn((
                    PointLight {
                        intensity: 150_000.0,
                        range: 3.0,
                        ..default()
                    },
                    Transform::from_xyz(x, row_height(row), -1.2),
                ));
            }
        }
    }
}

pub fn spawn_lights(mut commands: Commands) {
    commands.spawn((
        SwitchedLight,
        DirectionalLight {
            illuminance: 4_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        CascadeShadowConfigBuilder {
            num_cascades: 1,
            maximum_distance: 60.0,
            ..default()
        }
        .build(),
        Transform::from_xyz(0.4, 1.0, 0.8).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

/// A slab of this thickness, turned so that its side is visible.
fn slab(thickness: f32) -> Mesh {
    let side = 1.6 * RADIUS;
    Mesh::from(Cuboid::new(side, side, thickness)).rotated_by(Quat::from_rotation_y(0.6))
}

/// A head on shoulders.
fn bust() -> Mesh {
    let ball = |radius: f32, at: [f32; 3], scale: [f32; 3]| {
        let ball = Sphere::new(radius * RADIUS).mesh().uv(48, 24);
        let at = Vec3::from_array(at) * RADIUS;
        ball.scaled_by(Vec3::from_array(scale)).translated_by(at)
    };
    let parts = [
        // Skull, jaw, nose, brow, ears, neck, shoulders.
        ball(0.58, [0.0, 0.42, 0.0], [0.82, 1.0, 0.95]),
        ball(0.36, [0.0, 0.05, 0.14], [0.9, 0.85, 0.9]),
        ball(0.13, [0.0, 0.3, 0.55], [0.7, 1.4, 1.0]),
        ball(0.3, [0.0, 0.5, 0.36], [1.2, 0.35, 0.6]),
        ball(0.15, [-0.5, 0.35, -0.02], [0.3, 1.1, 0.8]),
        ball(0.15, [0.5, 0.35, -0.02], [0.3, 1.1, 0.8]),
        ball(0.26, [0.0, -0.35, -0.04], [1.0, 1.5, 1.0]),
        ball(0.75, [0.0, -0.9, -0.05], [1.15, 0.45, 0.6]),
    ];
    let turned = Quat::from_rotation_y(-0.45);
    let all = parts.into_iter().reduce(|mut all, part| {
        if let Err(error) = all.merge(&part) {
            error!("the bust lacks a part: {error}");
        }
        all
    });
    all.map_or_else(
        || Sphere::new(RADIUS).into(),
        |mesh| mesh.rotated_by(turned),
    )
}

/// Adds tangents, and the UVs of lightmaps.
fn with_all_attributes(mut mesh: Mesh) -> Mesh {
    if let Some(uvs) = mesh.attribute(Mesh::ATTRIBUTE_UV_0).cloned() {
        mesh.insert_attribute(Mesh::ATTRIBUTE_UV_1, uvs);
    }
    match mesh.clone().with_generated_tangents() {
        Ok(mesh) => mesh,
        Err(error) => {
            error!("a sample has no tangents: {error}");
            mesh
        }
    }
}

/// Stripes of full and no reflectance, in the alpha channel.
fn specular_texture() -> Image {
    image(TextureFormat::Rgba8Unorm, |u, _| {
        let stripe = ((u * 16.0) as u32).is_multiple_of(2);
        [255, 255, 255, if stripe { 255 } else { 0 }]
    })
}

/// A checkerboard of warm and cool light.
fn lightmap() -> Image {
    image(TextureFormat::Rgba8UnormSrgb, |u, v| {
        if ((u * 16.0) as u32 + (v * 8.0) as u32).is_multiple_of(2) {
            [255, 190, 110, 255]
        } else {
            [40, 70, 140, 255]
        }
    })
}

/// An image of a function of u and v in 0..1.
fn image(format: TextureFormat, texel: impl Fn(f32, f32) -> [u8; 4]) -> Image {
    const SIZE: u32 = 64;
    let data = (0..SIZE * SIZE)
        .flat_map(|i| {
            let center = |x: u32| (x as f32 + 0.5) / SIZE as f32;
            texel(center(i % SIZE), center(i / SIZE))
        })
        .collect();
    let mut image = Image::new(
        Extent3d {
            width: SIZE,
            height: SIZE,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        data,
        format,
        RenderAssetUsages::default(),
    );
    image.sampler = ImageSampler::linear();
    image
}
