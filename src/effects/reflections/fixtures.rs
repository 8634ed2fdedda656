//! Samplers and a texture that all views share.

use std::sync::OnceLock;

use bevy::{
    prelude::*,
    render::{
        render_resource::{
            FilterMode, MipmapFilterMode, Sampler, SamplerDescriptor, Texture, TextureDescriptor,
            TextureDimension, TextureFormat, TextureUsages, TextureView,
        },
        renderer::RenderDevice,
    },
};

/// Created when the first view needs them.
#[derive(Resource, Default)]
pub(super) struct ReflectionFixtures(OnceLock<Fixtures>);

pub(super) struct Fixtures {
    pub(super) history_sampler: Sampler,
    pub(super) depth_sampler: Sampler,
    /// A texel of 0: no special surface.
    pub(super) nothing: TextureView,
}

impl ReflectionFixtures {
    pub(super) fn get(&self, device: &RenderDevice) -> &Fixtures {
        self.0.get_or_init(|| Fixtures::new(device))
    }
}

impl Fixtures {
    fn new(device: &RenderDevice) -> Self {
        let nothing: Texture = device.create_texture(&TextureDescriptor {
            label: Some("lean_deferred/effects/reflections/nothing"),
            size: default(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: TextureFormat::R32Uint,
            usage: TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        Self {
            history_sampler: device.create_sampler(&SamplerDescriptor {
                label: Some("lean_deferred/effects/reflections/history"),
                mag_filter: FilterMode::Linear,
                min_filter: FilterMode::Linear,
                mipmap_filter: MipmapFilterMode::Linear,
                ..default()
            }),
            depth_sampler: device.create_sampler(&SamplerDescriptor {
                label: Some("lean_deferred/effects/reflections/depth"),
                ..default()
            }),
            nothing: nothing.create_view(&default()),
        }
    }
}
