//! Binding numbers of the reflection shaders; each pass binds a subset. Names as in `bindings.wgsl`.

use crate::gpu::bindings::binding_numbers;

binding_numbers! {
    VIEW = 0,
    DEPTH_TEXTURE = 1,
    NORMAL_TEXTURE = 2,
    WRITTEN_TEXTURE = 3,
    SPECIALIZATION_TEXTURE = 4,
    MOTION_TEXTURE = 5,
    HISTORY_TEXTURE = 6,
    HISTORY_SAMPLER = 7,
    CELLS_TEXTURE = 8,
    CELLS_OUTPUT = 9,
    RAYS_TEXTURE = 10,
    HITS_TEXTURE = 11,
    RAYS_OUTPUT = 12,
    HITS_OUTPUT = 13,
    OUTPUT_TEXTURE = 14,
    DEPTH_SAMPLER = 15,
    LOBES_TEXTURE = 16,
    LOBES_OUTPUT = 17,
    SURFACES_TEXTURE = 18,
    SURFACES_OUTPUT = 19,
}
