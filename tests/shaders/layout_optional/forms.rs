//! Forms of the words of the optional targets, on device and twin.

use bevy::math::Vec3;
use kit::{
    random::Random,
    reference::{
        shader_library::layout::{light, specialization as special},
        shading_models::{anisotropy, clearcoat, diffuse_transmission, rim, subsurface, unlit},
    },
};

/// Number of values that a word, or a shading model's arguments, hold.
pub const VALUES: usize = 4;
/// Those values, then the surface's normal.
pub type Values = [f32; VALUES + 3];

/// A form of a word, or of a shading model's arguments.
pub struct Form {
    pub name: &'static str,
    /// The four values `x`, unpacked from `word` on the device.
    pub unpack_wgsl: &'static str,
    /// The word, packed from `x` and `normal` on the device.
    pub pack_wgsl: &'static str,
    pub unpack: fn(u32, Vec3) -> [f32; VALUES],
    pub pack: fn(Values) -> u32,
    /// Words that unpacking and packing must not change: all, unless they are too many.
    pub words: fn(&mut Random) -> Vec<u32>,
    /// Largest difference between device and twin in a decoded value, relative to the value or to `decode_least`.
    pub decode_tolerance: f32,
    pub decode_least: f32,
    /// Fields that the device may round differently. All other bits must be equal.
    pub fields: &'static [Field],
}

/// Bits of a word.
pub struct Field {
    pub shift: u32,
    pub bits: u32,
    /// Index of the only value that they hold.
    pub value: usize,
    /// Position of a value among the codes.
    pub place: fn(f64, &Values) -> f64,
    /// Largest distance from the middle between two codes, in steps, at which device and twin may round differently.
    pub tie: fn(&Values) -> f64,
    /// True if the first code follows the last.
    pub wraps: bool,
}

impl Field {
    pub fn code(&self, word: u32) -> u32 {
        (word >> self.shift) & self.largest()
    }

    pub fn largest(&self) -> u32 {
        (1 << self.bits) - 1
    }
}

/// The form with this name.
pub fn named(name: &str) -> &'static Form {
    let form = FORMS.iter().find(|form| form.name == name);
    form.unwrap_or_else(|| panic!("no form is named {name}"))
}

impl Form {
    /// `kernel` with the functions that it calls.
    pub fn kernel(&self, kernel: &str) -> String {
        let Self {
            unpack_wgsl,
            pack_wgsl,
            ..
        } = self;
        format!(
            "
#import bevy_lean_deferred::gbuffer::layout::light
#import bevy_lean_deferred::gbuffer::layout::specialization as special
#import bevy_lean_deferred::shading_models::{{anisotropy, diffuse_transmission, clearcoat, rim, subsurface, unlit}}
fn unpacked(word: u32, normal: vec3<f32>) -> vec4<f32> {{
    return {unpack_wgsl};
}}
fn packed(x: array<f32, 7>) -> u32 {{
    let color = vec3(x[0], x[1], x[2]);
    let normal = vec3(x[4], x[5], x[6]);
    return {pack_wgsl};
}}
{kernel}"
        )
    }
}

/// Largest difference between device and twin in a decoded value: their divisions round differently.
const DECODE_TOLERANCE: f32 = 5e-7;
/// Vulkan allows errors of 2⁻¹¹ in sines and cosines. SwiftShader makes use of it.
const ANGLE_TOLERANCE: f32 = 4.9e-4;
/// WGSL allows an error of 29 ULP in `exp2` of up to 13.
const EXP_TOLERANCE: f32 = 29.0 * f32::EPSILON;
const TIE: fn(&Values) -> f64 = |_| 1e-4;
/// Logarithms on the device are less exact.
const LOG_TIE: fn(&Values) -> f64 = |_| 5e-4;
const UNLIT: u32 = 6;

const fn root_field(shift: u32, bits: u32, value: usize) -> Field {
    let place: fn(f64, &Values) -> f64 = match bits {
        3 => |x, _| x.sqrt() * 7.0,
        _ => |x, _| x.sqrt() * 15.0,
    };
    Field {
        shift,
        bits,
        value,
        place,
        tie: TIE,
        wraps: false,
    }
}

const fn linear_field(shift: u32, bits: u32, value: usize) -> Field {
    let place: fn(f64, &Values) -> f64 = match bits {
        7 => |x, _| x * 127.0,
        _ => |x, _| x * 255.0,
    };
    Field {
        shift,
        bits,
        value,
        place,
        tie: TIE,
        wraps: false,
    }
}

const fn unlit_field(shift: u32, value: usize) -> Field {
    Field {
        shift,
        bits: 8,
        value,
        place: |x, values| {
            let largest = values[..3].iter().copied().fold(0.0, f32::max);
            let exponent = f64::from(largest.min(unlit::LARGEST_UNLIT)).log2().ceil();
            (x.min(f64::from(unlit::LARGEST_UNLIT)) / exponent.max(0.0).exp2()).sqrt() * 255.0
        },
        tie: TIE,
        wraps: false,
    }
}

