//! What the device must offer.

use crate::gpu::needed_limits::{NeededLimit, needed_limits, unmet};

/// Limits that scattering needs, beside those of [`LeanDeferred`](crate::LeanDeferred).
#[doc(hidden)]
pub const NEEDED_LIMITS: &[NeededLimit] = &needed_limits![
    // Lighting writes one more than it has else.
    max_storage_buffers_per_shader_stage: 9,
    max_compute_invocations_per_workgroup: 256,
    max_compute_workgroup_size_x: 256,
    max_compute_workgroup_storage_size: 16352,
];

/// The first limit of the device that is too low.
pub fn missing_for_scattering(limits: &wgpu::Limits) -> Option<&'static NeededLimit> {
    unmet(NEEDED_LIMITS, limits).next()
}
