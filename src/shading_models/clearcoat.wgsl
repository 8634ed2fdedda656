// A second, clear layer.
//
// | bits, low to high | |
// |---|---|
// | 8 | strength |
// | 8 | perceptual roughness |
#define_import_path bevy_lean_deferred::shading_models::clearcoat

#import bevy_lean_deferred::gbuffer::layout::quantize

/// Packs the arguments of clearcoat, both 0 to 1.
fn pack_clearcoat(strength: f32, perceptual_roughness: f32) -> u32 {
    return quantize(strength, 255.0) | (quantize(perceptual_roughness, 255.0) << 8u);
}

/// Strength of clearcoat, 0 to 1.
fn unpack_clearcoat_strength(arguments: u32) -> f32 {
    return f32(arguments & 0xffu) / 255.0;
}

/// Perceptual roughness of clearcoat, 0 to 1.
fn unpack_clearcoat_roughness(arguments: u32) -> f32 {
    return f32((arguments >> 8u) & 0xffu) / 255.0;
}

#ifdef STANDARD_MATERIAL_CLEARCOAT
#import bevy_pbr::pbr_types::PbrInput

/// Packed arguments of `pbr`.
fn arguments_of(pbr: PbrInput, normal_word: u32) -> u32 {
    return pack_clearcoat(pbr.material.clearcoat, pbr.material.clearcoat_perceptual_roughness);
}

/// Unpacks `arguments` into the input of lighting.
fn specialize(pbr: ptr<function, PbrInput>, arguments: u32) {
    (*pbr).material.clearcoat = unpack_clearcoat_strength(arguments);
    (*pbr).material.clearcoat_perceptual_roughness = unpack_clearcoat_roughness(arguments);
    (*pbr).clearcoat_N = (*pbr).N;
}
#endif
