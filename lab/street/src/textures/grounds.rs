//! Textures of the ground.

use bevy::prelude::*;

use super::{
    Tile,
    noise::{hash, octaves, smoothstep},
    texture::{Texel, tile},
};

/// 8 m of asphalt with puddles.
pub fn asphalt(images: &mut Assets<Image>, size: u32) -> Tile {
    tile(images, size, 8.0, |uv| {
        let water = smoothstep(0.49, 0.54, octaves(uv, 3, 3, 7));
        let damp = smoothstep(0.36, 0.5, octaves(uv, 3, 3, 7));
        let grain = octaves(uv, 96, 3, 11);
        let dry = 0.05 + 0.05 * grain + 0.02 * octaves(uv, 8, 3, 3);
        let color = Vec3::new(1.0, 1.0, 1.05) * dry * (1.0 - 0.55 * damp);
        Texel {
            color,
            roughness: 0.62.lerp(0.3, damp).lerp(0.03, water),
            height: 0.006 * grain * (1.0 - water),
        }
    })
}

/// 2 m of slabs, 50 cm each.
pub fn paving(images: &mut Assets<Image>, size: u32) -> Tile {
    tile(images, size, 2.0, |uv| {
        let place = uv * 4.0;
        let slab = hash(place.floor().as_uvec2(), 5);
        let to_edge = (place.fract() - 0.5).abs().max_element();
        let joint = smoothstep(0.475, 0.495, to_edge);
        let grain = octaves(uv, 48, 3, 17);
        let damp = smoothstep(0.4, 0.7, octaves(uv, 4, 4, 23));
        let grey = (0.1 + 0.06 * slab + 0.05 * grain) * (1.0 - 0.6 * joint) * (1.0 - 0.35 * damp);
        Texel {
            color: Vec3::new(1.05, 1.0, 0.95) * grey,
            roughness: (0.55 + 0.2 * grain - 0.36 * damp).max(0.12),
            height: 0.002 * grain - 0.008 * joint,
        }
    })
}
