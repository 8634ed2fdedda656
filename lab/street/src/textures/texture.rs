//! Builds images with all their mip levels from functions.

use bevy::{
    asset::RenderAssetUsages,
    image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};

use super::Tile;

/// Value of a tiling texture's function at one point.
pub struct Texel {
    pub color: Vec3,
    pub roughness: f32,
    /// In metres.
    pub height: f32,
}

/// Three images of a function of u and v in 0..1, `metres` per side.
pub fn tile(
    images: &mut Assets<Image>,
    size: u32,
    metres: f32,
    texel: impl Fn(Vec2) -> Texel,
) -> Tile {
    let texels: Vec<Texel> = places(size).map(texel).collect();
    let at = |x: u32, y: u32| &texels[((y % size) * size + x % size) as usize];
    let step = metres / size as f32;
    let normal = |i: u32| {
        let (x, y) = (i % size, i / size);
        let slope = |[ax, ay]: [u32; 2], [bx, by]: [u32; 2]| {
            (at(ax, ay).height - at(bx, by).height) / (2.0 * step)
        };
        // V points down in the picture, and up along the surface.
        let across = slope([x + 1, y], [x + size - 1, y]);
        let up = slope([x, y + size - 1], [x, y + 1]);
        let normal = Vec3::new(-across, -up, 1.0).normalize() * 0.5 + 0.5;
        normal.extend(1.0)
    };
    let color = texels.iter().map(|texel| texel.color.extend(1.0)).collect();
    let roughness = texels
        .iter()
        .map(|texel| Vec4::new(0.0, texel.roughness, 0.0, 1.0))
        .collect();
    let normals = (0..size * size).map(normal).collect();
    Tile {
        color: images.add(image(UVec2::splat(size), color, true)),
        roughness: images.add(image(UVec2::splat(size), roughness, false)),
        normal: images.add(image(UVec2::splat(size), normals, false)),
    }
}

/// Centres of the texels, row by row.
pub fn places(size: u32) -> impl Iterator<Item = Vec2> {
    places_of(UVec2::splat(size))
}

pub fn places_of(size: UVec2) -> impl Iterator<Item = Vec2> {
    let place = move |x: u32, y: u32| (UVec2::new(x, y).as_vec2() + 0.5) / size.as_vec2();
    (0..size.y).flat_map(move |y| (0..size.x).map(move |x| place(x, y)))
}

/// A repeating image of linear values, with mip levels that average four texels each.
pub fn image(size: UVec2, texels: Vec<Vec4>, is_srgb: bool) -> Image {
    let levels = size.min_element().ilog2() + 1;
    let mut level = (size, texels);
    let mut data = Vec::new();
    for _ in 0..levels {
        data.extend(level.1.iter().flat_map(|texel| encoded(*texel, is_srgb)));
        level = halved(level.0, &level.1);
    }
    let mut image = Image::new_uninit(
        Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        match is_srgb {
            true => TextureFormat::Rgba8UnormSrgb,
            false => TextureFormat::Rgba8Unorm,
        },
        RenderAssetUsages::RENDER_WORLD,
    );
    image.texture_descriptor.mip_level_count = levels;
    image.data = Some(data);
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        mag_filter: ImageFilterMode::Linear,
        min_filter: ImageFilterMode::Linear,
        mipmap_filter: ImageFilterMode::Linear,
        anisotropy_clamp: 8,
        ..default()
    });
    image
}

fn encoded(texel: Vec4, is_srgb: bool) -> [u8; 4] {
    match is_srgb {
        true => {
            Srgba::from(LinearRgba::from_vec4(texel.clamp(Vec4::ZERO, Vec4::ONE))).to_u8_array()
        }
        false => (texel.clamp(Vec4::ZERO, Vec4::ONE) * 255.0)
            .round()
            .to_array()
            .map(|channel| channel as u8),
    }
}

fn halved(size: UVec2, texels: &[Vec4]) -> (UVec2, Vec<Vec4>) {
    let half = (size / 2).max(UVec2::ONE);
    let at = |x: u32, y: u32| texels[(y.min(size.y - 1) * size.x + x.min(size.x - 1)) as usize];
    let texels = (0..half.x * half.y)
        .map(|i| {
            let (x, y) = (2 * (i % half.x), 2 * (i / half.x));
            let sum = at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1);
            sum / 4.0
        })
        .collect();
    (half, texels)
}
