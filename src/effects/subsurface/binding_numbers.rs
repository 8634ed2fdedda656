//! Binding numbers of the subsurface scattering shaders; each pass binds a subset. Names as in `bindings.wgsl`.

use crate::gpu::bindings::binding_numbers;

binding_numbers! {
    VIEW = 0,
    TILES = 1,
    LIGHT_TEXTURE = 2,
    COARSER_TEXTURE = 3,
    LEVEL_OUTPUT = 4,
    NEXT_OUTPUT = 5,
    LAST_OUTPUT = 6,
    SCATTERED_TEXTURE = 7,
    SCATTERED_OUTPUT = 8,
    NORMAL_TEXTURE = 9,
    ENTERING_TEXTURE = 10,
    PICTURE_TEXTURE = 11,
    OUTPUT_TEXTURE = 12,
}
