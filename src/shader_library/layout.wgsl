// The packed G-buffer. The bit table is in `layout.rs`.
//
// | word | target          | bits, low to high                                         |
// |------|-----------------|-----------------------------------------------------------|
// | 0    | `surface`       | albedo R 7, G 7, B 7 (square roots); their exponent, metallic and occlusion 10; normal is the mesh's 1 |
// | 1    | `normal`        | octahedral x 12, y 12 (stored + 1, so 0 = no geometry), perceptual roughness 8 |
//
// The optional targets' words are in `layout/`, a file for each.
// Every other file calls these functions; none repeats a shift.
#define_import_path bevy_lean_deferred::gbuffer::layout

const ALBEDO_MAX: f32 = 127.0;
/// Largest albedo with exponent 1: halfway between codes 73 and 74 of exponent 0, so that what is brighter is not stored darker.
const ALBEDO_LIMIT: f32 = 5402.25 / 16129.0;
const METALLIC_MAX: f32 = 20.0;
/// Codes of occlusion for a metallic of 0.
const DIELECTRIC_CODES: u32 = 72u;
/// Codes of occlusion for a metallic of 1.
const METAL_CODES: u32 = 40u;
/// Codes of occlusion for each other metallic.
const MIXED_CODES: u32 = 12u;
/// First code of metallic and occlusion for other metallics: after those for 0 and for 1.
const FIRST_MIXED: u32 = DIELECTRIC_CODES + METAL_CODES;
/// Codes of metallic and occlusion for each exponent of albedo.
const METALLIC_AND_OCCLUSION_CODES: u32 = 340u;
/// Bit of word 0.
const MESH_NORMAL_BIT: u32 = 0x80000000u;
const ROUGHNESS_MAX: f32 = 255.0;

/// Steps of one octahedral axis. Even, so that 0 is a code and the axes and flat floors are stored exactly.
const NORMAL_STEPS: f32 = 4094.0;
const HALF_STEPS: f32 = 2047.0;

/// Both words of a pixel that no mesh was drawn to.
const NO_GEOMETRY: u32 = 0u;

// Bits of the `valid_mask` target, one per optional target that holds a word of the pixel's surface. The others hold a word of a
// surface behind it, or nothing.
const EMISSIVE_VALID: u32 = 1u;
const SPECIALIZATION_VALID: u32 = 2u;
const MOTION_VALID: u32 = 4u;
const VISIBILITY_MASK_VALID: u32 = 8u;
// Further bits of it: content of the `emissive` target, if that is not emitted light alone.
const LIGHTMAP_BITS: u32 = 0x30u;
/// Exposed light of a lightmap, not yet multiplied by the surface's diffuse colour.
const LIGHTMAP_INCIDENT: u32 = 0x10u;
/// Emitted light, and lightmap light that the surface reflects.
const LIGHTMAP_REFLECTED: u32 = 0x20u;

struct Surface {
    /// Linear, 0 to 1.
    albedo: vec3<f32>,
    metallic: f32,
    /// Baked (material) visibility of ambient light: 1 is open.
    occlusion: f32,
    /// World space, unit length.
    normal: vec3<f32>,
    perceptual_roughness: f32,
    /// True if shadow bias follows the shading normal: no map turns it far from the mesh's.
    has_mesh_normal: bool,
}

/// True for everything but NaN and infinities. Tests the bits, because comparisons with NaN may be optimised away.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

/// True if quotients by a length are exact: small ones lose precision, and above 2^126 WGSL guarantees nothing.
fn is_divisor(size: f32) -> bool {
    return is_finite(size) && size >= 1e-30 && size < 8e37;
}

/// True for NaN only.
fn is_nan(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7fffffffu) > 0x7f800000u;
}

/// Rounds `x`, clamped to 0..1, to the nearest of `steps + 1` codes; NaN becomes 0.
fn quantize(x: f32, steps: f32) -> u32 {
    return u32(clamp(select(x, 0.0, is_nan(x)), 0.0, 1.0) * steps + 0.5);
}

/// Rounds the square roots of `color`, clamped to 0..1, to the nearest of `steps + 1` codes. One test for three: a NaN
/// channel makes the sum NaN, and the whole colour black.
fn quantize_roots(color: vec3<f32>, steps: vec3<f32>) -> vec3<u32> {
    let valid = select(color, vec3(0.0), is_nan(color.r + color.g + color.b));
    return vec3<u32>(sqrt(clamp(valid, vec3(0.0), vec3(1.0))) * steps + 0.5);
}

