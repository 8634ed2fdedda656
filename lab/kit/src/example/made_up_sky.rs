//! A procedural sky.

use bevy::{
    asset::RenderAssetUsages,
    prelude::*,
    render::render_resource::{
        Extent3d, TextureDimension, TextureFormat, TextureUsages, TextureViewDescriptor,
        TextureViewDimension,
    },
};
use half::f16;

/// A blue sky over brown ground, with one bright cloud.
pub fn made_up_sky() -> Image {
    const SIZE: u32 = 64;
    let mut data = Vec::with_capacity((SIZE * SIZE * 6 * 8) as usize);
    for face in 0..6 {
        for y in 0..SIZE {
            for x in 0..SIZE {
                let u = (x as f32 + 0.5) / SIZE as f32 * 2.0 - 1.0;
                let v = (y as f32 + 0.5) / SIZE as f32 * 2.0 - 1.0;
                let direction = match face {
                    0 => Vec3::new(1.0, -v, -u),
                    1 => Vec3::new(-1.0, -v, u),
                    2 => Vec3::new(u, 1.0, v),
                    3 => Vec3::new(u, -1.0, -v),
                    4 => Vec3::new(u, -v, 1.0),
                    _ => Vec3::new(-u, -v, -1.0),
                }
                .normalize();
                let texel = sky_color(direction).extend(1.0).to_array();
                data.extend(
                    texel
                        .map(f16::from_f32)
                        .map(f16::to_le_bytes)
                        .as_flattened(),
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
        RenderAssetUsages::default(),
    );
    image.texture_descriptor.usage |= TextureUsages::STORAGE_BINDING;
    image.texture_view_descriptor = Some(TextureViewDescriptor {
        dimension: Some(TextureViewDimension::Cube),
        ..default()
    });
    image
}

fn sky_color(direction: Vec3) -> Vec3 {
    let horizon = Vec3::new(0.85, 0.9, 1.0);
    let zenith = Vec3::new(0.25, 0.45, 0.9);
    let ground = Vec3::new(0.22, 0.19, 0.16);
    let cloud = direction.dot(Vec3::new(-0.5, 0.6, 0.6).normalize());
    let base = if direction.y >= 0.0 {
        horizon.lerp(zenith, direction.y.sqrt())
    } else {
        ground.lerp(horizon * 0.5, (1.0 + direction.y * 4.0).clamp(0.0, 1.0))
    };
    base + Vec3::splat(2.5) * ((cloud - 0.8) * 8.0).clamp(0.0, 1.0)
}
