//! Binding numbers of the crate's own bind groups of the lighting shaders. `bevy/binding_numbers.rs` has the others.

use crate::gpu::bindings::binding_numbers;

/// Bind group 2, the G-buffer and the output: as in `bindings.wgsl`.
pub mod targets {
    super::binding_numbers! {
        SURFACE_TEXTURE = 0,
        NORMAL_TEXTURE = 1,
        OUTPUT_TEXTURE = 2,
        UNIFORMS = 3,
        NEAREST_SAMPLER = 4,
        OCCLUSION_TEXTURE = 5,
        EMISSIVE_TEXTURE = 7,
        SPECIALIZATION_TEXTURE = 8,
        MOTION_TEXTURE = 9,
        VISIBILITY_MASK_TEXTURE = 10,
        LIGHT_LAYERS = 11,
        VALID_MASK_TEXTURE = 12,
        DIFFUSE_LIGHT_TEXTURE = 13,
        INDIRECT_SPECULAR_TEXTURE = 14,
        INDIRECT_DIFFUSE_TEXTURE = 15,
        SUBSURFACE_LIGHT_TEXTURE = 16,
        SUBSURFACE_PICTURE_TEXTURE = 17,
        SCATTERING_TILES = 18,
    }
}

/// Bind group 3, on views with special surfaces: as in `tile_list.wgsl`.
pub mod list {
    super::binding_numbers! {
        DISPATCH = 0,
        LIST = 1,
    }
}
