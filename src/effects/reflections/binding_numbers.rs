//! Binding numbers of the reflection shaders; each pass binds a subset. Names as in `bindings.wgsl`.

use crate::gpu::bindings::binding_numbers;

binding_numbers! {
    VIEW = 0,
    DEPTH_TEXTURE = 1,
    NORMAL_TEXTURE = 2,
    VALID_MASK_TEXTURE = 3,
    SPECIALIZATION_TEXTURE = 4,
    MOTION_TEXTURE = 5,
    HISTORY_TEXTURE = 6,
    HISTORY_SAMPLER = 7,
    HI_Z_TEXTURE = 8,
    HI_Z_OUTPUT = 9,
    RAYS_TEXTURE = 10,
    HITS_TEXTURE = 11,
    RAYS_OUTPUT = 12,
    HITS_OUTPUT = 13,
    OUTPUT_TEXTURE = 14,
    DEPTH_SAMPLER = 15,
    FILTERED_TEXTURE = 16,
    FILTERED_OUTPUT = 17,
    SURFACES_TEXTURE = 18,
    SURFACES_OUTPUT = 19,
}
