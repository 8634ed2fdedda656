//! Where the shaders of subsurface scattering have what they bind; each pass binds a part. Names as in `bindings.wgsl`.

use crate::gpu::bindings::binding_numbers;

binding_numbers! {
    VIEW = 0,
    TILES = 1,
    TILES_TO_DISPATCH = 2,
    LIGHT_TEXTURE = 3,
    SCATTERED_TEXTURE = 4,
    COARSER_TEXTURE = 5,
    LEVEL_OUTPUT = 6,
    NEXT_OUTPUT = 7,
    NORMAL_TEXTURE = 8,
    PICTURE_TEXTURE = 9,
    OUTPUT_TEXTURE = 10,
}
