//! Binding numbers of the diffuse GI shaders; each pass binds a subset. Names as in `bindings.wgsl`.

use crate::gpu::bindings::binding_numbers;

binding_numbers! {
    VIEW = 0,
    DEPTH_TEXTURE = 1,
    NORMAL_TEXTURE = 2,
    DIFFUSE_LIGHT_TEXTURE = 3,
    MOTION_TEXTURE = 4,
    LAST_LEVELS = 5,
    LEVELS = 6,
    LEVEL_0 = 7,
    LEVEL_1 = 8,
    LEVEL_2 = 9,
    LEVEL_3 = 10,
    GATHERED_TEXTURE = 11,
    OUTPUT_TEXTURE = 12,
    PICTURE_TEXTURE = 13,
    DIFFUSE_LIGHT_OUTPUT = 14,
    SHOWN_EXPOSURE = 15,
}
