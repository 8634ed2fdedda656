//! The bit table of the G-buffer: the shipped WGSL on the device against its Rust twin, and the loss of storing.

mod accuracy;
mod ties;

use accuracy::angle;
use bevy::math::Vec3;
use kit::{
    compute::{Compute, Kernel},
    random::Random,
    reference::shader_library::layout::{self, ALBEDO_LIMIT, NO_GEOMETRY, NORMAL_STEPS, Surface},
    shipped_wgsl,
    wgsl::WgslModule,
};

const MODULE: WgslModule = shipped_wgsl!("shader_library/layout.wgsl");

/// Floats of a [`Surface`], as the kernels below pass them.
const FIELDS: usize = 10;
/// Largest codes of an albedo channel, of its exponent, of metallic, and of metallic and occlusion.
const ALBEDO_CODE_MAX: u32 = 127;
const EXPONENT_MAX: u32 = 2;
/// Largest code with each exponent of an albedo that has a larger exponent.
const DARK_CODE_MAX: [u32; 3] = [73, 63, 0];
const METALLIC_CODE_MAX: u32 = 20;
const METALLIC_AND_OCCLUSION_MAX: u32 = 339;
/// Largest code of an octahedral axis; the least is 1.
const NORMAL_CODE_MAX: u32 = NORMAL_STEPS as u32 + 1;
/// Largest difference between device and twin in a decoded value: their `pow` and `normalize` round differently.
const DECODE_TOLERANCE: f32 = 5e-7;

const UNPACK: &str = "
#import bevy_lean_deferred::gbuffer::layout::{pack, unpack}
fn kernel(words: array<u32, 2>) -> array<u32, 12> {
    let s = unpack(vec2(words[0], words[1]));
    let again = pack(s);
    let a = bitcast<vec3<u32>>(s.albedo);
    let n = bitcast<vec3<u32>>(s.normal);
    let rest = bitcast<vec3<u32>>(vec3(s.metallic, s.occlusion, s.perceptual_roughness));
    return array(a.x, a.y, a.z, rest.x, rest.y, n.x, n.y, n.z, rest.z,
        bitcast<u32>(f32(s.has_mesh_normal)), again.x, again.y);
}";

const PACK: &str = "
#import bevy_lean_deferred::gbuffer::layout::{Surface, pack}
fn kernel(bits: array<u32, 10>) -> array<u32, 2> {
    let words = pack(Surface(
        bitcast<vec3<f32>>(vec3(bits[0], bits[1], bits[2])),
        bitcast<f32>(bits[3]),
        bitcast<f32>(bits[4]),
        bitcast<vec3<f32>>(vec3(bits[5], bits[6], bits[7])),
        bitcast<f32>(bits[8]),
        bits[9] == 0x3f800000u,
    ));
    return array(words.x, words.y);
}";

fn fields(s: &Surface) -> [f32; FIELDS] {
    let (a, n) = (s.albedo, s.normal);
    [
        a.x,
        a.y,
        a.z,
        s.metallic,
        s.occlusion,
        n.x,
        n.y,
        n.z,
        s.perceptual_roughness,
        f32::from(u8::from(s.has_mesh_normal)),
    ]
}

fn surface(fields: [f32; FIELDS]) -> Surface {
    let [
        ax,
        ay,
        az,
        metallic,
        occlusion,
        nx,
        ny,
        nz,
        roughness,
        has_mesh_normal,
    ] = fields;
    Surface {
        albedo: Vec3::new(ax, ay, az),
        metallic,
        occlusion,
        normal: Vec3::new(nx, ny, nz),
        perceptual_roughness: roughness,
        has_mesh_normal: has_mesh_normal == 1.0,
    }
}

/// A surface word as packing makes it, with the exponent that its colour requires.
fn surface_word([r, g, b]: [u32; 3], exponent: u32, metallic_and_occlusion: u32) -> u32 {
    let is_dark = r.max(g).max(b) <= DARK_CODE_MAX[exponent as usize];
    let exponent = if is_dark { EXPONENT_MAX } else { exponent };
    // Every other code of red marks the mesh's normal.
    let flag = r % 2;
    let rest = exponent * (METALLIC_AND_OCCLUSION_MAX + 1) + metallic_and_occlusion;
    r | (g << 7) | (b << 14) | (rest << 21) | (flag << 31)
}

