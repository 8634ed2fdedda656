//! What the device can do.

/// What the device lacks. Beside what [`LeanDeferred`](crate::LeanDeferred) needs, lighting writes one more storage buffer and, with
/// [`LeanScreenSpaceGi`](crate::LeanScreenSpaceGi), four storage textures.
pub fn missing_for_scattering(limits: &wgpu::Limits) -> Option<&'static str> {
    if limits.max_storage_buffers_per_shader_stage < 9 {
        Some("the device has fewer than 9 storage buffers for a shader stage")
    } else if limits.max_storage_textures_per_shader_stage < 4 {
        Some("the device has fewer than 4 storage textures for a shader stage")
    } else {
        None
    }
}
