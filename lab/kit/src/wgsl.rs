//! Composes the crate's WGSL, as shipped or from `LEAN_SHADERS`, for a device separate from Bevy's.

use std::{borrow::Cow, collections::HashMap};

use bevy::shader::ShaderDefVal;
use naga::valid::Capabilities;
use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, ComposerError, NagaModuleDescriptor, ShaderDefValue,
};

use crate::shader_files::shader_file;

/// Shader definitions by name.
pub type Definitions = HashMap<String, ShaderDefValue>;

/// A module of the crate, or a replacement of one.
#[derive(Clone, Copy)]
pub struct WgslModule {
    /// Begins with `src/` for the crate's modules; otherwise used in error messages only.
    pub path: &'static str,
    pub source: &'static str,
}

/// The [`WgslModule`] of the crate at a path in `src`. For the crate's tests and benches.
#[macro_export]
macro_rules! shipped_wgsl {
    ($path:literal) => {
        $crate::shipped_wgsl!("", $path)
    };
    ($from_manifest:literal, $path:literal) => {
        $crate::wgsl::WgslModule {
            path: concat!("src/", $path),
            source: include_str!(concat!(
                env!("CARGO_MANIFEST_DIR"),
                "/",
                $from_manifest,
                "src/",
                $path
            )),
        }
    };
}

/// As [`shipped_wgsl!`], from within this crate.
macro_rules! wgsl {
    ($path:literal) => {
        $crate::shipped_wgsl!("../../", $path)
    };
}
pub(crate) use wgsl;

/// Compiles `source` with its imports from `modules`, which are listed dependencies first. Panics with the compiler's message on invalid
/// WGSL.
pub fn compile(
    device: &wgpu::Device,
    modules: &[WgslModule],
    source: &str,
    definitions: Definitions,
) -> wgpu::ShaderModule {
    let module = compose(modules, source, definitions);
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Naga(Cow::Owned(module)),
    })
}

fn compose(modules: &[WgslModule], source: &str, definitions: Definitions) -> naga::Module {
    // Capabilities that the crate requires of every device, or has two versions for.
    let capabilities = Capabilities::SUBGROUP | Capabilities::SHADER_FLOAT16_IN_FLOAT32;
    let mut composer = Composer::default().with_capabilities(capabilities);
    let report = |composer: &Composer, error: ComposerError| -> ! {
        panic!("{}", error.emit_to_string(composer))
    };
    for module in modules {
        if let Err(error) = composer.add_composable_module(ComposableModuleDescriptor {
            source: &shader_file(module),
            file_path: module.path,
            ..Default::default()
        }) {
            report(&composer, error);
        }
    }
    let composed = composer.make_naga_module(NagaModuleDescriptor {
        source,
        file_path: "kernel.wgsl",
        shader_defs: definitions,
        ..Default::default()
    });
    composed.unwrap_or_else(|error| report(&composer, error))
}

/// Definitions that are numbers.
pub fn numbers(definitions: &[(&str, u32)]) -> Definitions {
    definitions
        .iter()
        .map(|(name, value)| (name.to_string(), ShaderDefValue::UInt(*value)))
        .collect()
}

/// Bevy's definitions in the composer's type.
pub fn definitions_of(definitions: impl IntoIterator<Item = ShaderDefVal>) -> Definitions {
    definitions
        .into_iter()
        .map(|definition| match definition {
            ShaderDefVal::Bool(name, value) => (name, ShaderDefValue::Bool(value)),
            ShaderDefVal::Int(name, value) => (name, ShaderDefValue::Int(value)),
            ShaderDefVal::UInt(name, value) => (name, ShaderDefValue::UInt(value)),
        })
        .collect()
}

/// A cache key of `definitions`.
pub fn key_of(definitions: &Definitions) -> Vec<String> {
    let mut key: Vec<String> = definitions.iter().map(|def| format!("{def:?}")).collect();
    key.sort();
    key
}
