// Subsurface scattering: light enters a surface and leaves it elsewhere.
//
// | bits, low to high | |
// |---|---|
// | 4, 3, 3 | colour R, G, B (square roots) |
// | 6 | mean free path, 0.1 mm to 1 m (logarithmic) |
// | 1 | the base colour is applied before light scatters |
//
// The mean free path is off by at most 7.6%. That of a channel is its product with the colour, whose square root is off by 1/30
// (red) or 1/14 (green, blue).
#define_import_path bevy_lean_deferred::shading_models::subsurface

#import bevy_lean_deferred::gbuffer::layout::{is_nan, quantize, quantize_roots}

const LEAST_PATH_LOG: f32 = -13.287713;
/// Largest codes of the colour.
const STEPS: vec3<f32> = vec3(15.0, 7.0, 7.0);

/// Packs the arguments of subsurface scattering: colour 0 to 1, mean free path in metres. `colors_before` applies the base colour
/// before light scatters.
fn pack_subsurface(color: vec3<f32>, mean_free_path: f32, colors_before: bool) -> u32 {
    let codes = quantize_roots(color, STEPS);
    let valid = select(mean_free_path, 0.0, is_nan(mean_free_path));
    let path = 1.0 - log2(max(valid, 1e-30)) / LEAST_PATH_LOG;
    let packed = codes.r | (codes.g << 4u) | (codes.b << 7u) | (quantize(path, 63.0) << 10u);
    return packed | select(0u, 1u << 16u, colors_before);
}

/// Colour of scattered light, 0 to 1.
fn unpack_subsurface_color(arguments: u32) -> vec3<f32> {
    let codes = vec3(arguments & 0xfu, (arguments >> 4u) & 0x7u, (arguments >> 7u) & 0x7u);
    let root = vec3<f32>(codes) / STEPS;
    return root * root;
}

/// Mean free path of scattered light in metres, 0.1 mm to 1 m.
fn unpack_subsurface_path(arguments: u32) -> f32 {
    let code = f32((arguments >> 10u) & 0x3fu);
    return exp2((1.0 - code / 63.0) * LEAST_PATH_LOG);
}

/// True if the base colour is applied before light scatters.
fn unpack_subsurface_colors_before(arguments: u32) -> bool {
    return ((arguments >> 16u) & 1u) != 0u;
}
