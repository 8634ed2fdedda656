// Diffuse transmission of light that falls on the back.
//
// | bits, low to high | |
// |---|---|
// | 7 | diffuse transmission |
// | 9 | thickness: 0, or logarithmic, 1 µm to 4 km |
// | 1 | receives transmitted shadows |
//
// The thickness is off by at most 2.2%.
#define_import_path bevy_lean_deferred::shading_models::diffuse_transmission

#import bevy_lean_deferred::gbuffer::layout::{is_nan, quantize}

const THICKNESS_STEPS: f32 = 16.0;
const LEAST_THICKNESS_LOG: f32 = -20.0;

/// Packs the arguments of diffuse transmission: transmission 0 to 1, thickness in metres.
fn pack_diffuse_transmission(transmission: f32, thickness: f32, receives_shadows: bool) -> u32 {
    let valid = select(thickness, 0.0, is_nan(thickness));
    let exponent = (log2(max(valid, 1e-30)) - LEAST_THICKNESS_LOG) * THICKNESS_STEPS + 1.5;
    return quantize(transmission, 127.0)
        | (u32(clamp(exponent, 0.0, 511.0)) << 7u)
        | select(0u, 1u << 16u, receives_shadows);
}

/// Share of light that is transmitted, 0 to 1.
fn unpack_transmission(arguments: u32) -> f32 {
    return f32(arguments & 0x7fu) / 127.0;
}

/// Thickness in metres.
fn unpack_thickness(arguments: u32) -> f32 {
    let code = (arguments >> 7u) & 0x1ffu;
    let thickness = exp2((f32(code) - 1.0) / THICKNESS_STEPS + LEAST_THICKNESS_LOG);
    return select(thickness, 0.0, code == 0u);
}

/// True if transmitted light is shadowed.
fn unpack_receives_shadows(arguments: u32) -> bool {
    return (arguments >> 16u) != 0u;
}

#ifdef STANDARD_MATERIAL_DIFFUSE_TRANSMISSION
#import bevy_pbr::{mesh_types::MESH_FLAGS_TRANSMITTED_SHADOW_RECEIVER_BIT, pbr_types::PbrInput}

/// Packed arguments of `pbr`.
fn arguments_of(pbr: PbrInput, normal_word: u32) -> u32 {
    let receives_shadows = (pbr.flags & MESH_FLAGS_TRANSMITTED_SHADOW_RECEIVER_BIT) != 0u;
    return pack_diffuse_transmission(
        pbr.material.diffuse_transmission,
        pbr.material.thickness,
        receives_shadows,
    );
}

/// Unpacks `arguments` into the input of lighting.
fn specialize(pbr: ptr<function, PbrInput>, arguments: u32) {
    (*pbr).material.diffuse_transmission = unpack_transmission(arguments);
    (*pbr).material.thickness = unpack_thickness(arguments);
    if unpack_receives_shadows(arguments) {
        (*pbr).flags |= MESH_FLAGS_TRANSMITTED_SHADOW_RECEIVER_BIT;
    }
}
#endif
