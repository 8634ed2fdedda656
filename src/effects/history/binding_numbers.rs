//! Binding numbers of `levels.wgsl`. Names as there.

use crate::gpu::bindings::binding_numbers;

binding_numbers! {
    COLOR_TEXTURE = 0,
    LEVEL_0 = 1,
    LEVEL_1 = 2,
    LEVEL_2 = 3,
    LEVEL_3 = 4,
    VIEW = 5,
    DEPTH_TEXTURE = 6,
    SHOWN_EXPOSURE = 7,
}
