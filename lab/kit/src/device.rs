//! Limits and features of test devices: all that the adapter has, or fewer, as `LEAN_TEST_DEVICE` says.

use bevy::render::{
    RenderPlugin,
    settings::{RenderCreation, WgpuSettings, WgpuSettingsPriority},
};
use wgpu::{Features, Limits};

/// Features for arrays of textures that each invocation indexes differently. Bevy needs them for decals, light textures and more than one
/// environment map.
pub(crate) const BINDING_ARRAYS: Features = Features::TEXTURE_BINDING_ARRAY
    .union(Features::SAMPLED_TEXTURE_AND_STORAGE_BUFFER_ARRAY_NON_UNIFORM_INDEXING);

/// Textures and samplers per fragment stage: with the features that the tests enable, Bevy's forward pass alone exceeds the 16 that WebGPU
/// guarantees.
const BEVYS_TEXTURES: u32 = 32;

/// Bevy's bloom renders to this format.
const BEVYS_FEATURES: Features = Features::RG11B10UFLOAT_RENDERABLE;

/// Share of the adapter's capabilities that a test device gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TestDevice {
    /// All of them.
    Whole,
    /// All but binding arrays.
    NoBindingArrays,
    /// The minimum that WebGPU guarantees, apart from Bevy's own needs.
    WebGpu,
    /// wgpu's downlevel defaults, apart from Bevy's own needs: four storage buffers per shader stage, among others.
    Downlevel,
}

impl TestDevice {
    /// The device that `LEAN_TEST_DEVICE` names; [`TestDevice::Whole`] without it.
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

    /// Limits of this device on an adapter with `limits`.
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

    /// Features of this device on an adapter with `features`.
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

/// Creates the chosen device.
pub fn render_creation() -> RenderCreation {
    RenderCreation::Automatic(Box::new(TestDevice::chosen().settings()))
}

/// Bevy's plugin with the chosen device, whose limits are no better than `limits`.
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

/// Bevy's plugin with the chosen device.
pub fn render_plugin(synchronous_pipeline_compilation: bool) -> RenderPlugin {
    RenderPlugin {
        render_creation: render_creation(),
        synchronous_pipeline_compilation,
        ..Default::default()
    }
}
