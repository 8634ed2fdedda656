//! Where the shaders of subsurface scattering have what they bind; each pass binds a part. Names as in `bindings.wgsl`.

use crate::gpu::bindings::binding_numbers;

binding_numbers! {
    VIEW = 0,
    TILES = 1,
    LIGHT_TEXTURE = 2,
    PICTURE_TEXTURE = 3,
    DEPTH_TEXTURE = 4,
    OUTPUT_TEXTURE = 5,
    LEVEL_0 = 6,
    LEVEL_1 = 7,
    LEVEL_2 = 8,
    LEVEL_3 = 9,
    ACROSS_TEXTURE = 10,
    ACROSS_OUTPUT = 11,
}