/// Common exponent of the roots of `albedo`, 0 to 2. Decided on linear values: comparisons of floats agree with the Rust twin,
/// square roots may not.
fn albedo_exponent(albedo: vec3<f32>) -> u32 {
    let largest = max(albedo.r, max(albedo.g, albedo.b));
    return u32(largest <= ALBEDO_LIMIT) + u32(largest <= 0.25 * ALBEDO_LIMIT);
}

/// Largest albedo with this exponent: 1, about 1/3 and 1/12.
fn albedo_limit(exponent: u32) -> f32 {
    return select(1.0, select(ALBEDO_LIMIT, 0.25 * ALBEDO_LIMIT, exponent > 1u), exponent > 0u);
}

/// Code of both. Few materials have a metallic other than 0 and 1, so these two get most of the codes of occlusion.
fn pack_metallic_and_occlusion(metallic: f32, occlusion: f32) -> u32 {
    let m = quantize(metallic, METALLIC_MAX);
    if m > 0u && m < u32(METALLIC_MAX) {
        return FIRST_MIXED + (m - 1u) * MIXED_CODES + quantize(occlusion, f32(MIXED_CODES - 1u));
    }
    if m > 0u {
        return DIELECTRIC_CODES + quantize(occlusion, f32(METAL_CODES - 1u));
    }
    return quantize(occlusion, f32(DIELECTRIC_CODES - 1u));
}

/// Packs word 0. A colour with a NaN becomes black.
fn pack_surface(albedo: vec3<f32>, metallic: f32, occlusion: f32, has_mesh_normal: bool) -> u32 {
    // One test for three: a NaN channel makes the sum NaN. The result must not depend on which one `max` drops.
    let is_number = !is_nan(albedo.r + albedo.g + albedo.b);
    let valid = select(vec3(0.0), clamp(albedo, vec3(0.0), vec3(1.0)), is_number);
    let exponent = albedo_exponent(valid);
    let rgb = vec3<u32>(sqrt(valid / albedo_limit(exponent)) * ALBEDO_MAX + 0.5);
    let rest = exponent * METALLIC_AND_OCCLUSION_CODES + pack_metallic_and_occlusion(metallic, occlusion);
    return rgb.r | (rgb.g << 7u) | (rgb.b << 14u) | (rest << 21u) | select(0u, MESH_NORMAL_BIT, has_mesh_normal);
}

fn unpack_albedo(word: u32) -> vec3<f32> {
    let codes = vec3(word & 0x7fu, (word >> 7u) & 0x7fu, (word >> 14u) & 0x7fu);
    let root = vec3<f32>(codes) / ALBEDO_MAX;
    return root * root * albedo_limit(((word >> 21u) & 0x3ffu) / METALLIC_AND_OCCLUSION_CODES);
}

/// Code of `pack_metallic_and_occlusion`.
fn metallic_and_occlusion(word: u32) -> u32 {
    return ((word >> 21u) & 0x3ffu) % METALLIC_AND_OCCLUSION_CODES;
}

fn unpack_metallic(word: u32) -> f32 {
    let code = metallic_and_occlusion(word);
    if code < FIRST_MIXED {
        return f32(code >= DIELECTRIC_CODES);
    }
    return f32((code - FIRST_MIXED) / MIXED_CODES + 1u) / METALLIC_MAX;
}

fn unpack_occlusion(word: u32) -> f32 {
    let code = metallic_and_occlusion(word);
    if code < DIELECTRIC_CODES {
        return f32(code) / f32(DIELECTRIC_CODES - 1u);
    }
    if code < FIRST_MIXED {
        return f32(code - DIELECTRIC_CODES) / f32(METAL_CODES - 1u);
    }
    return f32((code - FIRST_MIXED) % MIXED_CODES) / f32(MIXED_CODES - 1u);
}

/// True if the shading normal is that of the mesh.
fn unpack_has_mesh_normal(word: u32) -> bool {
    return (word & MESH_NORMAL_BIT) != 0u;
}

/// 1 for x >= 0, else -1 (never 0, unlike `sign`).
fn sign_not_zero(x: f32) -> f32 {
    return select(-1.0, 1.0, x >= 0.0);
}