fn all_arguments(_: &mut Random) -> Vec<u32> {
    (0..1 << special::ARGUMENT_BITS).collect()
}

fn color(x: &[f32]) -> Vec3 {
    Vec3::new(x[0], x[1], x[2])
}

fn with(color: Vec3, fourth: f32) -> [f32; VALUES] {
    [color.x, color.y, color.z, fourth]
}

pub const FORMS: &[Form] = &[
    Form {
        name: "emissive",
        unpack_wgsl: "vec4(light::unpack_light(word), 0.0)",
        pack_wgsl: "light::pack_light(color)",
        unpack: |word, _| with(light::unpack_light(word), 0.0),
        pack: |x| light::pack_light(color(&x)),
        words: |random| {
            // Each code of each channel with each code of a brighter channel; the third channel is random.
            let mut words = Vec::new();
            for exponent in 0..32u32 {
                let least = if exponent == 0 { 0 } else { 256 };
                for brightest in least..512u32 {
                    for other in 0..=brightest {
                        let third = random.below(brightest as usize + 1) as u32;
                        let rgb = [brightest, other, third];
                        let [r, g, b] = [0, 1, 2].map(|i| rgb[(i + other as usize) % 3]);
                        words.push(r | (g << 9) | (b << 18) | (exponent << 27));
                    }
                }
            }
            words
        },
        decode_tolerance: 0.0,
        decode_least: 0.0,
        fields: &[],
    },
    Form {
        name: "specialization",
        unpack_wgsl: "vec4(
            special::unpack_reflectance(word),
            f32(special::unpack_shading_model(word)),
            f32(word & (special::NO_FOG | special::NO_SHADOWS)),
            f32(special::unpack_arguments(word)),
        )",
        pack_wgsl: "special::with_arguments(
            special::pack_specialization(x[0], u32(x[1]), u32(x[2])),
            u32(x[3]),
        )",
        unpack: |word, _| {
            let flags = special::NO_FOG | special::NO_SHADOWS;
            [
                special::unpack_reflectance(word),
                special::unpack_shading_model(word) as f32,
                (word & flags) as f32,
                special::unpack_arguments(word) as f32,
            ]
        },
        pack: |x| {
            let word = special::pack_specialization(x[0], x[1] as u32, x[2] as u32);
            special::with_arguments(word, x[3] as u32)
        },
        words: |random| {
            // 253 to 255 are unused, and so are the two bits below the arguments.
            (0..1 << 13)
                .filter(|word| (word & 0xff) ^ 63 <= 252)
                .flat_map(|word| [0, random.bits() >> 15, 0x1_ffff].map(|x| word | (x << 15)))
                .collect()
        },
        decode_tolerance: DECODE_TOLERANCE,
        decode_least: 0.0,
        fields: &[Field {
            shift: 0,
            bits: 8,
            value: 0,
            place: |x, _| x * 126.0,
            tie: TIE,
            wraps: false,
        }],
    },
    Form {
        name: "subsurface",
        // A negative path means that the base colour is applied before scattering. Devices may flush subnormal numbers to 0.
        unpack_wgsl: "vec4(
            subsurface::unpack_subsurface_color(word),
            subsurface::unpack_subsurface_path(word)
                * select(1.0, -1.0, subsurface::unpack_subsurface_colors_before(word)),
        )",
        pack_wgsl: "subsurface::pack_subsurface(color, abs(x[3]), x[3] < -1e-30)",
        unpack: |word, _| {
            let color = subsurface::unpack_subsurface_color(word);
            let path = subsurface::unpack_subsurface_path(word);
            let colors_before = subsurface::unpack_subsurface_colors_before(word);
            with(color, if colors_before { -path } else { path })
        },
        pack: |x| subsurface::pack_subsurface(color(&x), x[3].abs(), x[3] < -1e-30),
        words: all_arguments,
        decode_tolerance: EXP_TOLERANCE,
        decode_least: 0.0,
        fields: &[
            root_field(0, 4, 0),
            root_field(4, 3, 1),
            root_field(7, 3, 2),
            Field {
                shift: 10,
                bits: 6,
                value: 3,
                place: |x, _| (1.0 - x.abs().max(1e-30).log2() / 1e-4f64.log2()) * 63.0,
                tie: LOG_TIE,
                wraps: false,
            },
        ],
    },
    Form {
        name: "anisotropy",
        unpack_wgsl: "vec4(
            anisotropy::unpack_anisotropy_strength(word),
            anisotropy::unpack_anisotropy_tangent(word, normal),
        )",
        pack_wgsl: "anisotropy::pack_anisotropy(x[0], vec3(x[1], x[2], x[3]), normal)",
        unpack: |word, normal| {
            let t = anisotropy::unpack_anisotropy_tangent(word, normal);
            [anisotropy::unpack_anisotropy_strength(word), t.x, t.y, t.z]
        },
        pack: |x| anisotropy::pack_anisotropy(x[0], color(&x[1..]), color(&x[4..])),
        words: all_arguments,
        // Components of a unit vector, by the device's sine and cosine.
        decode_tolerance: ANGLE_TOLERANCE,
        decode_least: 1.0,
        fields: &[linear_field(0, 7, 0), super::anisotropy::ANGLE],
    },
    Form {
        name: "rim",
        unpack_wgsl: "vec4(rim::unpack_rim_color(word), rim::unpack_rim_exponent(word))",
        pack_wgsl: "rim::pack_rim(color, x[3])",
        unpack: |word, _| {
            let exponent = rim::unpack_rim_exponent(word);
            with(rim::unpack_rim_color(word), exponent)
        },
        pack: |x| rim::pack_rim(color(&x), x[3]),
        words: all_arguments,
        decode_tolerance: DECODE_TOLERANCE,
        decode_least: 0.0,
        fields: &[
            root_field(0, 4, 0),
            root_field(4, 4, 1),
            root_field(8, 4, 2),
            Field {
                shift: 12,
                bits: 5,
                value: 3,
                place: |x, _| ((x - 1.0) / 15.0).max(0.0).sqrt() * 31.0,
                tie: TIE,
                wraps: false,
            },
        ],
    },
    Form {
        name: "clearcoat",
        unpack_wgsl: "vec4(
            clearcoat::unpack_clearcoat_strength(word),
            clearcoat::unpack_clearcoat_roughness(word),
            0.0,
            0.0,
        )",
        pack_wgsl: "clearcoat::pack_clearcoat(x[0], x[1])",
        unpack: |word, _| {
            let strength = clearcoat::unpack_clearcoat_strength(word);
            [
                strength,
                clearcoat::unpack_clearcoat_roughness(word),
                0.0,
                0.0,
            ]
        },
        pack: |x| clearcoat::pack_clearcoat(x[0], x[1]),
        words: |_| (0..1 << 16).collect(),
        decode_tolerance: DECODE_TOLERANCE,
        decode_least: 0.0,
        fields: &[linear_field(0, 8, 0), linear_field(8, 8, 1)],
    },
    Form {
        name: "diffuse_transmission",
        unpack_wgsl: "vec4(
            diffuse_transmission::unpack_transmission(word),
            diffuse_transmission::unpack_thickness(word),
            f32(diffuse_transmission::unpack_receives_shadows(word)),
            0.0,
        )",
        pack_wgsl: "diffuse_transmission::pack_diffuse_transmission(x[0], x[1], x[2] > 0.5)",
        unpack: |word, _| {
            let shadows = diffuse_transmission::unpack_receives_shadows(word);
            let thickness = diffuse_transmission::unpack_thickness(word);
            let transmission = diffuse_transmission::unpack_transmission(word);
            [transmission, thickness, f32::from(u8::from(shadows)), 0.0]
        },
        pack: |x| diffuse_transmission::pack_diffuse_transmission(x[0], x[1], x[2] > 0.5),
        words: all_arguments,
        decode_tolerance: DECODE_TOLERANCE,
        decode_least: 0.0,
        fields: &[
            linear_field(0, 7, 0),
            Field {
                shift: 7,
                bits: 9,
                value: 1,
                place: |x, _| (x.max(1e-30).log2() + 20.0) * 16.0 + 1.0,
                tie: LOG_TIE,
                wraps: false,
            },
        ],
    },
    Form {
        name: "unlit",
        unpack_wgsl: "vec4(unlit::unpack_unlit(word), f32(word & special::NO_FOG))",
        pack_wgsl: "unlit::pack_unlit(color, u32(x[3]))",
        unpack: |word, _| with(unlit::unpack_unlit(word), (word & special::NO_FOG) as f32),
        // Only the flag of the fog is stored.
        pack: |x| unlit::pack_unlit(color(&x), x[3] as u32),
        words: |random| {
            let mut words = Vec::new();
            for exponent in 0..16 {
                let least = if exponent == 0 { 0 } else { 181 };
                for brightest in least..256u32 {
                    for other in 0..=brightest {
                        let third = random.below(brightest as usize + 1) as u32;
                        let rgb = [brightest, other, third];
                        let rgb = [0, 1, 2].map(|i| rgb[(i + other as usize) % 3]);
                        words.push(unlit_word(rgb, exponent, random.bits() & special::NO_FOG));
                    }
                }
            }
            words
        },
        decode_tolerance: DECODE_TOLERANCE,
        decode_least: 0.0,
        fields: &[unlit_field(0, 0), unlit_field(15, 1), unlit_field(23, 2)],
    },
];

fn unlit_word([r, g, b]: [u32; 3], exponent: u32, flags: u32) -> u32 {
    let exponent = ((exponent & 7) << 12) | ((exponent >> 3) << 31);
    r | (UNLIT << 8) | flags | exponent | (g << 15) | (b << 23)
}
