//! Binding numbers of the subsurface scattering shaders; each pass binds a subset. Names as in `bindings.wgsl`.

use crate::gpu::bindings::binding_numbers;

binding_numbers! {
    VIEW = 0,
    TILES = 1,
    LIGHT_TEXTURE = 2,
    SCATTERED_TEXTURE = 3,
    COARSER_TEXTURE = 4,
    LEVEL_OUTPUT = 5,
    NEXT_OUTPUT = 6,
    NORMAL_TEXTURE = 7,
    PICTURE_TEXTURE = 8,
    OUTPUT_TEXTURE = 9,
    ENTERING_TEXTURE = 10,
    LAST_OUTPUT = 11,
}
