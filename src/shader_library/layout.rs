//! The bit table of the packed G-buffer.
//!
//! | word | target | bits, low to high |
//! |---|---|---|
//! | 0 | [`SURFACE_FORMAT`] | albedo R 7, G 7, B 7 (roots); their exponent (3 codes), metallic and occlusion (340) 10; mesh normal 1 |
//! | 1 | [`NORMAL_FORMAT`] | octahedral normal 12 + 12 (stored + 1: 0 means no geometry), perceptual roughness 8 |
//! | with any optional | [`VALID_MASK_FORMAT`] | optional targets written, as bits of [`GBufferTargets`](crate::gbuffer::GBufferTargets), 4; light of a lightmap in the emissive target: incident 1, reflected 1 |
//! | optional | [`EMISSIVE_FORMAT`] | light with a shared exponent: `layout/light.wgsl` |
//! | optional | [`SPECIALIZATION_FORMAT`] | specular constant, shading model, flags: `layout/specialization.wgsl` |
//! | optional | [`MOTION_FORMAT`] | motion vector: `layout/motion.wgsl` |
//! | optional | [`VISIBILITY_MASK_FORMAT`] | one bit per render layer; see [`visibility_mask`] |
//!
//! Choices and their costs (`tests/shaders/layout.rs` measures and bounds each figure):
//!
//! - **Square roots for albedo** (gamma 2). RMS error of 7 bits over inputs uniform in sRGB, in 1/255 of sRGB: square root 0.60,
//!   sRGB's own curve 0.58, gamma 2.2 0.60, linear 2.25; largest error: 1.43, 1.00, 1.21, 12.75. The small gain of sRGB's curve was
//!   not visible in an image (51.1 dB against 51.5 dB on the benches' boxes scene), and its powers cost 7% of the raster pass there
//!   (3.60 ms against 3.37 ms, H200, 4K).
//! - **A shared exponent for the roots**: a colour whose brightest channel is at most 1/12 is stored 12 times as bright, one up to 1/3
//!   3 times (limits between two codes, so that brighter colours never have darker codes). Strong light magnifies the steps of dark
//!   albedo; they stay within 1.4 to 7.6% of the brightest channel down to 1/256. Equal channels have equal codes: grey stays grey.
//!   RMS error over grey uniform in sRGB, over such colours, of FlightHelmet's textures, and of those of twelve levels of free games:
//!   0.395, 0.543, 0.354, 0.303; with limits of 1/4 and 1/16 0.407, 0.557, 0.347, 0.311; with 1/2 and 1/8 0.388, 0.523, 0.374, 0.310.
//! - **21 codes for metallic; for material occlusion 72 with a metallic of 0, 40 with 1, else 12**: most surfaces are metal or not, and
//!   their textures have occlusion, which hides little light of metals. Multiples of 1/20, usual in materials, are exact metallic
//!   values. With multiples of 1/10 the benches' boxes, half of which have a metallic of 1/4 or 3/4, were at 43.3 dB from forward
//!   instead of 55.9.
//! - **A flag for shading normals that tell the mesh's**: shadow bias follows those. In forward it follows the interpolated normal.
//!   It follows the normal from depth where a normal map turns the shading normal further from that than the triangle is, and the
//!   surface is more than two pixels wide.
//! - **4095 codes per axis, not 4096**, so that 0 is a code: axes, walls and floors are exact.
//! - **Best of four** rounding for the normal: mean error 0.0195°, largest 0.0395°, against 0.0209° and 0.0592° for rounding each
//!   axis on its own.
//! - Values that cannot be stored are clamped; NaN becomes 0, a normal without a direction becomes +Y.

use bevy::{camera::visibility::RenderLayers, math::Vec3, render::render_resource::TextureFormat};

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
/// Largest specular constant that is stored.
pub const LARGEST_REFLECTANCE: f32 = 2.0;
/// Bytes per pixel of the base targets, without depth.
pub const BASE_BYTES_PER_PIXEL: u32 = 8;

/// One bit per layer, and one shared by all from [`SHARED_LAYERS`] on, so that none is lost. Shaders read the same word.
pub fn visibility_mask(layers: &RenderLayers) -> u32 {
    layers
        .iter()
        .fold(0, |mask, layer| mask | 1 << layer.min(SHARED_LAYERS))
}

/// Both words of a pixel without geometry.
pub const NO_GEOMETRY: u32 = 0;

/// Rounds `x`, clamped to 0..1, to the nearest of `steps + 1` codes; NaN becomes 0.
pub fn quantize(x: f32, steps: f32) -> u32 {
    let valid = if x.is_nan() { 0.0 } else { x };
    (valid.clamp(0.0, 1.0) * steps + 0.5) as u32
}

/// Rounds the square roots of `color`, clamped to 0..1, to the nearest of `steps + 1` codes; a colour with a NaN becomes black.
pub fn quantize_roots(color: Vec3, steps: Vec3) -> [u32; 3] {
    let valid = if (color.x + color.y + color.z).is_nan() {
        Vec3::ZERO
    } else {
        color.clamp(Vec3::ZERO, Vec3::ONE)
    };
    let root = Vec3::new(valid.x.sqrt(), valid.y.sqrt(), valid.z.sqrt());
    (root * steps + 0.5).to_array().map(|code| code as u32)
}
