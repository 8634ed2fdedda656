//! Where the shaders of the G-buffer have what they bind.

use crate::gpu::bindings::binding_numbers;

/// Of `resolve_motion.wgsl`.
pub mod resolve_motion {
    super::binding_numbers! {
        VIEW = 0,
        PREVIOUS_VIEW = 1,
        DEPTH_TEXTURE = 2,
        NORMAL_TEXTURE = 3,
        EARLIER_DEPTH_TEXTURE = 3,
        MOTION_TEXTURE = 4,
        WRITTEN_TEXTURE = 5,
    }
}
