// The bit table of the packed G-buffer; twin of `layout.rs`, under the same names.
//
// | word | target          | bits, low to high                                         |
// |------|-----------------|-----------------------------------------------------------|
// | 0    | `surface`       | albedo R 7, G 8, B 7 (sRGB curve), metallic 5, occlusion 5 |
// | 1    | `normal`        | octahedral x 12, y 12 (stored + 1, so 0 = no geometry), perceptual roughness 8 |
//
// Every other file calls these functions; none repeats a shift.
#define_import_path bevy_lean_deferred::gbuffer::layout

const ALBEDO_R_MAX: f32 = 127.0;
const ALBEDO_G_MAX: f32 = 255.0;
const ALBEDO_B_MAX: f32 = 127.0;
const FIVE_BIT_MAX: f32 = 31.0;
const ROUGHNESS_MAX: f32 = 255.0;

/// Steps of one octahedral axis. Even, so that 0 is a code and the axes and flat floors are stored exactly.
const NORMAL_STEPS: f32 = 4094.0;

/// Both words of a pixel that no mesh was drawn to.
const NO_GEOMETRY: u32 = 0u;

struct Surface {
    /// Linear, 0 to 1.
    albedo: vec3<f32>,
    metallic: f32,
    /// Baked (material) visibility of ambient light: 1 is open.
    occlusion: f32,
    /// World space, unit length.
    normal: vec3<f32>,
    perceptual_roughness: f32,
}

/// True for everything but NaN and infinities. Looks at the bits, because comparisons with NaN may be optimised away.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

/// `x` clamped to 0..1; NaN becomes 0, infinities clamp.
fn saturate_or_zero(x: f32) -> f32 {
    let bits = bitcast<u32>(x);
    if (bits & 0x7fffffffu) > 0x7f800000u {
        return 0.0;
    }
    return clamp(x, 0.0, 1.0);
}

/// Rounds `x` in 0..1 to the nearest of `steps + 1` codes.
fn quantize(x: f32, steps: f32) -> u32 {
    return u32(saturate_or_zero(x) * steps + 0.5);
}

/// Linear to sRGB-encoded (IEC 61966-2-1:1999).
fn srgb_from_linear(x: f32) -> f32 {
    if x <= 0.0031308 {
        return 12.92 * x;
    }
    return 1.055 * pow(x, 1.0 / 2.4) - 0.055;
}

/// sRGB-encoded to linear (IEC 61966-2-1:1999).
fn linear_from_srgb(x: f32) -> f32 {
    if x <= 0.04045 {
        return x / 12.92;
    }
    return pow((x + 0.055) / 1.055, 2.4);
}

fn pack_surface(albedo: vec3<f32>, metallic: f32, occlusion: f32) -> u32 {
    let r = quantize(srgb_from_linear(saturate_or_zero(albedo.r)), ALBEDO_R_MAX);
    let g = quantize(srgb_from_linear(saturate_or_zero(albedo.g)), ALBEDO_G_MAX);
    let b = quantize(srgb_from_linear(saturate_or_zero(albedo.b)), ALBEDO_B_MAX);
    let m = quantize(metallic, FIVE_BIT_MAX);
    let o = quantize(occlusion, FIVE_BIT_MAX);
    return r | (g << 7u) | (b << 15u) | (m << 22u) | (o << 27u);
}

fn unpack_albedo(word: u32) -> vec3<f32> {
    return vec3(
        linear_from_srgb(f32(word & 0x7fu) / ALBEDO_R_MAX),
        linear_from_srgb(f32((word >> 7u) & 0xffu) / ALBEDO_G_MAX),
        linear_from_srgb(f32((word >> 15u) & 0x7fu) / ALBEDO_B_MAX),
    );
}

fn unpack_metallic(word: u32) -> f32 {
    return f32((word >> 22u) & 0x1fu) / FIVE_BIT_MAX;
}

fn unpack_occlusion(word: u32) -> f32 {
    return f32(word >> 27u) / FIVE_BIT_MAX;
}

