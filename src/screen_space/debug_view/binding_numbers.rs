//! Where `debug_view.wgsl` has what it binds.

use crate::gpu::bindings::binding_numbers;

binding_numbers! {
    FOUND_TEXTURE = 0,
}
