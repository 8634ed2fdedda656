//! Noise that repeats.

use bevy::prelude::*;

/// Smooth noise from 0 to 1, with `period` cells per side over u and v in 0..1 (value noise: Perlin 1985, "An Image
/// Synthesizer", with values at the corners of a grid instead of slopes).
fn cells(uv: Vec2, period: u32, seed: u32) -> f32 {
    let place = uv * period as f32;
    let cell = place.floor();
    let share = place - cell;
    let share = share * share * (3.0 - 2.0 * share);
    let corner = |x: i32, y: i32| {
        let at = (cell.as_ivec2() + IVec2::new(x, y)).rem_euclid(IVec2::splat(period as i32));
        hash(at.as_uvec2(), seed)
    };
    let below = corner(0, 0).lerp(corner(1, 0), share.x);
    let above = corner(0, 1).lerp(corner(1, 1), share.x);
    below.lerp(above, share.y)
}

/// Sum of octaves of noise, each half as strong as the one before. 0 to 1.
pub fn octaves(uv: Vec2, period: u32, count: u32, seed: u32) -> f32 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for octave in 0..count {
        let weight = 0.5_f32.powi(octave as i32);
        sum += weight * cells(uv, period << octave, seed + octave);
        weights += weight;
    }
    sum / weights
}

/// A number from 0 to 1 for each cell of a grid (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering": PCG).
pub fn hash(cell: UVec2, seed: u32) -> f32 {
    let pcg = |x: u32| {
        let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        (word >> 22) ^ word
    };
    let bits = pcg(cell.x.wrapping_add(pcg(cell.y.wrapping_add(pcg(seed)))));
    (bits >> 8) as f32 / (1 << 24) as f32
}

/// Smooth step from 0 at `low` to 1 at `high`.
pub fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let share = ((x - low) / (high - low)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}