/// 1 for x >= 0, else -1 (never 0, unlike `sign`).
fn sign_not_zero(x: f32) -> f32 {
    return select(-1.0, 1.0, x >= 0.0);
}

/// Unit sphere to the square -1..1 (Cigolle et al. 2014, "A Survey of Efficient Representations for Independent
/// Unit Vectors").
fn octahedral_from_unit(n: vec3<f32>) -> vec2<f32> {
    let p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    if n.z >= 0.0 {
        return p;
    }
    return (1.0 - abs(p.yx)) * vec2(sign_not_zero(p.x), sign_not_zero(p.y));
}

/// Inverse of `octahedral_from_unit`; the result is not normalised.
fn direction_from_octahedral(p: vec2<f32>) -> vec3<f32> {
    var n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    if n.z < 0.0 {
        n = vec3((1.0 - abs(p.yx)) * vec2(sign_not_zero(p.x), sign_not_zero(p.y)), n.z);
    }
    return n;
}

/// The direction of integer codes 0..NORMAL_STEPS, unit length.
fn unit_from_codes(codes: vec2<f32>) -> vec3<f32> {
    return normalize(direction_from_octahedral(codes * (2.0 / NORMAL_STEPS) - 1.0));
}

/// A unit vector from `n`. What has no direction (zero, NaN, infinite) becomes +Y: up lights like a floor, and no
/// NaN reaches the lighting.
fn unit_or_up(n: vec3<f32>) -> vec3<f32> {
    // Scaled by the largest component first, so that neither tiny nor huge vectors lose their squares.
    let largest = max(abs(n.x), max(abs(n.y), abs(n.z)));
    if !is_finite(n.x) || !is_finite(n.y) || !is_finite(n.z) || largest < 1e-30 {
        return vec3(0.0, 1.0, 0.0);
    }
    return normalize(n / largest);
}

/// The metric of the octahedral map at the unit vector `n`, at codes `p` in -1..1: the squared angle that a step
/// (dx, dy) makes is proportional to `x dx² + 2 y dx dy + z dy²`. (The map's two partial derivatives have length √2;
/// their parts along `n` do not turn it.)
fn octahedral_metric(n: vec3<f32>, p: vec2<f32>) -> vec3<f32> {
    let s = vec2(sign_not_zero(p.x), sign_not_zero(p.y));
    // Upper half: ∂/∂x = (1, 0, -sx), ∂/∂y = (0, 1, -sy). Lower half, folded: -sx (0, sy, 1), -sy (sx, 0, 1).
    let along = select(-s * (s.yx * n.yx + n.z), n.xy - s * n.z, n.z >= 0.0);
    return vec3(2.0 - along.x * along.x, s.x * s.y - along.x * along.y, 2.0 - along.y * along.y);
}

/// Packs a normal and the roughness. Of the four codes around the exact point it takes the one whose direction is
/// nearest (after the "precise" rounding of Cigolle et al. 2014, with the metric in place of four decodes).
fn pack_normal(normal: vec3<f32>, perceptual_roughness: f32) -> u32 {
    let n = unit_or_up(normal);
    let p = octahedral_from_unit(n);
    let exact = (p * 0.5 + 0.5) * NORMAL_STEPS;
    let low = clamp(floor(exact), vec2(0.0), vec2(NORMAL_STEPS - 1.0));
    let metric = octahedral_metric(n, p);
    var best = low;
    // Larger than any squared step to a corner of the cell.
    var best_distance = 16.0;
    for (var i = 0u; i < 4u; i += 1u) {
        let codes = low + vec2(f32(i & 1u), f32(i >> 1u));
        let step = codes - exact;
        let distance =
            metric.x * step.x * step.x + 2.0 * metric.y * step.x * step.y + metric.z * step.y * step.y;
        if distance < best_distance {
            best_distance = distance;
            best = codes;
        }
    }
    let code = vec2<u32>(best) + 1u;
    return code.x | (code.y << 12u) | (quantize(perceptual_roughness, ROUGHNESS_MAX) << 24u);
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
        pack_surface(surface.albedo, surface.metallic, surface.occlusion),
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
    );
}
