//! Binding numbers of the auto exposure shaders; each pass binds a subset. Names as in `bindings.wgsl`.

use crate::gpu::bindings::binding_numbers;

binding_numbers! {
    VIEW = 0,
    PICTURE = 1,
    HISTOGRAM = 2,
    PARTIALS = 2,
    MASK = 3,
    MASK_SAMPLER = 4,
    STATE = 5,
    BEVY_VIEW = 6,
}
