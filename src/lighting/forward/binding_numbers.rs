//! Binding numbers of the crate's own bind group of meshes that Bevy's passes draw.

use crate::gpu::bindings::binding_numbers;

/// The bind group, after Bevy's four.
pub const OWN_GROUP: usize = 4;

binding_numbers! {
    LIGHT_LAYERS = 0,
    REFLECTIONS = 1,
    HI_Z_TEXTURE = 2,
    HISTORY_TEXTURE = 3,
    HISTORY_SAMPLER = 4,
}
