//! What the devices of tests may do: all that the adapter can, or less, as `LEAN_TEST_DEVICE` says.

use bevy::render::{
    RenderPlugin,
    settings::{RenderCreation, WgpuSettings, WgpuSettingsPriority},
};
use wgpu::{Features, Limits};

/// With arrays of textures, of which each invocation may read another: Bevy has decals, textures of lights and several
/// environment maps only with these.
pub(crate) const BINDING_ARRAYS: Features = Features::TEXTURE_BINDING_ARRAY
    .union(Features::SAMPLED_TEXTURE_AND_STORAGE_BUFFER_ARRAY_NON_UNIFORM_INDEXING);

/// Bevy's forward pass alone asks for more textures and samplers in the fragment stage than the 16 that WebGPU grants to all, with the
/// features that the tests enable.
const BEVYS_TEXTURES: u32 = 32;

/// Bevy's bloom alone draws into textures of such a format.
const BEVYS_FEATURES: Features = Features::RG11B10UFLOAT_RENDERABLE;

/// How much of what the adapter can do a device may.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TestDevice {
    /// All of it.
    Whole,
    /// All but binding arrays.
    NoBindingArrays,
    /// What each device has that runs WebGPU, and nothing more.
    WebGpu,
    /// What `wgpu` calls its downlevel defaults: four storage buffers for a shader stage, among others.
    Downlevel,
}

impl TestDevice {
    /// The one that `LEAN_TEST_DEVICE` names; [`TestDevice::Whole`] without it.
    pub fn chosen() -> Self {
        let name = std::env::var("LEAN_TEST_DEVICE").unwrap_or_default();
        match name.as_str() {
            "" => Self::Whole,
            "no-binding-arrays" => Self::NoBindingArrays,
            "webgpu" => Self::WebGpu,
            "downlevel" => Self::Downlevel,
            _ => {
                panic!("LEAN_TEST_DEVICE is no-binding-arrays, webgpu or downlevel, and not {name}")
            }
        }
    }

    /// The limits of a device of an adapter with these.
    pub fn limits(self, limits: Limits) -> Limits {
        match self {
            Self::Whole | Self::NoBindingArrays => limits,
            Self::WebGpu | Self::Downlevel => {
                let least = if self == Self::WebGpu {
                    Limits::default()
                } else {
                    Limits::downlevel_defaults()
                };
                Limits {
                    max_sampled_textures_per_shader_stage: BEVYS_TEXTURES,
                    max_samplers_per_shader_stage: BEVYS_TEXTURES,
                    ..least
                }
            }
        }
    }

    /// The features of a device of an adapter with these.
    pub fn features(self, features: Features) -> Features {
        match self {
            Self::Whole => features,
            Self::NoBindingArrays => features - BINDING_ARRAYS,
            Self::WebGpu | Self::Downlevel => BEVYS_FEATURES & features,
        }
    }

    fn settings(self) -> WgpuSettings {
        let settings = WgpuSettings::default();
        match self {
            Self::Whole => settings,
            Self::NoBindingArrays => WgpuSettings {
                disabled_features: Some(BINDING_ARRAYS),
                ..settings
            },
            Self::WebGpu | Self::Downlevel => WgpuSettings {
                priority: WgpuSettingsPriority::WebGPU,
                features: BEVYS_FEATURES,
                limits: self.limits(Limits::default()),
                ..settings
            },
        }
    }
}

/// Of the chosen device.
pub fn render_creation() -> RenderCreation {
    RenderCreation::Automatic(Box::new(TestDevice::chosen().settings()))
}

/// Bevy's, with the chosen device and limits no better than these.
pub fn render_plugin_within(limits: Limits) -> RenderPlugin {
    let settings = WgpuSettings {
        constrained_limits: Some(limits),
        ..TestDevice::chosen().settings()
    };
    RenderPlugin {
        render_creation: RenderCreation::Automatic(Box::new(settings)),
        synchronous_pipeline_compilation: true,
        ..Default::default()
    }
}

/// Bevy's, with the chosen device.
pub fn render_plugin(synchronous_pipeline_compilation: bool) -> RenderPlugin {
    RenderPlugin {
        render_creation: render_creation(),
        synchronous_pipeline_compilation,
        ..Default::default()
    }
}
