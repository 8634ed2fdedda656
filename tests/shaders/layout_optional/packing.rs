//! Device and twin pack the same words, for any input.

use bevy::math::Vec3;
use bevy_lean_deferred::shading_models::MODELS;

use super::{
    BATCH, MODULES,
    forms::{FORMS, Field, Form, Values, named},
    stored_normal,
};
use kit::{
    compute::Compute,
    random::Random,
    reference::{
        shader_library::layout::{light, specialization as special},
        shading_models::{diffuse_transmission, rim, subsurface, unlit},
    },
};

const PACK: &str = "
fn kernel(bits: array<u32, 7>) -> array<u32, 1> {
    let x = bitcast<vec4<f32>>(vec4(bits[0], bits[1], bits[2], bits[3]));
    let normal = bitcast<vec3<f32>>(vec3(bits[4], bits[5], bits[6]));
    return array(packed(array(x.x, x.y, x.z, x.w, normal.x, normal.y, normal.z)));
}";

/// Values that shaders should not receive, and those at which a formula changes.
const HOSTILE: [f32; 38] = [
    f32::NAN,
    -f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    1e30,
    -1e30,
    1e6,
    65504.0,
    65408.004,
    65408.0,
    65280.0,
    32768.004,
    32768.0,
    512.0,
    511.5,
    511.49997,
    2.0,
    1.0 + f32::EPSILON,
    1.0,
    1.0 - f32::EPSILON,
    0.5,
    0.25,
    -1.0,
    1e-4,
    1e-6,
    1.525_878_9e-5,
    5.960_464_5e-8,
    2.980_232_2e-8,
    2.980_232e-8,
    1e-30,
    -1e-30,
    1e-38,
    -1e-38,
    1e-45,
    0.0,
    -0.0,
];

fn with_normal([x, y, z, w]: [f32; 4], random: &mut Random) -> Values {
    let n = stored_normal(random);
    [x, y, z, w, n.x, n.y, n.z]
}

fn hostile_values(random: &mut Random) -> Vec<Values> {
    let mut all = Vec::new();
    for (i, a) in HOSTILE.into_iter().enumerate() {
        for (j, b) in HOSTILE.into_iter().enumerate() {
            for (k, c) in HOSTILE.into_iter().enumerate() {
                let mixed = HOSTILE[(i + j + k) % HOSTILE.len()];
                all.push(with_normal([a, b, c, mixed], random));
            }
        }
    }
    all
}

/// Values over the whole range, and beyond it.
fn random_values(random: &mut Random, count: usize) -> Vec<Values> {
    let value = |random: &mut Random| match random.below(4) {
        0 => 0.0,
        1 => 10f32.powf(random.range(-9.0, 6.0)),
        _ => random.range(-0.05, 1.05),
    };
    (0..count)
        .map(|_| {
            let mut values = [0; 4].map(|_| value(random));
            if random.below(2) == 0 {
                // Tangents may have any sign and length.
                let scale = 10f32.powf(random.range(-20.0, 20.0));
                values[1..].fill_with(|| random.range(-scale, scale));
            }
            with_normal(values, random)
        })
        .collect()
}

/// Powers of two, the middles between two mantissas of nine bits, and the numbers next to them.
fn mantissa_ties(random: &mut Random) -> Vec<Values> {
    let mut all = Vec::new();
    for exponent in -28..20 {
        for half_mantissa in 512..1024u32 {
            let tie = half_mantissa as f32 * 2f32.powi(exponent - 9);
            for value in [tie.next_down(), tie, tie.next_up()] {
                let below = value * random.unit();
                let mut rgb = [value, below, 0.0];
                rgb.rotate_left(random.below(3));
                all.push(with_normal([rgb[0], rgb[1], rgb[2], 0.0], random));
            }
        }
    }
    all
}

