//! The bit table of the packed G-buffer: twin of `layout.wgsl`, under the same names.
//!
//! | word | target | bits, low to high |
//! |---|---|---|
//! | 0 | [`SURFACE_FORMAT`] | albedo R 7, G 8, B 7 (sRGB curve), metallic 5, material occlusion 5 |
//! | 1 | [`NORMAL_FORMAT`] | octahedral normal 12 + 12 (stored + 1: 0 means no geometry), perceptual roughness 8 |
//!
//! Choices, with what they cost (`tests/layout.rs` measures and bounds each figure):
//!
//! - **sRGB curve for albedo.** Over inputs uniform in sRGB, RMS error in 1/255 of an sRGB step for 7 bits: sRGB 0.58,
//!   gamma 2.0 0.60, gamma 2.2 0.60, linear 2.25; largest: 1.00, 1.41, 1.21, 12.75. With it, the green of an
//!   8-bit sRGB texture is stored without any error.
//! - **4095 codes an axis, not 4096**, so that 0 is a code: axes, walls and floors are exact.
//! - **Best of four** rounding for the normal: mean error 0.0195°, largest 0.0395°, against 0.0256° and 0.0656° for
//!   rounding each axis on its own.
//! - Values that cannot be stored are clamped; NaN becomes 0, a normal without a direction becomes +Y.

use bevy::{
    math::{Vec2, Vec2Swizzles, Vec3, Vec3Swizzles},
    render::render_resource::TextureFormat,
};

/// Format of the target that holds albedo, metallic and material occlusion.
pub const SURFACE_FORMAT: TextureFormat = TextureFormat::R32Uint;
/// Format of the target that holds normal and roughness.
pub const NORMAL_FORMAT: TextureFormat = TextureFormat::R32Uint;
/// Bytes a pixel of the base targets, depth not counted.
pub const BASE_BYTES_PER_PIXEL: u32 = 8;

const ALBEDO_R_MAX: f32 = 127.0;
const ALBEDO_G_MAX: f32 = 255.0;
const ALBEDO_B_MAX: f32 = 127.0;
const FIVE_BIT_MAX: f32 = 31.0;
const ROUGHNESS_MAX: f32 = 255.0;

/// Steps of one octahedral axis. Even, so that 0 is a code and the axes and flat floors are stored exactly.
pub const NORMAL_STEPS: f32 = 4094.0;

/// Both words of a pixel that no mesh was drawn to.
pub const NO_GEOMETRY: u32 = 0;

/// What the base targets hold of one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Linear, 0 to 1.
    pub albedo: Vec3,
    /// 0 to 1.
    pub metallic: f32,
    /// Baked (material) visibility of ambient light, 0 to 1: 1 is open.
    pub occlusion: f32,
    /// World space, unit length.
    pub normal: Vec3,
    /// 0 to 1.
    pub perceptual_roughness: f32,
}

fn saturate_or_zero(x: f32) -> f32 {
    if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) }
}

fn quantize(x: f32, steps: f32) -> u32 {
    (saturate_or_zero(x) * steps + 0.5) as u32
}

/// Linear to sRGB-encoded (IEC 61966-2-1:1999).
pub fn srgb_from_linear(x: f32) -> f32 {
    if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * x.powf(1.0 / 2.4) - 0.055
    }
}

/// sRGB-encoded to linear (IEC 61966-2-1:1999).
pub fn linear_from_srgb(x: f32) -> f32 {
    if x <= 0.04045 {
        x / 12.92
    } else {
        ((x + 0.055) / 1.055).powf(2.4)
    }
}

/// Packs word 0. All inputs 0 to 1.
pub fn pack_surface(albedo: Vec3, metallic: f32, occlusion: f32) -> u32 {
    let r = quantize(srgb_from_linear(saturate_or_zero(albedo.x)), ALBEDO_R_MAX);
    let g = quantize(srgb_from_linear(saturate_or_zero(albedo.y)), ALBEDO_G_MAX);
    let b = quantize(srgb_from_linear(saturate_or_zero(albedo.z)), ALBEDO_B_MAX);
    let m = quantize(metallic, FIVE_BIT_MAX);
    let o = quantize(occlusion, FIVE_BIT_MAX);
    r | (g << 7) | (b << 15) | (m << 22) | (o << 27)
}

/// Linear albedo of word 0.
pub fn unpack_albedo(word: u32) -> Vec3 {
    Vec3::new(
        linear_from_srgb((word & 0x7f) as f32 / ALBEDO_R_MAX),
        linear_from_srgb(((word >> 7) & 0xff) as f32 / ALBEDO_G_MAX),
        linear_from_srgb(((word >> 15) & 0x7f) as f32 / ALBEDO_B_MAX),
    )
}

/// Metallic of word 0.
pub fn unpack_metallic(word: u32) -> f32 {
    ((word >> 22) & 0x1f) as f32 / FIVE_BIT_MAX
}

/// Material occlusion of word 0.
pub fn unpack_occlusion(word: u32) -> f32 {
    (word >> 27) as f32 / FIVE_BIT_MAX
}

