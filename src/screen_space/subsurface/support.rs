//! What the device can do.

/// What the device lacks. Beside what [`LeanDeferred`](crate::LeanDeferred) needs, lighting writes one more storage buffer.
pub fn missing_for_scattering(limits: &wgpu::Limits) -> Option<&'static str> {
    (limits.max_storage_buffers_per_shader_stage < 9)
        .then_some("the device has fewer than 9 storage buffers for a shader stage")
}
