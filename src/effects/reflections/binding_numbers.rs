//! Binding numbers of the reflection shaders; each pass binds a subset. Names as in `bindings.wgsl`.

use crate::gpu::bindings::binding_numbers;

binding_numbers! {
    VIEW = 0,
    DEPTH_TEXTURE = 1,
    DEPTH_SAMPLER = 2,
    NORMAL_TEXTURE = 3,
    VALID_MASK_TEXTURE = 4,
    SPECIALIZATION_TEXTURE = 5,
    MOTION_TEXTURE = 6,
    HISTORY_TEXTURE = 7,
    HISTORY_SAMPLER = 8,
    HI_Z_TEXTURE = 9,
    HI_Z_OUTPUT = 10,
    SURFACES_TEXTURE = 11,
    SURFACES_OUTPUT = 12,
    RAYS_TEXTURE = 13,
    RAYS_OUTPUT = 14,
    HITS_TEXTURE = 15,
    HITS_OUTPUT = 16,
    FILTERED_TEXTURE = 17,
    FILTERED_OUTPUT = 18,
    OUTPUT_TEXTURE = 19,
    LOBES_TEXTURE = 20,
    LOBES_OUTPUT = 21,
}
