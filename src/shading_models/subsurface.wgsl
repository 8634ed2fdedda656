// Light that enters scatters and leaves elsewhere. Twin of `subsurface.rs`, which has the bit table, under the same names.
#define_import_path bevy_lean_deferred::shading_models::subsurface

#import bevy_lean_deferred::gbuffer::layout::{is_nan, quantize, quantize_roots}

const LEAST_PATH_LOG: f32 = -13.287713;

/// Packs the arguments of subsurface scattering: colour 0 to 1, mean free path in metres.
fn pack_subsurface(color: vec3<f32>, mean_free_path: f32) -> u32 {
    let codes = quantize_roots(color, vec3(15.0, 15.0, 7.0));
    let valid = select(mean_free_path, 0.0, is_nan(mean_free_path));
    let path = 1.0 - log2(max(valid, 1e-30)) / LEAST_PATH_LOG;
    return codes.r | (codes.g << 4u) | (codes.b << 8u) | (quantize(path, 63.0) << 11u);
}

/// Colour of scattered light, 0 to 1.
fn unpack_subsurface_color(arguments: u32) -> vec3<f32> {
    let codes = vec3(arguments & 0xfu, (arguments >> 4u) & 0xfu, (arguments >> 8u) & 0x7u);
    let root = vec3<f32>(codes) / vec3(15.0, 15.0, 7.0);
    return root * root;
}

/// Mean free path of scattered light in metres, 0.1 mm to 1 m.
fn unpack_subsurface_path(arguments: u32) -> f32 {
    let code = f32((arguments >> 11u) & 0x3fu);
    return exp2((1.0 - code / 63.0) * LEAST_PATH_LOG);
}
