//! Pictures that are hard to meter.

use bevy::math::{UVec2, Vec3};

use kit::random::Random;

/// Makes pixel `i` of `count`.
pub type Texel = fn(i: usize, count: usize, random: &mut Random) -> Vec3;

pub const EASY: [(&str, Texel); 6] = [
    ("flat", |_, _, _| Vec3::new(0.5, 0.25, 2.0)),
    ("noise", |_, _, random| {
        Vec3::new(random.unit(), random.unit(), random.unit()) * 4.0
    }),
    ("1e-7 to 65504", |i, count, _| {
        let t = i as f32 / count as f32;
        Vec3::splat(1e-7 * (65504.0f32 / 1e-7).powf(t))
    }),
    ("half black, half 65504", |i, count, _| {
        Vec3::splat(if 2 * i < count { 0.0 } else { 65504.0 })
    }),
    ("one bright pixel in black", |i, count, _| {
        Vec3::splat(if i == count / 2 { 60000.0 } else { 0.0 })
    }),
    ("black", |_, _, _| Vec3::ZERO),
];

/// Pictures with pixels that are NaN, infinite, negative or denormal.
pub const HOSTILE: [(&str, Texel); 4] = [
    ("not a number here and there", |_, _, random| {
        let mut color = Vec3::splat(random.range(0.0, 2.0));
        if random.below(3) == 0 {
            color[random.below(3)] = f32::NAN;
        }
        color
    }),
    ("infinite here and there", |_, _, random| {
        let mut color = Vec3::splat(random.range(0.0, 2.0));
        if random.below(50) == 0 {
            color[random.below(3)] = f32::INFINITY;
        }
        if random.below(50) == 0 {
            color[random.below(3)] = f32::NEG_INFINITY;
        }
        color
    }),
    ("negative and denormal", |_, _, random| {
        Vec3::new(
            random.range(-3.0, 3.0),
            random.range(-6e-5, 6e-5),
            random.range(-1e-7, 1e-7),
        )
    }),
    ("any bits", |_, _, random| {
        Vec3::from_array([(); 3].map(|()| half::f16::from_bits(random.bits() as u16).to_f32()))
    }),
];

pub fn picture(size: UVec2, texel: Texel) -> Vec<Vec3> {
    let count = size.element_product() as usize;
    let mut random = Random::new(u64::from(size.x) << 32 | u64::from(size.y));
    (0..count).map(|i| texel(i, count, &mut random)).collect()
}
