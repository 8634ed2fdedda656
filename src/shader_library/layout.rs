//! The bit table of the packed G-buffer.
//!
//! | word | target | bits, low to high |
//! |---|---|---|
//! | 0 | [`SURFACE_FORMAT`] | albedo R 7, G 7, B 7 (roots), shared exponent 1, metallic (21 codes) and occlusion (24) 9, mesh normal 1 |
//! | 1 | [`NORMAL_FORMAT`] | octahedral normal 12 + 12 (stored + 1: 0 means no geometry), perceptual roughness 8 |
//! | with any optional | [`VALID_MASK_FORMAT`] | optional targets written, as bits of [`GBufferTargets`](crate::gbuffer::GBufferTargets) |
//! | optional | [`EMISSIVE_FORMAT`] | [shared-exponent light](light) |
//! | optional | [`SPECIALIZATION_FORMAT`] | [specular constant, shading model, flags](specialization) |
//! | optional | [`MOTION_FORMAT`] | [motion vector](motion) |
//! | optional | [`VISIBILITY_MASK_FORMAT`] | one bit per render layer; see [`visibility_mask`] |
//!
//! Choices and their costs (`tests/shaders/layout.rs` measures and bounds each figure):
//!
//! - **Square roots for albedo** (gamma 2). RMS error of 7 bits over inputs uniform in sRGB, in 1/255 of sRGB: square root 0.60,
//!   sRGB's own curve 0.58, gamma 2.2 0.60, linear 2.25; largest error: 1.43, 1.00, 1.21, 12.75. The small gain of sRGB's curve was
//!   not visible in an image (51.1 dB against 51.5 dB on the benches' boxes scene), and its powers cost 7% of the raster pass there
//!   (3.60 ms against 3.37 ms, H200, 4K).
//! - **A shared exponent for the roots**: a colour whose brightest channel is at most 1/16 is stored 16 times as bright. Strong light
//!   magnifies the steps of dark albedo; with the exponent they stay within 1.6 to 6.5% of the brightest channel down to 1/256. Equal
//!   channels have equal codes: grey stays grey.
//! - **21 codes for metallic, 24 for material occlusion**: multiples of 1/20, usual in materials, are exact metallic values. With
//!   multiples of 1/10 the benches' boxes, half of which have a metallic of 1/4 or 3/4, are at 43.3 dB from forward instead of 55.9.
//! - **A flag for normals without a normal map**: shadow bias follows them as it does in forward. With a map it follows the geometric
//!   normal, from depth.
//! - **4095 codes per axis, not 4096**, so that 0 is a code: axes, walls and floors are exact.
//! - **Best of four** rounding for the normal: mean error 0.0195°, largest 0.0395°, against 0.0209° and 0.0592° for rounding each
//!   axis on its own.
//! - Values that cannot be stored are clamped; NaN becomes 0, a normal without a direction becomes +Y.

pub mod light;
pub mod motion;
pub mod specialization;

use bevy::{
    camera::visibility::RenderLayers,
    math::{Vec2, Vec2Swizzles, Vec3, Vec3Swizzles},
    render::render_resource::TextureFormat,
};

/// Format of the target that holds albedo, metallic and material occlusion.
pub const SURFACE_FORMAT: TextureFormat = TextureFormat::R32Uint;
/// Format of the target that holds normal and roughness.
pub const NORMAL_FORMAT: TextureFormat = TextureFormat::R32Uint;
/// Format of the target that flags the optional targets with a word of the surface.
pub const VALID_MASK_FORMAT: TextureFormat = TextureFormat::R8Uint;
/// Format of the optional target that holds emitted light.
pub const EMISSIVE_FORMAT: TextureFormat = TextureFormat::R32Uint;
/// Format of the optional target that holds properties of a surface that are not at their defaults.
pub const SPECIALIZATION_FORMAT: TextureFormat = TextureFormat::R32Uint;
/// Format of the optional target that holds the motion of meshes that move or deform.
pub const MOTION_FORMAT: TextureFormat = TextureFormat::R32Uint;
/// Format of the optional target that holds the [`RenderLayers`] of a mesh.
pub const VISIBILITY_MASK_FORMAT: TextureFormat = TextureFormat::R32Uint;
/// The visibility mask of a mesh without `RenderLayers`: layer 0 alone.
pub const DEFAULT_VISIBILITY_MASK: u32 = 1;
/// First of the layers that share one bit of the visibility mask.
pub const SHARED_LAYERS: usize = 31;
/// Bytes per pixel of the base targets, without depth.
pub const BASE_BYTES_PER_PIXEL: u32 = 8;