fn sign_not_zero(x: f32) -> f32 {
    if x >= 0.0 { 1.0 } else { -1.0 }
}

/// Unit sphere to the square -1..1 (Cigolle et al. 2014, "A Survey of Efficient Representations for Independent
/// Unit Vectors").
pub fn octahedral_from_unit(n: Vec3) -> Vec2 {
    let p = n.truncate() / (n.x.abs() + n.y.abs() + n.z.abs());
    if n.z >= 0.0 {
        p
    } else {
        (1.0 - Vec2::new(p.y, p.x).abs()) * Vec2::new(sign_not_zero(p.x), sign_not_zero(p.y))
    }
}

/// Inverse of [`octahedral_from_unit`]; the result is not normalised.
pub fn direction_from_octahedral(p: Vec2) -> Vec3 {
    let z = 1.0 - p.x.abs() - p.y.abs();
    if z >= 0.0 {
        return p.extend(z);
    }
    let folded =
        (1.0 - Vec2::new(p.y, p.x).abs()) * Vec2::new(sign_not_zero(p.x), sign_not_zero(p.y));
    folded.extend(z)
}

fn unit_from_codes(codes: Vec2) -> Vec3 {
    direction_from_octahedral(codes * (2.0 / NORMAL_STEPS) - 1.0).normalize()
}

/// A unit vector from `n`. What has no direction (zero, NaN, infinite) becomes +Y.
pub fn unit_or_up(n: Vec3) -> Vec3 {
    let largest = n.abs().max_element();
    if !n.is_finite() || largest < 1e-30 {
        return Vec3::Y;
    }
    (n / largest).normalize()
}

/// The metric of the octahedral map at the unit vector `n`, at codes `p` in -1..1: the squared angle that a step
/// (dx, dy) makes is proportional to `x dx² + 2 y dx dy + z dy²`. (The map's two partial derivatives have length √2;
/// their parts along `n` do not turn it.)
pub fn octahedral_metric(n: Vec3, p: Vec2) -> Vec3 {
    let s = Vec2::new(sign_not_zero(p.x), sign_not_zero(p.y));
    // Upper half: ∂/∂x = (1, 0, -sx), ∂/∂y = (0, 1, -sy). Lower half, folded: -sx (0, sy, 1), -sy (sx, 0, 1).
    let along = if n.z >= 0.0 {
        n.truncate() - s * n.z
    } else {
        -s * (s.yx() * n.yx() + n.z)
    };
    Vec3::new(
        2.0 - along.x * along.x,
        s.x * s.y - along.x * along.y,
        2.0 - along.y * along.y,
    )
}

/// Packs word 1 from a normal of any length and a perceptual roughness 0 to 1. Of the four codes around the exact
/// point it takes the one whose direction is nearest (after the "precise" rounding of Cigolle et al. 2014, with the
/// metric in place of four decodes).
pub fn pack_normal(normal: Vec3, perceptual_roughness: f32) -> u32 {
    let n = unit_or_up(normal);
    let p = octahedral_from_unit(n);
    let exact = (p * 0.5 + 0.5) * NORMAL_STEPS;
    let low = exact
        .floor()
        .clamp(Vec2::ZERO, Vec2::splat(NORMAL_STEPS - 1.0));
    let metric = octahedral_metric(n, p);
    let mut best = low;
    // Larger than any squared step to a corner of the cell.
    let mut best_distance = 16.0;
    for i in 0..4 {
        let codes = low + Vec2::new((i & 1) as f32, (i >> 1) as f32);
        let step = codes - exact;
        let distance = metric.x * step.x * step.x
            + 2.0 * metric.y * step.x * step.y
            + metric.z * step.y * step.y;
        if distance < best_distance {
            best_distance = distance;
            best = codes;
        }
    }
    let (x, y) = (best.x as u32 + 1, best.y as u32 + 1);
    x | (y << 12) | (quantize(perceptual_roughness, ROUGHNESS_MAX) << 24)
}

/// World-space unit normal of word 1. Meaningless for [`NO_GEOMETRY`].
pub fn unpack_normal(word: u32) -> Vec3 {
    let code = Vec2::new((word & 0xfff) as f32, ((word >> 12) & 0xfff) as f32);
    unit_from_codes(code - 1.0)
}

/// Perceptual roughness of word 1.
pub fn unpack_roughness(word: u32) -> f32 {
    (word >> 24) as f32 / ROUGHNESS_MAX
}

/// Packs both words.
pub fn pack(surface: &Surface) -> [u32; 2] {
    [
        pack_surface(surface.albedo, surface.metallic, surface.occlusion),
        pack_normal(surface.normal, surface.perceptual_roughness),
    ]
}

/// Unpacks both words.
pub fn unpack(words: [u32; 2]) -> Surface {
    Surface {
        albedo: unpack_albedo(words[0]),
        metallic: unpack_metallic(words[0]),
        occlusion: unpack_occlusion(words[0]),
        normal: unpack_normal(words[1]),
        perceptual_roughness: unpack_roughness(words[1]),
    }
}