/// Codes of a surface word: three of albedo, its exponent, metallic, occlusion, and the flag of the mesh's normal.
fn surface_codes(word: u32) -> [u32; 7] {
    let rest = (word >> 21) & 0x3ff;
    let (metallic, occlusion) = match rest % (METALLIC_AND_OCCLUSION_MAX + 1) {
        code @ 112.. => ((code - 112) / 12 + 1, (code - 112) % 12),
        code @ 72.. => (METALLIC_CODE_MAX, code - 72),
        code => (0, code),
    };
    [
        word & 0x7f,
        (word >> 7) & 0x7f,
        (word >> 14) & 0x7f,
        rest / (METALLIC_AND_OCCLUSION_MAX + 1),
        metallic,
        occlusion,
        word >> 31,
    ]
}

/// Largest code of occlusion beside this code of metallic.
fn occlusion_code_max(metallic: u32) -> u32 {
    match metallic {
        0 => 71,
        METALLIC_CODE_MAX => 39,
        _ => 11,
    }
}

fn normal_word(x: u32, y: u32, roughness: u32) -> u32 {
    x | (y << 12) | (roughness << 24)
}

fn normal_codes(word: u32) -> (u32, u32) {
    (word & 0xfff, (word >> 12) & 0xfff)
}

/// False on the outer border of the octahedral square, where two codes represent one direction, and at its corners four.
fn has_one_code(word: u32) -> bool {
    let (x, y) = normal_codes(word);
    let inside = 2..NORMAL_CODE_MAX;
    inside.contains(&x) && inside.contains(&y)
}

/// Checks that device and twin decode `words` alike, and that both pack them again unchanged.
fn check_round_trip(kernel: &Kernel<2, 12>, words: &[[u32; 2]]) {
    for (&word, device) in words.iter().zip(kernel.run(words)) {
        let decoded = layout::unpack(word);
        for (field, (twin, bits)) in fields(&decoded).into_iter().zip(device).enumerate() {
            let difference = (twin - f32::from_bits(bits)).abs();
            assert!(
                difference <= DECODE_TOLERANCE,
                "field {field} of {word:08x?}: {difference:e}"
            );
        }
        for again in [layout::pack(&decoded), [device[FIELDS], device[FIELDS + 1]]] {
            let direction_kept = || {
                let angle = angle(layout::unpack_normal(again[1]), decoded.normal.as_dvec3());
                again[1] >> 24 == word[1] >> 24 && angle < 1e-4
            };
            let same =
                again == word || again[0] == word[0] && !has_one_code(word[1]) && direction_kept();
            assert!(same, "{word:08x?} became {again:08x?}");
        }
    }
}

#[test]
fn every_code_survives_unpacking_and_packing() {
    let compute = Compute::new();
    let kernel = compute.kernel(&[MODULE], UNPACK);
    let mut random = Random::new(1);

    let mut words = Vec::new();
    for exponent in 0..=EXPONENT_MAX {
        for code in 0..=ALBEDO_CODE_MAX {
            for channel in 0..3 {
                for others in [0, code / 2, code] {
                    let mut codes = [others; 3];
                    codes[channel] = code;
                    let word = surface_word(codes, exponent, 0);
                    words.push([word, normal_word(1, 1, 0)]);
                }
            }
        }
    }
    for both in 0..=METALLIC_AND_OCCLUSION_MAX {
        words.push([surface_word([0; 3], 0, both), normal_word(1, 1, 0)]);
    }
    let black = surface_word([0; 3], 0, 0);
    words.extend((0..=255).map(|roughness| [black, normal_word(2048, 2048, roughness)]));
    words.extend((0..500_000).map(|_| {
        let mut below = |count: u32| random.below(count as usize) as u32;
        let albedo = [(); 3].map(|()| below(ALBEDO_CODE_MAX + 1));
        let exponent = below(EXPONENT_MAX + 1);
        let both = below(METALLIC_AND_OCCLUSION_MAX + 1);
        [
            surface_word(albedo, exponent, both),
            normal_word(
                1 + below(NORMAL_CODE_MAX),
                1 + below(NORMAL_CODE_MAX),
                below(256),
            ),
        ]
    }));
    check_round_trip(&kernel, &words);

    let rows: Vec<u32> = (1..=NORMAL_CODE_MAX).collect();
    for rows in rows.chunks(256) {
        let words: Vec<_> = rows
            .iter()
            .flat_map(|&y| (1..=NORMAL_CODE_MAX).map(move |x| [black, normal_word(x, y, 0)]))
            .collect();
        check_round_trip(&kernel, &words);
    }
}