/// Values at which the twin's code changes, and the numbers next to them.
fn field_ties(form: &Form, field: &Field, random: &mut Random) -> Vec<Values> {
    let values = |x: f32| {
        let mut values = [0.0; 7];
        values[field.value] = x;
        values
    };
    let mut all = Vec::new();
    for code in 0..field.largest() {
        let decoded = |code: u32| (form.unpack)(code << field.shift, Vec3::Y)[field.value];
        let (mut low, mut high) = (decoded(code), decoded(code + 1));
        let first = field.code((form.pack)(values(low)));
        while low.next_up() < high {
            let middle = 0.5 * (low + high);
            if !(low..high).contains(&middle) || middle == low {
                break;
            }
            if field.code((form.pack)(values(middle))) == first {
                low = middle;
            } else {
                high = middle;
            }
        }
        for x in [low.next_down(), low, high, high.next_up()] {
            let [x, y, z, w, ..] = values(x);
            all.push(with_normal([x, y, z, w], random));
        }
    }
    all
}

/// Makes numbers of models and flags valid: they are never hostile.
fn with_whole_numbers(form: &Form, mut values: Values, random: &mut Random) -> Values {
    match form.name {
        "specialization" => {
            values[1] = random.below(8) as f32;
            values[2] = (random.below(16) << 11) as f32;
            values[3] = random.below(1 << special::ARGUMENT_BITS) as f32;
        }
        "unlit" => values[3] = (random.bits() & special::NO_FOG) as f32,
        _ => {}
    }
    values
}

/// Checks that `device` and `twin` are equal except for values near the middle between two codes. Returns true if such values made a
/// difference.
fn is_tie(form: &Form, values: &Values, device: u32, twin: u32) -> Result<bool, String> {
    let mut left = device ^ twin;
    for field in form.fields {
        left &= !(field.largest() << field.shift);
        let codes = [device, twin].map(|word| i64::from(field.code(word)));
        let steps = (codes[0] - codes[1]).unsigned_abs();
        if steps == 0 {
            continue;
        }
        let tie = (field.tie)(values);
        let place = (field.place)(f64::from(values[field.value]), values);
        let distance = (place.rem_euclid(1.0) - 0.5).abs();
        let is_next = steps == 1 || field.wraps && steps == u64::from(field.largest());
        if tie < f64::INFINITY && (!is_next || distance > tie || distance.is_nan()) {
            return Err(format!(
                "{} {values:?}: {codes:?} at {}, {distance} steps from a tie",
                form.name, field.shift
            ));
        }
    }
    if left != 0 {
        return Err(format!(
            "{} {values:?}: {device:08x} on the device, {twin:08x} by the twin",
            form.name
        ));
    }
    Ok(device != twin)
}

#[test]
fn device_and_twin_pack_alike() {
    let compute = Compute::new();
    for (i, form) in FORMS.iter().enumerate() {
        let kernel = compute.kernel::<7, 1>(&MODULES, &form.kernel(PACK));
        let mut random = Random::new(100 + i as u64);
        let single = form.fields.iter().filter(|field| !field.wraps);
        let ties: Vec<_> = single
            .flat_map(|field| field_ties(form, field, &mut random))
            .collect();
        for (name, inputs) in [
            ("hostile", hostile_values(&mut random)),
            ("random", random_values(&mut random, 400_000)),
            ("mantissas", mantissa_ties(&mut random)),
            ("ties", ties),
        ] {
            let inputs: Vec<_> = inputs
                .into_iter()
                .map(|values| with_whole_numbers(form, values, &mut random))
                .collect();
            let bits: Vec<_> = inputs.iter().map(|x| x.map(f32::to_bits)).collect();
            let device = bits.chunks(BATCH).flat_map(|bits| kernel.run(bits));
            let (mut tie_count, mut found) = (0, Vec::new());
            for (values, [device]) in inputs.iter().zip(device) {
                let twin = (form.pack)(*values);
                for word in [device, twin] {
                    let normal = Vec3::new(values[4], values[5], values[6]);
                    let decoded = (form.unpack)(word, normal);
                    assert!(
                        decoded.iter().all(|x| x.is_finite()),
                        "{} {values:?} became {decoded:?}",
                        form.name
                    );
                }
                match is_tie(form, values, device, twin) {
                    Ok(tie) => tie_count += usize::from(tie),
                    Err(error) => found.push(error),
                }
            }
            let count = inputs.len();
            println!("{}, {name}: {tie_count} ties among {count}", form.name);
            assert!(
                found.is_empty(),
                "{} differ:\n{}",
                found.len(),
                found[..found.len().min(10)].join("\n")
            );
            assert!(
                name == "ties" || tie_count <= count / 500,
                "{tie_count} are too many to be ties"
            );
        }
    }
}