/// Largest code of an albedo channel.
pub const ALBEDO_MAX: f32 = 127.0;
/// Largest code of metallic.
pub const METALLIC_MAX: f32 = 20.0;
/// Largest code of occlusion.
pub const OCCLUSION_MAX: f32 = 23.0;
/// Codes of occlusion per code of metallic.
pub const OCCLUSION_CODES: u32 = 24;
/// Flag in word 0: the shading normal is that of the mesh.
pub const MESH_NORMAL_BIT: u32 = 1 << 31;
/// Largest code of roughness.
pub const ROUGHNESS_MAX: f32 = 255.0;

/// Steps of one octahedral axis. Even, so that 0 is a code and the axes and flat floors are stored exactly.
pub const NORMAL_STEPS: f32 = 4094.0;
/// Half of [`NORMAL_STEPS`].
pub const HALF_STEPS: f32 = 2047.0;

/// One bit per layer, and one shared by all from [`SHARED_LAYERS`] on, so that none is lost. Shaders read the same word.
pub fn visibility_mask(layers: &RenderLayers) -> u32 {
    layers
        .iter()
        .fold(0, |mask, layer| mask | 1 << layer.min(SHARED_LAYERS))
}

/// Both words of a pixel without geometry.
pub const NO_GEOMETRY: u32 = 0;

/// Content of the base targets at one pixel.
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
    /// The shading normal is that of the mesh: no normal map changes it.
    pub has_mesh_normal: bool,
}

/// Rounds `x`, clamped to 0..1, to the nearest of `steps + 1` codes; NaN becomes 0.
pub(crate) fn quantize(x: f32, steps: f32) -> u32 {
    let valid = if x.is_nan() { 0.0 } else { x };
    (valid.clamp(0.0, 1.0) * steps + 0.5) as u32
}

/// Rounds the square roots of `color`, clamped to 0..1, to the nearest of `steps + 1` codes; a colour with a NaN becomes black.
pub(crate) fn quantize_roots(color: Vec3, steps: Vec3) -> [u32; 3] {
    let valid = if (color.x + color.y + color.z).is_nan() {
        Vec3::ZERO
    } else {
        color.clamp(Vec3::ZERO, Vec3::ONE)
    };
    let root = Vec3::new(valid.x.sqrt(), valid.y.sqrt(), valid.z.sqrt());
    (root * steps + 0.5).to_array().map(|code| code as u32)
}

/// Shared exponent of the roots of `albedo`, 0 or 1. Decided on linear values: float comparisons agree with the device, square roots
/// may not.
pub fn albedo_exponent(albedo: Vec3) -> u32 {
    u32::from(albedo.max_element() <= 0.0625)
}

/// Factor on albedo of this exponent: 1 or 16.
pub fn albedo_scale(exponent: u32) -> f32 {
    (1u32 << (4 * exponent)) as f32
}

/// Packs word 0. All inputs 0 to 1; a colour with a NaN becomes black.
pub fn pack_surface(albedo: Vec3, metallic: f32, occlusion: f32, has_mesh_normal: bool) -> u32 {
    let valid = if (albedo.x + albedo.y + albedo.z).is_nan() {
        Vec3::ZERO
    } else {
        albedo.clamp(Vec3::ZERO, Vec3::ONE)
    };
    let exponent = albedo_exponent(valid);
    let scaled = (valid * albedo_scale(exponent)).to_array();
    let [r, g, b] = scaled.map(|x| (x.sqrt() * ALBEDO_MAX + 0.5) as u32);
    let m = quantize(metallic, METALLIC_MAX);
    let o = quantize(occlusion, OCCLUSION_MAX);
    let mesh_normal = if has_mesh_normal { MESH_NORMAL_BIT } else { 0 };
    let rest = (exponent << 21) | ((m * OCCLUSION_CODES + o) << 22);
    r | (g << 7) | (b << 14) | rest | mesh_normal
}

