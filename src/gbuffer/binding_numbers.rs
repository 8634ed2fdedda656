//! Binding numbers of the G-buffer's shaders.

use crate::gpu::bindings::binding_numbers;

/// Bindings of `pack.wgsl`.
pub mod pack {
    /// Bind group of the masks. Bevy's prepass pipelines have an empty one at this index.
    pub const VISIBILITY_MASK_GROUP: usize = 1;

    super::binding_numbers! {
        MESH_VISIBILITY_MASK = 0,
    }
}

/// Bindings of `resolve_motion.wgsl`.
pub mod resolve_motion {
    super::binding_numbers! {
        VIEW = 0,
        PREVIOUS_VIEW = 1,
        DEPTH_TEXTURE = 2,
        NORMAL_TEXTURE = 3,
        EARLIER_DEPTH_TEXTURE = 3,
        MOTION_TEXTURE = 4,
        VALID_MASK_TEXTURE = 5,
    }
}