/// Each bit is set for some values, and none beyond them.
#[test]
fn arguments_take_the_bits_of_the_table() {
    let values = hostile_values(&mut Random::new(99));
    for model in MODELS.iter().filter(|model| model.argument_bits > 0) {
        let form = named(&model.name.to_lowercase());
        let words = values.iter().map(|values| (form.pack)(*values));
        let used = words.fold(0u32, |used, word| used | word);
        assert_eq!(used, (1 << model.argument_bits) - 1, "{}", form.name);
    }
}

#[test]
fn what_cannot_be_stored_is_replaced() {
    let light = |r, g, b| light::unpack_light(light::pack_light(Vec3::new(r, g, b)));
    assert_eq!(light(1.0, f32::NAN, 2.0), Vec3::ZERO);
    assert_eq!(light(f32::INFINITY, f32::NEG_INFINITY, 0.0), Vec3::ZERO);
    assert_eq!(light(-1.0, 4.0, -f32::MAX), Vec3::new(0.0, 4.0, 0.0));
    let brightest = light::LARGEST_LIGHT;
    assert_eq!(
        light(1e6, 0.0, f32::INFINITY),
        Vec3::new(brightest, 0.0, brightest)
    );
    assert_eq!(light(0.0, 65504.0, 0.0), Vec3::new(0.0, brightest, 0.0));

    let unlit = |r, g, b| unlit::unpack_unlit(unlit::pack_unlit(Vec3::new(r, g, b), 0));
    assert_eq!(unlit(f32::NAN, 1.0, 1.0), Vec3::ZERO);
    let brightest = unlit::LARGEST_UNLIT;
    assert_eq!(
        unlit(1e6, -1.0, f32::INFINITY),
        Vec3::new(brightest, 0.0, brightest)
    );

    for (reflectance, stored) in [(f32::NAN, 0.0), (-1.0, 0.0), (f32::INFINITY, 2.0)] {
        let word = special::pack_specialization(reflectance, 0, 0);
        assert_eq!(special::unpack_reflectance(word), stored);
    }
    for (thickness, stored) in [(f32::NAN, 0.0), (-1.0, 0.0), (0.0, 0.0), (1e-7, 0.0)] {
        let arguments = diffuse_transmission::pack_diffuse_transmission(0.0, thickness, false);
        assert_eq!(diffuse_transmission::unpack_thickness(arguments), stored);
    }
    for far in [4e3, f32::INFINITY] {
        let arguments = diffuse_transmission::pack_diffuse_transmission(0.0, far, false);
        assert_eq!(
            diffuse_transmission::unpack_thickness(arguments),
            2f32.powf(11.875)
        );
    }
    for (exponent, stored) in [(f32::NAN, 1.0), (-1.0, 1.0), (f32::INFINITY, 16.0)] {
        let arguments = rim::pack_rim(Vec3::ZERO, exponent);
        assert_eq!(rim::unpack_rim_exponent(arguments), stored);
    }
    for (path, stored) in [
        (f32::NAN, 1e-4),
        (-1.0, 1e-4),
        (0.0, 1e-4),
        (f32::INFINITY, 1.0),
    ] {
        let arguments = subsurface::pack_subsurface(Vec3::ZERO, path, true);
        let error = subsurface::unpack_subsurface_path(arguments) / stored - 1.0;
        assert!(
            error.abs() < 1e-6,
            "{path} is stored with an error of {error}"
        );
    }
}