/// Linear albedo of word 0.
pub fn unpack_albedo(word: u32) -> Vec3 {
    let codes = Vec3::new(
        (word & 0x7f) as f32,
        ((word >> 7) & 0x7f) as f32,
        ((word >> 14) & 0x7f) as f32,
    );
    let root = codes / ALBEDO_MAX;
    root * root / albedo_scale((word >> 21) & 1)
}

/// Code of metallic times [`OCCLUSION_CODES`], plus that of occlusion.
fn metallic_and_occlusion(word: u32) -> u32 {
    (word >> 22) & 0x1ff
}

/// Metallic of word 0.
pub fn unpack_metallic(word: u32) -> f32 {
    // A word that was not packed may hold a larger code.
    ((metallic_and_occlusion(word) / OCCLUSION_CODES) as f32 / METALLIC_MAX).min(1.0)
}

/// Material occlusion of word 0.
pub fn unpack_occlusion(word: u32) -> f32 {
    (metallic_and_occlusion(word) % OCCLUSION_CODES) as f32 / OCCLUSION_MAX
}

/// True if word 0 flags the normal in word 1 as that of the mesh.
pub fn unpack_has_mesh_normal(word: u32) -> bool {
    word & MESH_NORMAL_BIT != 0
}

fn sign_not_zero(x: f32) -> f32 {
    if x >= 0.0 { 1.0 } else { -1.0 }
}

/// Maps the square -1..1 to the octahedron (Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit
/// Vectors"); the result is not normalised.
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

/// True if quotients by a length are exact: small lengths would lose digits, and WGSL guarantees nothing above 2^126.
pub(crate) fn is_divisor(size: f32) -> bool {
    (1e-30..8e37).contains(&size)
}

/// Packs word 1 from a normal of any length and a perceptual roughness of 0 to 1. Of the four codes around the exact point it takes
/// the one nearest in direction: the "precise" rounding of Cigolle et al. 2014, by the metric of the map instead of four decodes.
/// Normals without a direction (zero, NaN, infinite or nearly so) become +Y, lit like a floor, so that no NaN reaches lighting.
pub fn pack_normal(normal: Vec3, perceptual_roughness: f32) -> u32 {
    let mut n = normal;
    let mut size = n.x.abs() + n.y.abs() + n.z.abs();
    // A NaN or infinite component makes the sum NaN or infinite.
    if !is_divisor(size) {
        n = Vec3::Y;
        size = 1.0;
    }
    // All octants are treated alike: on the octahedron's face of positive x and y, with the lower half folded out.
    let m = n.abs() / size;
    let is_upper = n.z >= 0.0;
    let across = if is_upper { m.xy() } else { m.yx() };
    let unfolded = if is_upper { across } else { 1.0 - across };
    let exact = unfolded * HALF_STEPS;
    let low = exact.floor().min(Vec2::splat(HALF_STEPS - 1.0));
    let f = exact - low;

    // A step (dx, dy) of codes rotates the direction by an angle whose square is proportional to
    // a dx² + 2 b dx dy + c dy²: the components of the map's derivatives (1, 0, -1) and (0, 1, -1) across the direction.
    let length_squared = m.length_squared();
    let along = across - m.z;
    let ac = 2.0 * length_squared - along * along;
    let b = length_squared - along.x * along.y;

    // Change of the squared error of `low` by one more code in x, in y or in both.
    let one = ac * (1.0 - 2.0 * f) - 2.0 * b * f.yx();
    let both = one.x + one.y + 2.0 * b;
    // One of the best even in a tie: on the diagonals of the octants three are equally good.
    let least = one.min_element().min(0.0);
    let more = if both <= least {
        Vec2::ONE
    } else if least == 0.0 {
        Vec2::ZERO
    } else if one.x <= one.y {
        Vec2::X
    } else {
        Vec2::Y
    };
    let code = low + more;

    let signed_code = HALF_STEPS + 1.0 + Vec2::select(n.xy().cmpge(Vec2::ZERO), code, -code);
    signed_code.x as u32
        | ((signed_code.y as u32) << 12)
        | (quantize(perceptual_roughness, ROUGHNESS_MAX) << 24)
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
        pack_surface(
            surface.albedo,
            surface.metallic,
            surface.occlusion,
            surface.has_mesh_normal,
        ),
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
        has_mesh_normal: unpack_has_mesh_normal(words[0]),
    }
}
