//! Leaves, alpha-masked.

use bevy::prelude::*;

use super::texture::{image, places};

/// A bunch of leaves on twigs that grow from the middle below.
pub fn bunch(images: &mut Assets<Image>, size: u32) -> Handle<Image> {
    let mut random = fastrand::Rng::with_seed(77);
    // Position, direction, length and brightness of each leaf.
    let leaves: Vec<(Vec2, Vec2, f32, f32)> = (0..60)
        .map(|_| {
            let angle = core::f32::consts::PI * (0.1 + 0.8 * random.f32());
            let along = Vec2::new(angle.cos(), -angle.sin());
            let far = 0.12 + 0.74 * random.f32();
            let turn = angle + 1.2 * (random.f32() - 0.5);
            (
                Vec2::new(0.5, 0.98) + along * far * Vec2::new(0.52, 0.95),
                Vec2::new(turn.cos(), -turn.sin()),
                0.07 + 0.05 * random.f32(),
                0.5 + 0.5 * random.f32(),
            )
        })
        .collect();
    let texels = places(size)
        .map(|uv| {
            let mut texel = Vec4::new(0.04, 0.09, 0.02, 0.0);
            for (middle, along, length, shade) in &leaves {
                let from = uv - *middle;
                let place = Vec2::new(from.dot(*along), from.dot(along.perp())) / *length;
                let half_width = 0.38 * (1.0 - place.x * place.x).max(0.0);
                if place.y.abs() < half_width {
                    let vein = 1.0 - 0.35 * (1.0 - place.y.abs() / half_width).powi(6);
                    let green = Vec3::new(0.1, 0.25, 0.05) * *shade * vein;
                    texel = green.extend(1.0);
                }
            }
            texel
        })
        .collect();
    images.add(image(UVec2::splat(size), texels, true))
}
