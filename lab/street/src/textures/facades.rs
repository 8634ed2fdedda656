//! Textures of walls.

use bevy::prelude::*;

use super::{
    Tile,
    noise::{hash, octaves, smoothstep},
    texture::{Texel, image, places_of, tile},
};

/// 2 m of bricks in running bond, 25 by 8.3 cm each. The material adds their colour.
pub fn bricks(images: &mut Assets<Image>, size: u32) -> Tile {
    tile(images, size, 2.0, |uv| {
        let row = (uv.y * 24.0).floor();
        let place = Vec2::new(uv.x * 8.0 + 0.5 * (row % 2.0), uv.y * 24.0);
        let brick = hash(
            UVec2::new(place.x.floor() as u32 % 8, place.y.floor() as u32),
            1,
        );
        let to_edge = (place.fract() - 0.5).abs();
        let mortar = smoothstep(0.455, 0.485, to_edge.x).max(smoothstep(0.39, 0.46, to_edge.y));
        let grain = octaves(uv, 64, 3, 29);
        let shade = 0.55 + 0.35 * brick + 0.2 * grain;
        let color = Vec3::splat(shade).lerp(Vec3::splat(0.5 + 0.2 * grain), mortar);
        Texel {
            color,
            roughness: 0.6 + 0.3 * grain,
            height: 0.003 * grain - 0.01 * mortar,
        }
    })
}

/// A room behind a window: curtains, a lamp, shelves.
pub fn window(images: &mut Assets<Image>, number: u64) -> Handle<Image> {
    let mut random = fastrand::Rng::with_seed(0x0057_1d05 + number);
    let curtain = 0.08 + 0.3 * random.f32();
    let lamp = Vec2::new(0.25 + 0.5 * random.f32(), 0.2 + 0.2 * random.f32());
    let shelf = 0.55 + 0.3 * random.f32();
    let warm = Vec3::new(1.0, 0.42 + 0.2 * random.f32(), 0.1 + 0.2 * random.f32());
    let size = UVec2::new(64, 128);
    let texels = places_of(size)
        .map(|uv| {
            let to_lamp = (uv - lamp) * Vec2::new(0.5, 1.0);
            let mut light = 0.25 + 0.75 * (-14.0 * to_lamp.length_squared()).exp();
            let on_shelf = uv.y > shelf;
            let book = hash(
                UVec2::new((uv.x * 14.0) as u32, (uv.y * 5.0) as u32),
                number as u32,
            );
            if on_shelf {
                light *= 0.25 + 0.5 * book;
            }
            let at_side = 0.5 - (uv.x - 0.5).abs();
            if at_side < curtain {
                let folds = 0.6 + 0.4 * (uv.x * 70.0).sin();
                light = 0.3 * folds * (1.0 - 0.5 * uv.y);
            }
            (warm * light).extend(1.0)
        })
        .collect();
    images.add(image(size, texels, true))
}
