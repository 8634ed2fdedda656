// What pixels mirror, in a texture of words: light, and the confidence with which it takes the place of the environment.
//
// A block of 16×16 pixels has 16 columns and 20 rows: 16 rows of light, a word for each pixel (`light.wgsl`), and below them four of
// confidences, a word for each 2×2 pixels, eight bits for one. Where confidence is 0 light may be anything.
#define_import_path bevy_lean_deferred::gbuffer::layout::indirect_specular

#import bevy_lean_deferred::gbuffer::layout::is_nan
#import bevy_lean_deferred::gbuffer::layout::light::unpack_light

/// Pixels a side of a block.
const BLOCK: u32 = 16u;
/// Rows that a block has more than it has of pixels.
const CONFIDENCE_ROWS: u32 = 4u;

/// Of the texture for so many pixels.
fn texture_size(viewport_size: vec2<u32>) -> vec2<u32> {
    return (viewport_size + BLOCK - 1u) / BLOCK * vec2(BLOCK, BLOCK + CONFIDENCE_ROWS);
}

/// Where the light of a pixel is.
fn light_place(pixel: vec2<u32>) -> vec2<u32> {
    return pixel + vec2(0u, pixel.y / BLOCK * CONFIDENCE_ROWS);
}

/// Where the confidences of the 2×2 pixels are of which `pixel` is one.
fn confidence_place(pixel: vec2<u32>) -> vec2<u32> {
    let square = pixel % BLOCK / 2u;
    // Two rows of eight squares beside one another.
    let place = vec2(square.x + 8u * (square.y & 1u), BLOCK + (square.y >> 1u));
    return pixel / BLOCK * vec2(BLOCK, BLOCK + CONFIDENCE_ROWS) + place;
}

/// Which of the 2×2 pixels `pixel` is.
fn place_in_square(pixel: vec2<u32>) -> u32 {
    return (pixel.x & 1u) + 2u * (pixel.y & 1u);
}

/// The confidence of `specular`, 0 to 1, as it is kept; 0 if their sum is no number.
fn confidence_of(specular: vec4<f32>) -> f32 {
    let is_number = !is_nan(specular.r + specular.g + specular.b + specular.a);
    return select(0.0, saturate(specular.a), is_number);
}

/// Of 2×2 pixels, in the order of `place_in_square`.
fn pack_confidences(confidences: vec4<f32>) -> u32 {
    return pack4x8unorm(confidences);
}

/// Light and confidence of a pixel.
fn unpack_specular(texture: texture_2d<u32>, pixel: vec2<u32>) -> vec4<f32> {
    let light = textureLoad(texture, light_place(pixel), 0).r;
    let confidences = textureLoad(texture, confidence_place(pixel), 0).r;
    let confidence = f32((confidences >> (8u * place_in_square(pixel))) & 0xffu) / 255.0;
    return select(vec4(0.0), vec4(unpack_light(light), confidence), confidence > 0.0);
}
