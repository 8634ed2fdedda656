//! Tells differences between device and twin that are only rounding between two codes from others.

use bevy::math::{DVec2, DVec3, Vec3};
use kit::reference::shader_library::layout::{NORMAL_STEPS, Surface, albedo_limit};

use super::{
    ALBEDO_CODE_MAX, METALLIC_CODE_MAX, accuracy::direction_from_octahedral, normal_codes,
    occlusion_code_max, surface_codes,
};

/// Largest distance from the middle between two codes, in steps, at which device and twin may round differently.
const TIE: f64 = 1e-4;
/// The same for normals, whose nearest code is chosen by sums of squares in f32.
const NORMAL_TIE: f64 = 2e-3;

/// Places in `surface_codes`.
const METALLIC: usize = 4;
const OCCLUSION: usize = 5;

/// Distance of `value` among the codes 0 to `max` from the middle between two, in steps.
fn distance_to_tie(value: f64, max: u32) -> f64 {
    ((value.clamp(0.0, 1.0) * f64::from(max)).fract() - 0.5).abs()
}

/// Difference between the distances of two words' directions to `normal`, in steps.
fn distance_to_normal_tie(normal: Vec3, word: u32, other: u32) -> f64 {
    let n = normal.as_dvec3().try_normalize().unwrap_or(DVec3::Y);
    let distance = |word| {
        let (x, y) = normal_codes(word);
        let codes = DVec2::new(f64::from(x), f64::from(y)) - 1.0;
        direction_from_octahedral(codes * (2.0 / f64::from(NORMAL_STEPS)) - 1.0).distance(n)
    };
    (distance(word) - distance(other)).abs() / (2.0 / f64::from(NORMAL_STEPS))
}

/// Fields of `device` and `twin`, both packed from `input`, that differ though `input` is no tie; `ties` counts the others.
pub fn differences(
    input: &Surface,
    device: [u32; 2],
    twin: [u32; 2],
    ties: &mut usize,
) -> Vec<String> {
    let codes = [device, twin].map(|words| surface_codes(words[0]));
    // The exponent is chosen by comparisons, so it has no ties.
    let limit = f64::from(albedo_limit(codes[1][3]));
    let root = |x: f32| (f64::from(x).clamp(0.0, 1.0) / limit).sqrt();
    let values = [
        (root(input.albedo.x), ALBEDO_CODE_MAX),
        (root(input.albedo.y), ALBEDO_CODE_MAX),
        (root(input.albedo.z), ALBEDO_CODE_MAX),
        (0.0, 1),
        (f64::from(input.metallic), METALLIC_CODE_MAX),
        (
            f64::from(input.occlusion),
            occlusion_code_max(codes[1][METALLIC]),
        ),
        (0.0, 1),
    ];
    let mut found = Vec::new();
    let mut compare = |name: String, device: u32, twin: u32, tie: f64, tolerance: f64| {
        if device != twin && tie <= tolerance {
            *ties += 1;
        } else if device != twin {
            found.push(format!(
                "{name}: {device} != {twin}, {tie} steps from a tie, {input:?}"
            ));
        }
    };
    for (i, (value, max)) in values.into_iter().enumerate() {
        // Occlusion may have other steps if metallic is a tie.
        if i == OCCLUSION && codes[0][METALLIC] != codes[1][METALLIC] {
            continue;
        }
        let tie = distance_to_tie(value, max);
        compare(format!("field {i}"), codes[0][i], codes[1][i], tie, TIE);
    }
    let code = |words: [u32; 2]| words[1] & 0xff_ffff;
    let tie = distance_to_normal_tie(input.normal, device[1], twin[1]);
    compare("normal".into(), code(device), code(twin), tie, NORMAL_TIE);
    let tie = distance_to_tie(f64::from(input.perceptual_roughness), 255);
    compare("roughness".into(), device[1] >> 24, twin[1] >> 24, tie, TIE);
    found
}
