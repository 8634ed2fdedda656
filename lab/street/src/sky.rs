//! The sky: dim, with the glow of a town at the horizon and a moon, and slightly hazy air.

use bevy::{
    asset::RenderAssetUsages,
    camera::Exposure,
    light::CascadeShadowConfigBuilder,
    prelude::*,
    render::render_resource::{
        Extent3d, TextureDimension, TextureFormat, TextureUsages, TextureViewDescriptor,
        TextureViewDimension,
    },
};
use half::f16;

/// Background colour of the sky.
pub const COLOR: Color = Color::linear_rgb(0.006, 0.008, 0.02);

/// Exposure of a camera at night.
pub const EXPOSURE: Exposure = Exposure { ev100: 4.6 };

/// Components of a camera beside its transform: the exposure at night, and fog.
pub fn air() -> impl Bundle {
    (
        EXPOSURE,
        DistanceFog {
            color: Color::linear_rgb(0.012, 0.013, 0.022),
            falloff: FogFalloff::Exponential { density: 0.012 },
            ..default()
        },
    )
}

/// Light from the sky, for a camera.
pub fn light(images: &mut Assets<Image>) -> GeneratedEnvironmentMapLight {
    GeneratedEnvironmentMapLight {
        environment_map: images.add(cube_map()),
        intensity: 1.0,
        ..default()
    }
}

pub fn spawn_moon(commands: &mut Commands) {
    commands.spawn((
        DirectionalLight {
            color: Color::linear_rgb(0.55, 0.7, 1.0),
            illuminance: 2.0,
            shadow_maps_enabled: true,
            ..default()
        },
        CascadeShadowConfigBuilder {
            num_cascades: 2,
            maximum_distance: 40.0,
            ..default()
        }
        .build(),
        Transform::from_xyz(0.25, 1.0, 0.45).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

/// In candela per square metre.
fn color(direction: Vec3) -> Vec3 {
    let zenith = Vec3::new(0.05, 0.07, 0.16);
    let rim = Vec3::new(0.8, 0.45, 0.22);
    let ground = Vec3::new(0.16, 0.1, 0.06);
    match direction.y >= 0.0 {
        true => rim.lerp(zenith, direction.y.powf(0.35)),
        false => ground,
    }
}

fn cube_map() -> Image {
    const SIZE: u32 = 64;
    let mut data = Vec::with_capacity((SIZE * SIZE * 6 * 8) as usize);
    for face in 0..6 {
        for y in 0..SIZE {
            for x in 0..SIZE {
                let [u, v] = [x, y].map(|i| (i as f32 + 0.5) / SIZE as f32 * 2.0 - 1.0);
                let direction = match face {
                    0 => Vec3::new(1.0, -v, -u),
                    1 => Vec3::new(-1.0, -v, u),
                    2 => Vec3::new(u, 1.0, v),
                    3 => Vec3::new(u, -1.0, -v),
                    4 => Vec3::new(u, -v, 1.0),
                    _ => Vec3::new(-u, -v, -1.0),
                };
                let texel = color(direction.normalize()).extend(1.0).to_array();
                data.extend(
                    texel
                        .map(f16::from_f32)
                        .into_iter()
                        .flat_map(f16::to_le_bytes),
                );
            }
        }
    }
    let mut image = Image::new(
        Extent3d {
            width: SIZE,
            height: SIZE,
            depth_or_array_layers: 6,
        },
        TextureDimension::D2,
        data,
        TextureFormat::Rgba16Float,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.texture_descriptor.usage |= TextureUsages::STORAGE_BINDING;
    image.texture_view_descriptor = Some(TextureViewDescriptor {
        dimension: Some(TextureViewDimension::Cube),
        ..default()
    });
    image
}
