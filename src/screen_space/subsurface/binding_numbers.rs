//! Where the shaders of subsurface scattering have what they bind; each pass binds a part. Names as in `bindings.wgsl`.

use crate::gpu::bindings::binding_numbers;

binding_numbers! {
    VIEW = 0,
    TILES = 1,
    TILES_TO_DISPATCH = 2,
    LIGHT_TEXTURE = 3,
    SCATTERED_TEXTURE = 4,
    LEVEL_OUTPUT = 5,
    NORMAL_TEXTURE = 6,
    PICTURE_TEXTURE = 7,
    OUTPUT_TEXTURE = 8,
}
