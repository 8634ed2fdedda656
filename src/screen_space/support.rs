//! Requirements of the effects, in addition to those of a lean camera.

use core::fmt;

use crate::gpu::needed_limits::{NeededLimit, needed_limits, unmet};

/// Limits that GI and reflections need, in addition to those of [`LeanDeferred`](crate::LeanDeferred).
#[doc(hidden)]
pub const NEEDED_LIMITS: &[NeededLimit] = &needed_limits![
    max_compute_invocations_per_workgroup: 256,
    max_compute_workgroup_size_x: 256,
    max_compute_workgroup_storage_size: 12544,
];

/// The reason that an effect is off on a lean camera: the device does not meet this limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct EffectOff(&'static NeededLimit);

impl EffectOff {
    /// `None` if an effect that needs these limits can run.
    pub(super) fn of(needed: &'static [NeededLimit], limits: &wgpu::Limits) -> Option<Self> {
        unmet(needed, limits).next().map(Self)
    }
}

/// Completes "It is off: …".
impl fmt::Display for EffectOff {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "the device lacks {}", self.0)
    }
}
