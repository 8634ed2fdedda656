//! Packing of the base targets. The crate's `layout.rs` has the bit table.

pub mod light;
pub mod motion;
pub mod specialization;

use bevy::math::{Vec2, Vec2Swizzles, Vec3, Vec3Swizzles};
pub use bevy_lean_deferred::shader_library::layout::NO_GEOMETRY;
use bevy_lean_deferred::shader_library::layout::quantize;

/// Largest code of an albedo channel.
pub const ALBEDO_MAX: f32 = 127.0;
/// Largest albedo with exponent 1: halfway between codes 73 and 74 of exponent 0, so that what is brighter is not stored darker.
pub const ALBEDO_LIMIT: f32 = 5402.25 / 16129.0;
/// Largest code of metallic.
pub const METALLIC_MAX: f32 = 20.0;
/// Codes of occlusion for a metallic of 0.
pub const DIELECTRIC_CODES: u32 = 72;
/// Codes of occlusion for a metallic of 1.
pub const METAL_CODES: u32 = 40;
/// Codes of occlusion for each other metallic.
pub const MIXED_CODES: u32 = 12;
/// First code of metallic and occlusion for other metallics: after those for 0 and for 1.
pub const FIRST_MIXED: u32 = DIELECTRIC_CODES + METAL_CODES;
/// Codes of metallic and occlusion for each exponent of albedo.
pub const METALLIC_AND_OCCLUSION_CODES: u32 = 340;
/// Flag in word 0: the shading normal is that of the mesh.
pub const MESH_NORMAL_BIT: u32 = 1 << 31;
/// Largest code of roughness.
pub const ROUGHNESS_MAX: f32 = 255.0;

/// Bits of the valid mask with the content of the emissive target; 0 for emitted light alone.
pub const LIGHTMAP_BITS: u32 = 0x30;
/// The target holds the exposed light of a lightmap, not yet multiplied by the surface's diffuse colour.
pub const LIGHTMAP_INCIDENT: u32 = 0x10;
/// The target holds emitted light and reflected light of a lightmap.
pub const LIGHTMAP_REFLECTED: u32 = 0x20;

/// Steps of one octahedral axis. Even, so that 0 is a code and the axes and flat floors are stored exactly.
pub const NORMAL_STEPS: f32 = 4094.0;
/// Half of [`NORMAL_STEPS`].
pub const HALF_STEPS: f32 = 2047.0;

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
    /// Shadow bias follows the shading normal: no normal map turns it far from the mesh's.
    pub has_mesh_normal: bool,
}

/// Shared exponent of the roots of `albedo`, 0 to 2. Decided on linear values: float comparisons agree with the device, square roots
/// may not.
pub fn albedo_exponent(albedo: Vec3) -> u32 {
    let largest = albedo.max_element();
    u32::from(largest <= ALBEDO_LIMIT) + u32::from(largest <= 0.25 * ALBEDO_LIMIT)
}

/// Largest albedo with this exponent: 1, about 1/3 and 1/12.
pub fn albedo_limit(exponent: u32) -> f32 {
    match exponent {
        0 => 1.0,
        1 => ALBEDO_LIMIT,
        _ => 0.25 * ALBEDO_LIMIT,
    }
}

/// Code of both. Few materials have a metallic other than 0 and 1, so these two get most of the codes of occlusion.
fn pack_metallic_and_occlusion(metallic: f32, occlusion: f32) -> u32 {
    let occlusion_of = |codes: u32| quantize(occlusion, (codes - 1) as f32);
    match quantize(metallic, METALLIC_MAX) {
        0 => occlusion_of(DIELECTRIC_CODES),
        m if m == METALLIC_MAX as u32 => DIELECTRIC_CODES + occlusion_of(METAL_CODES),
        m => FIRST_MIXED + (m - 1) * MIXED_CODES + occlusion_of(MIXED_CODES),
    }
}

/// Packs word 0. All inputs 0 to 1; a colour with a NaN becomes black.
pub fn pack_surface(albedo: Vec3, metallic: f32, occlusion: f32, has_mesh_normal: bool) -> u32 {
    let valid = if (albedo.x + albedo.y + albedo.z).is_nan() {
        Vec3::ZERO
    } else {
        albedo.clamp(Vec3::ZERO, Vec3::ONE)
    };
    let exponent = albedo_exponent(valid);
    let scaled = (valid / albedo_limit(exponent)).to_array();
    let [r, g, b] = scaled.map(|x| (x.sqrt() * ALBEDO_MAX + 0.5) as u32);
    let mesh_normal = if has_mesh_normal { MESH_NORMAL_BIT } else { 0 };
    let both = pack_metallic_and_occlusion(metallic, occlusion);
    let rest = (exponent * METALLIC_AND_OCCLUSION_CODES + both) << 21;
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
    root * root * albedo_limit(((word >> 21) & 0x3ff) / METALLIC_AND_OCCLUSION_CODES)
}

/// Code of [`pack_metallic_and_occlusion`].
fn metallic_and_occlusion(word: u32) -> u32 {
    ((word >> 21) & 0x3ff) % METALLIC_AND_OCCLUSION_CODES
}

/// Metallic of word 0.
pub fn unpack_metallic(word: u32) -> f32 {
    match metallic_and_occlusion(word) {
        code @ FIRST_MIXED.. => ((code - FIRST_MIXED) / MIXED_CODES + 1) as f32 / METALLIC_MAX,
        code => f32::from(u8::from(code >= DIELECTRIC_CODES)),
    }
}

/// Material occlusion of word 0.
pub fn unpack_occlusion(word: u32) -> f32 {
    match metallic_and_occlusion(word) {
        code @ FIRST_MIXED.. => {
            ((code - FIRST_MIXED) % MIXED_CODES) as f32 / (MIXED_CODES - 1) as f32
        }
        code @ DIELECTRIC_CODES.. => (code - DIELECTRIC_CODES) as f32 / (METAL_CODES - 1) as f32,
        code => code as f32 / (DIELECTRIC_CODES - 1) as f32,
    }
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
pub fn is_divisor(size: f32) -> bool {
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