/// Values that shaders should not receive, and those at which a formula changes.
const HOSTILE: [f32; 22] = [
    f32::NAN,
    -f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    1e30,
    -1e30,
    2.0,
    -1.0,
    1.0,
    1.0 + f32::EPSILON,
    1.0 - f32::EPSILON,
    0.5,
    0.003_130_8,
    0.04045,
    1e-30,
    -1e-30,
    1e-38,
    1e-45,
    0.0,
    -0.0,
];

fn hostile_surfaces() -> Vec<[f32; FIELDS]> {
    let mut surfaces = Vec::new();
    for (i, a) in HOSTILE.into_iter().enumerate() {
        for (j, b) in HOSTILE.into_iter().enumerate() {
            for (k, c) in HOSTILE.into_iter().enumerate() {
                let mixed = HOSTILE[(i + j + k) % HOSTILE.len()];
                surfaces.push([a, b, c, mixed, a, a, b, c, mixed, a]);
            }
        }
    }
    surfaces
}

/// Ordinary surfaces. Their normals include axes, seams between octants, and any length.
fn random_surfaces(count: usize) -> Vec<[f32; FIELDS]> {
    let mut random = Random::new(2);
    let mut component = |kind: usize| match kind {
        0 => 0.0,
        1 => random.range(-1e-3, 1e-3),
        2 => random.range(-1.0, 1.0).signum(),
        _ => random.range(-1.0, 1.0),
    };
    let normals: Vec<_> = (0..count)
        .map(|i| {
            Vec3::new(
                component(i % 7),
                component(i / 7 % 5),
                component(i / 35 % 5),
            )
        })
        .collect();
    normals
        .into_iter()
        .map(|normal| {
            let n = normal * 10f32.powf(random.range(-30.0, 30.0));
            let mut value = || random.range(-0.05, 1.05);
            [
                value(),
                value(),
                value(),
                value(),
                value(),
                n.x,
                n.y,
                n.z,
                value(),
                f32::from(u8::from(n.x > 0.0)),
            ]
        })
        .collect()
}

/// Checks that `words` is a pixel that can be lit.
fn check_decodes(words: [u32; 2], input: &Surface) {
    let (x, y) = normal_codes(words[1]);
    let codes = 1..=NORMAL_CODE_MAX;
    assert_ne!(words[1], NO_GEOMETRY);
    assert!(
        codes.contains(&x) && codes.contains(&y),
        "{input:?} became {words:08x?}"
    );
    let decoded = layout::unpack(words);
    assert!(
        (decoded.normal.length() - 1.0).abs() < 1e-6,
        "{input:?} became {decoded:?}"
    );
    let in_range = fields(&Surface {
        normal: Vec3::ZERO,
        ..decoded
    });
    assert!(
        in_range.iter().all(|x| (0.0..=1.0).contains(x)),
        "{input:?} became {decoded:?}"
    );
}

