//! Binding numbers of `debug_view.wgsl`.

use crate::gpu::bindings::binding_numbers;

binding_numbers! {
    SOURCE_TEXTURE = 0,
    VIEW = 1,
}
