//! Textures of signs and awnings.

use bevy::prelude::*;

use super::texture::{image, places_of};

/// Four letters of no script in a column: white strokes within a frame, on black.
pub fn letters(images: &mut Assets<Image>, number: u64) -> Handle<Image> {
    let mut random = fastrand::Rng::with_seed(0x51a5 + number);
    let mut strokes: Vec<(Vec2, Vec2)> = Vec::new();
    for letter in 0..4 {
        // On a grid of three by three points.
        let mut place = || {
            let at = Vec2::new(random.u32(0..3) as f32, random.u32(0..3) as f32) / 2.0;
            Vec2::new(0.24, letter as f32 + 0.2) + at * Vec2::new(0.52, 0.6)
        };
        for _ in 0..5 {
            let (from, to) = (place(), place());
            // Strokes are vertical or horizontal, except for one.
            let corner = Vec2::new(to.x, from.y);
            strokes.extend([(from, corner), (corner, to)]);
        }
        strokes.push((place(), place()));
    }
    let size = UVec2::new(64, 256);
    let texels = places_of(size)
        .map(|uv| {
            let place = uv * Vec2::new(1.0, 4.0);
            let stroke = strokes
                .iter()
                .map(|(from, to)| to_stroke(place, *from, *to))
                .fold(f32::INFINITY, f32::min);
            let edge = (place.x - 0.5).abs().max((place.y - 2.0).abs() - 1.5);
            let frame = (edge - 0.44).abs();
            let lit = 1.0 - ((stroke.min(frame) - 0.035) / 0.03).clamp(0.0, 1.0);
            Vec3::splat(0.06 + 0.94 * lit).extend(1.0)
        })
        .collect();
    images.add(image(size, texels, true))
}

fn to_stroke(place: Vec2, from: Vec2, to: Vec2) -> f32 {
    let along = to - from;
    let share = (place - from).dot(along) / along.length_squared().max(1e-6);
    place.distance(from + along * share.clamp(0.0, 1.0))
}

/// Stripes, 25 cm each, of an awning's colour and white.
pub fn stripes(images: &mut Assets<Image>) -> Handle<Image> {
    let size = UVec2::splat(32);
    let texels = places_of(size)
        .map(|uv| {
            let grey = if uv.x < 0.5 { 1.0 } else { 0.12 };
            Vec3::splat(grey).extend(1.0)
        })
        .collect();
    images.add(image(size, texels, true))
}
