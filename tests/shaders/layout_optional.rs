//! The bit tables of the optional targets: the shipped WGSL on the device against its Rust twin, and the loss of storing.

mod accuracy;
mod anisotropy;
mod every_word;
mod forms;
mod packing;

use bevy::math::Vec3;
use bevy_lean_deferred::gbuffer::GBufferTargets;
use forms::{FORMS, Form, VALUES};
use kit::{
    compute::{Compute, Kernel},
    random::Random,
    reference::shader_library::layout::{self, light, specialization},
    shipped_wgsl,
    wgsl::WgslModule,
};

const MODULES: [WgslModule; 16] = [
    shipped_wgsl!("shader_library/layout.wgsl"),
    shipped_wgsl!("shader_library/layout/light.wgsl"),
    shipped_wgsl!("shader_library/layout/specialization.wgsl"),
    stand_in("#define_import_path bevy_pbr::pbr_types"),
    stand_in("#define_import_path bevy_pbr::mesh_types"),
    stand_in("#define_import_path bevy_pbr::clustered_forward"),
    stand_in("#define_import_path bevy_pbr::mesh_view_bindings"),
    stand_in("#define_import_path bevy_lean_deferred::lighting::lights::environment"),
    stand_in("#define_import_path bevy_pbr::lighting"),
    stand_in("#define_import_path bevy_lean_deferred::lighting::lights::irradiance_volumes"),
    shipped_wgsl!("shading_models/anisotropy.wgsl"),
    shipped_wgsl!("shading_models/clearcoat.wgsl"),
    shipped_wgsl!("shading_models/diffuse_transmission.wgsl"),
    shipped_wgsl!("shading_models/rim.wgsl"),
    shipped_wgsl!("shading_models/subsurface.wgsl"),
    shipped_wgsl!("shading_models/unlit.wgsl"),
];

/// Replaces a module that only lighting imports.
const fn stand_in(source: &'static str) -> WgslModule {
    WgslModule {
        path: "a stand-in",
        source,
    }
}

/// Inputs of one dispatch.
const BATCH: usize = 1 << 20;

const UNPACK: &str = "
fn kernel(input: array<u32, 4>) -> array<u32, 5> {
    let normal = bitcast<vec3<f32>>(vec3(input[1], input[2], input[3]));
    let x = unpacked(input[0], normal);
    let again = packed(array(x.x, x.y, x.z, x.w, normal.x, normal.y, normal.z));
    let bits = bitcast<vec4<u32>>(x);
    return array(bits.x, bits.y, bits.z, bits.w, again);
}";

/// A unit normal that the G-buffer stores; every eighth has a z of 0, near 0 or near -1, or has rounded components.
fn stored_normal(random: &mut Random) -> Vec3 {
    let mut part = || random.range(-1.0, 1.0);
    let (x, y, z) = (part(), part(), part());
    let normal = match random.below(32) {
        0 => Vec3::new(x, y, 0.0),
        1 => Vec3::new(x, y, z * 1e-3),
        2 => Vec3::new(x * 1e-3, y * 1e-3, -1.0),
        3 => Vec3::new(x, y, z).round(),
        _ => Vec3::new(x, y, z),
    };
    layout::unpack_normal(layout::pack_normal(normal, 0.0))
}

/// Checks that device and twin decode `words` alike, and that both pack them again unchanged.
fn check_round_trip(form: &Form, kernel: &Kernel<4, 5>, words: &[u32], random: &mut Random) {
    for words in words.chunks(BATCH) {
        let inputs: Vec<(u32, Vec3)> = words
            .iter()
            .map(|&word| (word, stored_normal(random)))
            .collect();
        let bits: Vec<_> = inputs
            .iter()
            .map(|(word, n)| [*word, n.x.to_bits(), n.y.to_bits(), n.z.to_bits()])
            .collect();
        for ((word, normal), device) in inputs.into_iter().zip(kernel.run(&bits)) {
            let twin = (form.unpack)(word, normal);
            for (i, twin) in twin.into_iter().enumerate() {
                let device = f32::from_bits(device[i]);
                let error = (device - twin).abs();
                assert!(
                    error <= form.decode_tolerance * twin.abs().max(form.decode_least),
                    "value {i} of {} {word:08x}: {device:e} on the device, {twin:e} by the twin",
                    form.name,
                );
            }
            let [x, y, z, w] = twin;
            let again = (form.pack)([x, y, z, w, normal.x, normal.y, normal.z]);
            for again in [again, device[4]] {
                assert_eq!(again, word, "{} {word:08x} became {again:08x}", form.name);
            }
        }
    }
}

#[test]
fn every_code_survives_unpacking_and_packing() {
    let compute = Compute::new();
    for (i, form) in FORMS.iter().enumerate() {
        let kernel = compute.kernel(&MODULES, &form.kernel(UNPACK));
        let mut random = Random::new(i as u64);
        let words = (form.words)(&mut random);
        check_round_trip(form, &kernel, &words, &mut random);
        println!("{}: {} words survive", form.name, words.len());
    }
}

#[test]
fn lightmaps_have_bits_of_the_valid_mask_to_themselves() {
    let targets = u32::from(GBufferTargets::all().bits());
    assert_eq!(targets & layout::LIGHTMAP_BITS, 0);
    assert!(targets | layout::LIGHTMAP_BITS <= u32::from(u8::MAX));
    let forms = [layout::LIGHTMAP_INCIDENT, layout::LIGHTMAP_REFLECTED];
    assert_eq!(forms[0] & forms[1], 0);
    assert_eq!(forms[0] | forms[1], layout::LIGHTMAP_BITS);
}

#[test]
fn words_of_0_are_defaults() {
    use specialization as special;
    assert_eq!(light::unpack_light(0), Vec3::ZERO);
    assert_eq!(light::pack_light(Vec3::ZERO), 0);
    assert_eq!(special::unpack_reflectance(0), 0.5);
    assert_eq!(special::unpack_shading_model(0), 0);
    assert_eq!(special::unpack_arguments(0), 0);
    assert_eq!(special::pack_specialization(0.5, 0, 0), 0);

    // On the device.
    let compute = Compute::new();
    let up = [0, 0f32.to_bits(), 1f32.to_bits(), 0f32.to_bits()];
    for (name, expected) in [
        ("emissive", [0.0; VALUES]),
        ("specialization", [0.5, 0.0, 0.0, 0.0]),
    ] {
        let form = forms::named(name);
        let kernel = compute.kernel(&MODULES, &form.kernel(UNPACK));
        let [x, y, z, w, again] = kernel.run(&[up])[0];
        assert_eq!([x, y, z, w].map(f32::from_bits), expected, "{name}");
        assert_eq!(again, 0, "{name}");
    }
}