#[test]
fn device_and_twin_pack_alike() {
    let compute = Compute::new();
    let kernel = compute.kernel(&[MODULE], PACK);
    let inputs = [hostile_surfaces(), random_surfaces(1_000_000)].concat();
    let bits: Vec<_> = inputs.iter().map(|input| input.map(f32::to_bits)).collect();

    let (mut tie_count, mut found) = (0, Vec::new());
    for (&input, device) in inputs.iter().zip(kernel.run(&bits)) {
        let input = surface(input);
        let twin = layout::pack(&input);
        check_decodes(device, &input);
        check_decodes(twin, &input);
        if device != twin {
            found.extend(ties::differences(&input, device, twin, &mut tie_count));
        }
    }
    println!(
        "{tie_count} fields of {} surfaces rounded otherwise, being ties",
        inputs.len()
    );
    assert!(
        found.is_empty(),
        "{} differ:\n{}",
        found.len(),
        found[..found.len().min(10)].join("\n")
    );
    // Over all fields of the words: albedo's three, metallic, occlusion, normal, roughness.
    assert!(
        tie_count < inputs.len() * 7 / 1000,
        "{tie_count} ties are too many to be ties"
    );
}

/// Black, white, the largest albedo with each exponent, and the most common values of materials are stored exactly; grey gets no tint.
#[test]
fn common_values_are_exact() {
    let stored = |albedo: Vec3, metallic, occlusion| {
        let word = layout::pack_surface(albedo, metallic, occlusion, false);
        (
            layout::unpack_albedo(word),
            layout::unpack_metallic(word),
            layout::unpack_occlusion(word),
        )
    };
    for albedo in [0.0, 1.0, ALBEDO_LIMIT, 0.25 * ALBEDO_LIMIT] {
        for channels in [Vec3::ONE, Vec3::X, Vec3::Y, Vec3::Z] {
            let albedo = albedo * channels;
            assert_eq!(stored(albedo, 0.0, 1.0), (albedo, 0.0, 1.0));
        }
    }
    for i in 0..=20 {
        let metallic = i as f32 / 20.0;
        assert_eq!(stored(Vec3::ONE, metallic, 0.0), (Vec3::ONE, metallic, 0.0));
    }
    for i in 0..=10_000 {
        let (grey, ..) = stored(Vec3::splat(i as f32 / 10_000.0), 0.0, 1.0);
        assert_eq!(grey, Vec3::splat(grey.x));
    }
}

/// From the smallest albedo with full precision on, the step between codes is bounded relative to the brightest channel.
#[test]
fn dark_albedo_is_as_fine_as_bright() {
    let mut last = 0.0;
    let mut largest_step = 0.0f32;
    for i in 0..=2_000_000 {
        let exact = 2f32.powf(-8.0 * (1.0 - i as f32 / 2e6));
        let word = layout::pack_surface(Vec3::splat(exact), 0.0, 0.0, false);
        let stored = layout::unpack_albedo(word).x;
        assert!(stored >= last, "{exact} is darker than less");
        if last > 0.0 {
            largest_step = largest_step.max(stored / last - 1.0);
        }
        last = stored;
    }
    println!(
        "albedo from 1/256 up: steps of {:.2}%",
        100.0 * largest_step
    );
    assert!(largest_step < 0.076);
}

#[test]
fn what_cannot_be_stored_is_replaced() {
    let up = layout::pack_normal(Vec3::Y, 0.0);
    for (x, stored) in [
        (f32::NAN, 0.0),
        (-1.0, 0.0),
        (f32::NEG_INFINITY, 0.0),
        (f32::INFINITY, 1.0),
        (7.0, 1.0),
    ] {
        let decoded = layout::unpack(layout::pack(&surface([x; FIELDS])));
        for value in fields(&Surface {
            normal: Vec3::splat(stored),
            has_mesh_normal: stored == 1.0,
            ..decoded
        }) {
            assert_eq!(value, stored, "{x} is stored as {decoded:?}");
        }
    }
    for none in [
        Vec3::ZERO,
        Vec3::NAN,
        Vec3::INFINITY,
        Vec3::new(1.0, f32::NAN, 0.0),
        Vec3::splat(1e-40),
    ] {
        assert_eq!(layout::pack_normal(none, 0.0), up, "{none} is stored as up");
    }
}
