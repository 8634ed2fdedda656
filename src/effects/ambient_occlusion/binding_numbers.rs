//! Binding numbers of the ambient occlusion shaders; each pass binds a subset. Names as in `bindings.wgsl`.

use crate::gpu::bindings::binding_numbers;

binding_numbers! {
    VIEW = 0,
    DEPTH_TEXTURE = 1,
    NEAREST_SAMPLER = 2,
    NORMAL_TEXTURE = 3,
    OUTPUT_TEXTURE = 4,
    OCCLUSION_TEXTURE = 5,
    SPARSE_DEPTH_TEXTURE = 6,
    SPARSE_DEPTH_OUTPUT = 7,
}
