//! The sampler of percentage-closer soft shadows.

use bevy::{
    prelude::*,
    render::{
        render_resource::{FilterMode, Sampler, SamplerDescriptor},
        renderer::RenderDevice,
    },
};

/// Samples shadow maps in the blocker search, like the two linear samplers of Bevy's `ShadowSamplers`. Those fields
/// exist only with Bevy's feature `experimental_pbr_pcss`, which a crate cannot see.
#[derive(Resource)]
pub(in crate::lighting) struct BlockerSampler(pub(in crate::lighting) Sampler);

impl FromWorld for BlockerSampler {
    fn from_world(world: &mut World) -> Self {
        let device = world.resource::<RenderDevice>();
        Self(device.create_sampler(&SamplerDescriptor {
            label: Some("lean_deferred/lighting/blockers"),
            mag_filter: FilterMode::Linear,
            min_filter: FilterMode::Linear,
            ..default()
        }))
    }
}
