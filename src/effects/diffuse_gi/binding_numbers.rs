//! Binding numbers of the diffuse GI shaders; each pass binds a subset. Names as in `bindings.wgsl`.

use crate::gpu::bindings::binding_numbers;

binding_numbers! {
    VIEW = 0,
    DEPTH_TEXTURE = 1,
    NORMAL_TEXTURE = 2,
    DIFFUSE_LIGHT_TEXTURE = 3,
    MOTION_TEXTURE = 4,
    SHOWN_EXPOSURE = 5,
    LAST_LEVELS = 6,
    LEVELS = 7,
    LEVEL_0 = 8,
    LEVEL_1 = 9,
    LEVEL_2 = 10,
    LEVEL_3 = 11,
    GATHERED_TEXTURE = 12,
    GATHERED_OUTPUT = 13,
    OUTPUT_TEXTURE = 14,
    PICTURE_TEXTURE = 15,
    DIFFUSE_LIGHT_OUTPUT = 16,
}
