//! Exhaustive checks of words on the device: they are too many for the host.

use super::MODULES;
use kit::compute::Compute;

/// Checks 2^12 words that differ in their lowest bits. Returns the number that do not survive, and one of them.
const CHECK: &str = "
#import bevy_lean_deferred::gbuffer::layout::light
#import bevy_lean_deferred::gbuffer::layout::specialization as special
#import bevy_lean_deferred::shading_models::{unlit}
fn emissive_survives(word: u32) -> bool {
    let light = light::unpack_light(word);
    let again = light::pack_light(light);
    // The smallest exponent, or a mantissa that fills its bits.
    let is_canonical = word < (1u << 27u) || (word & 0x4020100u) != 0u;
    let same_light = all(light::unpack_light(again) == light);
    return select(same_light, again == word, is_canonical);
}
fn unlit_survives(bits: u32) -> bool {
    let word = (bits & 0xffu) | (special::UNLIT << 8u) | ((bits & 0x1fffff00u) << 3u);
    let exponent = ((word >> 12u) & 7u) | ((word >> 31u) << 3u);
    let codes = vec3(word & 0xffu, (word >> 15u) & 0xffu, (word >> 23u) & 0xffu);
    // No darker colour has this exponent: 181 is the least root above the half of 255 squared.
    let is_canonical = exponent == 0u || max(codes.r, max(codes.g, codes.b)) >= 181u;
    let again = unlit::pack_unlit(unlit::unpack_unlit(word), word);
    return again == word || !is_canonical;
}
fn kernel(input: array<u32, 2>) -> array<u32, 2> {
    var lost = array(0u, 0u);
    for (var i = 0u; i < 4096u; i += 1u) {
        let word = (input[0] << 12u) | i;
        var survives: bool;
        if input[1] == 0u {
            survives = emissive_survives(word);
        } else {
            survives = unlit_survives(word);
        }
        if !survives {
            lost[0] += 1u;
            lost[1] = word;
        }
    }
    return lost;
}";

#[test]
fn every_word_of_a_color_survives_on_the_device() {
    let compute = Compute::new();
    let kernel = compute.kernel::<2, 2>(&MODULES, CHECK);
    // All bits of an emissive word; of an unlit one, all but the model's.
    for (name, bits, form) in [("emissive", 32, 0), ("unlit", 29, 1)] {
        let inputs: Vec<_> = (0..1u32 << (bits - 12)).map(|high| [high, form]).collect();
        let lost: Vec<_> = inputs
            .chunks(1 << 14)
            .flat_map(|inputs| kernel.run(inputs))
            .filter(|[count, _]| *count != 0)
            .collect();
        let count: u32 = lost.iter().map(|[count, _]| count).sum();
        println!("{name}: of 2^{bits} words {count} are lost");
        assert!(lost.is_empty(), "{name}: {:x?} is lost", lost[0][1]);
    }
}
