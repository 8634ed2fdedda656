//! Requirements of the effects, in addition to those of a lean camera.

use core::fmt;

use bevy::{prelude::*, render::renderer::RenderDevice};

use crate::gpu::needed_limits::{NeededLimit, check_limits, needed_limits, unmet};

/// Limits that GI and reflections need, in addition to those of [`LeanDeferred`](crate::LeanDeferred).
#[doc(hidden)]
pub const NEEDED_LIMITS: &[NeededLimit] = &needed_limits![
    max_compute_invocations_per_workgroup: 256,
    max_compute_workgroup_size_x: 256,
    max_compute_workgroup_storage_size: 12544,
];

/// Checks the device of `world` for limits that lean cameras do not need.
pub(super) fn check(world: &World) -> Result<(), String> {
    check_device_limits(world, NEEDED_LIMITS)
}

/// Checks the device of `world` for `needed` limits.
pub(super) fn check_device_limits(world: &World, needed: &[NeededLimit]) -> Result<(), String> {
    match world.get_resource::<RenderDevice>() {
        Some(device) => check_limits(needed, &device.limits()),
        None => Err("a render device".into()),
    }
}

/// The reason that an effect is off on a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum EffectOff {
    NotLean,
    /// The device does not meet this limit.
    Limit(&'static NeededLimit),
}

impl EffectOff {
    /// `None` if an effect that needs these limits can run.
    pub(super) fn of(
        is_lean: bool,
        needed: &'static [NeededLimit],
        limits: &wgpu::Limits,
    ) -> Option<Self> {
        if is_lean {
            unmet(needed, limits).next().map(Self::Limit)
        } else {
            Some(Self::NotLean)
        }
    }
}

/// Completes "It is off: …".
impl fmt::Display for EffectOff {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::NotLean => write!(f, "it has no `LeanDeferred`: insert one"),
            Self::Limit(limit) => write!(f, "the device lacks {limit}"),
        }
    }
}
