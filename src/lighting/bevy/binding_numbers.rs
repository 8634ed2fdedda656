//! Binding numbers of Bevy's bind groups of the lighting shaders.

use crate::gpu::bindings::binding_numbers;

/// Bind group 0, the view: as in Bevy's `mesh_view_bindings.wgsl`.
pub mod view {
    super::binding_numbers! {
        VIEW = 0,
        LIGHTS = 1,
        POINT_SHADOW_TEXTURES = 2,
        POINT_SHADOW_TEXTURES_COMPARISON_SAMPLER = 3,
        POINT_SHADOW_TEXTURES_LINEAR_SAMPLER = 4,
        DIRECTIONAL_SHADOW_TEXTURES = 5,
        DIRECTIONAL_SHADOW_TEXTURES_COMPARISON_SAMPLER = 6,
        DIRECTIONAL_SHADOW_TEXTURES_LINEAR_SAMPLER = 7,
        CLUSTERED_LIGHTS = 8,
        CLUSTERABLE_OBJECT_INDEX_LISTS = 9,
        CLUSTER_OFFSETS_AND_COUNTS = 10,
        GLOBALS = 11,
        LIGHT_PROBES = 12,
        FOG = 13,
        VISIBILITY_RANGES = 14,
        SSR_SETTINGS = 15,
        CONTACT_SHADOWS_SETTINGS = 16,
        SCREEN_SPACE_AMBIENT_OCCLUSION_TEXTURE = 17,
        DT_LUT_TEXTURE = 18,
        DT_LUT_SAMPLER = 19,
        DEPTH_PREPASS_TEXTURE = 20,
        NORMAL_PREPASS_TEXTURE = 21,
        MOTION_VECTOR_PREPASS_TEXTURE = 22,
        DEFERRED_PREPASS_TEXTURE = 23,
        VIEW_TRANSMISSION_TEXTURE = 24,
        VIEW_TRANSMISSION_SAMPLER = 25,
        OIT_SETTINGS = 26,
        OIT_NODES_CAPACITY = 27,
        OIT_NODES = 28,
        OIT_HEADS = 29,
        OIT_ATOMIC_COUNTER = 30,
        ATMOSPHERE_TRANSMITTANCE_TEXTURE = 31,
        ATMOSPHERE_TRANSMITTANCE_SAMPLER = 32,
        ATMOSPHERE = 33,
        BLUE_NOISE_TEXTURE = 34,
        AREA_LIGHT_LUTS = 35,
        AREA_LIGHT_LUTS_SAMPLER = 36,
        DFG_LUT = 37,
        DFG_LUT_SAMPLER = 38,
    }

    /// Bindings that no lighting function reads.
    pub const UNUSED: &[u32] = &[
        VISIBILITY_RANGES,
        SSR_SETTINGS,
        DT_LUT_TEXTURE,
        DT_LUT_SAMPLER,
        NORMAL_PREPASS_TEXTURE,
        MOTION_VECTOR_PREPASS_TEXTURE,
        DEFERRED_PREPASS_TEXTURE,
        VIEW_TRANSMISSION_TEXTURE,
        VIEW_TRANSMISSION_SAMPLER,
        OIT_SETTINGS,
        OIT_NODES_CAPACITY,
        OIT_NODES,
        OIT_HEADS,
        OIT_ATOMIC_COUNTER,
    ];
}

/// Bind group 1, light probes and decals: as in Bevy's `mesh_view_bindings.wgsl`, with arrays.
pub mod arrays {
    super::binding_numbers! {
        DIFFUSE_ENVIRONMENT_MAPS = 0,
        SPECULAR_ENVIRONMENT_MAPS = 1,
        ENVIRONMENT_MAP_SAMPLER = 2,
        IRRADIANCE_VOLUMES = 3,
        IRRADIANCE_VOLUME_SAMPLER = 4,
        CLUSTERED_DECALS = 5,
        CLUSTERED_DECAL_TEXTURES = 6,
        CLUSTERED_DECAL_SAMPLER = 7,
    }
}