/// Maps the square -1..1 to the octahedron (Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit
/// Vectors"). The result is not normalised.
fn direction_from_octahedral(p: vec2<f32>) -> vec3<f32> {
    var n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    if n.z < 0.0 {
        n = vec3((1.0 - abs(p.yx)) * vec2(sign_not_zero(p.x), sign_not_zero(p.y)), n.z);
    }
    return n;
}

/// Packs a direction of any length, by the same map with 16 bits per axis. Never 0.
fn pack_direction(direction: vec3<f32>) -> u32 {
    let n = direction / (abs(direction.x) + abs(direction.y) + abs(direction.z));
    var p = n.xy;
    if n.z < 0.0 {
        p = (1.0 - abs(n.yx)) * vec2(sign_not_zero(n.x), sign_not_zero(n.y));
    }
    return pack2x16snorm(p) | 1u;
}

/// Unit vector from `pack_direction`.
fn unpack_direction(word: u32) -> vec3<f32> {
    return normalize(direction_from_octahedral(unpack2x16snorm(word)));
}

/// Unit vector of integer codes 0..NORMAL_STEPS.
fn unit_from_codes(codes: vec2<f32>) -> vec3<f32> {
    return normalize(direction_from_octahedral(codes * (2.0 / NORMAL_STEPS) - 1.0));
}

/// Packs a normal of any length and the roughness. Of the four codes around the exact point, chooses the one whose direction is
/// nearest: the "precise" rounding of Cigolle et al. 2014, by the metric of the map instead of four decodes. Normals without a
/// direction (zero, NaN, infinite or nearly so) become +Y: they are lit like a floor, and no NaN reaches lighting.
fn pack_normal(normal: vec3<f32>, perceptual_roughness: f32) -> u32 {
    var n = normal;
    var size = abs(n.x) + abs(n.y) + abs(n.z);
    // A NaN or infinite component makes the sum NaN or infinite.
    if !is_divisor(size) {
        n = vec3(0.0, 1.0, 0.0);
        size = 1.0;
    }
    // Treats all octants alike: on the octahedron's face of positive x and y, with the lower half folded out.
    let m = abs(n) / size;
    let is_upper = n.z >= 0.0;
    let across = select(m.yx, m.xy, is_upper);
    let exact = select(1.0 - across, across, is_upper) * HALF_STEPS;
    let low = min(floor(exact), vec2(HALF_STEPS - 1.0));
    let f = exact - low;

    // A step (dx, dy) of codes turns the direction by an angle whose square is proportional to a dx² + 2 b dx dy + c dy², from the
    // parts of the map's derivatives (1, 0, -1) and (0, 1, -1) that are perpendicular to the direction.
    let length_squared = dot(m, m);
    let along = across - m.z;
    let ac = 2.0 * length_squared - along * along;
    let b = length_squared - along.x * along.y;

    // Change of that error, relative to `low`, by one more code in x, in y or in both.
    let one = ac * (1.0 - 2.0 * f) - 2.0 * b * f.yx;
    let both = one.x + one.y + 2.0 * b;
    // One of the best on ties too: on the diagonals of the octants, three are equal.
    let least = min(min(one.x, one.y), 0.0);
    let is_x = one.x <= one.y;
    let nearest = select(vec2(0.0), select(vec2(0.0, 1.0), vec2(1.0, 0.0), is_x), least < 0.0);
    let code = low + select(nearest, vec2(1.0), both <= least);

    let signed_code = vec2<u32>(HALF_STEPS + 1.0 + select(-code, code, n.xy >= vec2(0.0)));
    return signed_code.x | (signed_code.y << 12u)
        | (quantize(perceptual_roughness, ROUGHNESS_MAX) << 24u);
}

fn unpack_normal(word: u32) -> vec3<f32> {
    let code = vec2(word & 0xfffu, (word >> 12u) & 0xfffu);
    return unit_from_codes(vec2<f32>(code) - 1.0);
}

fn unpack_roughness(word: u32) -> f32 {
    return f32(word >> 24u) / ROUGHNESS_MAX;
}

fn pack(surface: Surface) -> vec2<u32> {
    return vec2(
        pack_surface(surface.albedo, surface.metallic, surface.occlusion, surface.has_mesh_normal),
        pack_normal(surface.normal, surface.perceptual_roughness),
    );
}

fn unpack(words: vec2<u32>) -> Surface {
    return Surface(
        unpack_albedo(words.x),
        unpack_metallic(words.x),
        unpack_occlusion(words.x),
        unpack_normal(words.y),
        unpack_roughness(words.y),
        unpack_has_mesh_normal(words.x),
    );
}
