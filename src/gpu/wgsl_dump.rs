//! Writes the WGSL of pipelines that cannot be compiled into the folder that the environment variable `LEAN_DUMP_WGSL` names.
//!
//! Bevy keeps no composed source: the shader is composed again as by Bevy's `ShaderCache`, but without validation.

use std::{
    collections::HashMap,
    env, fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::PathBuf,
};

use bevy::{
    prelude::*,
    render::renderer::RenderDevice,
    shader::{ShaderDefVal, ShaderImport, Source},
};
use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue,
    preprocess::Preprocessor,
};
use wgpu::naga::{
    back::wgsl::{WriterFlags, write_string},
    valid::{Capabilities, ValidationFlags, Validator},
};

const VARIABLE: &str = "LEAN_DUMP_WGSL";

/// The folder, and the sources to compose.
pub(super) struct WgslDump<'a> {
    folder: PathBuf,
    shaders: &'a Assets<Shader>,
    /// Bevy adds it to the definitions of all shaders.
    storage_buffers: ShaderDefVal,
}

type Definitions = HashMap<String, ShaderDefValue>;

/// If two definitions have one name, the latter is used.
fn definitions<'a>(defs: impl IntoIterator<Item = &'a ShaderDefVal>) -> Definitions {
    let defs = defs.into_iter().map(|def| match def.clone() {
        ShaderDefVal::Bool(name, value) => (name, ShaderDefValue::Bool(value)),
        ShaderDefVal::Int(name, value) => (name, ShaderDefValue::Int(value)),
        ShaderDefVal::UInt(name, value) => (name, ShaderDefValue::UInt(value)),
    });
    defs.collect()
}

impl<'a> WgslDump<'a> {
    /// `None` unless the environment variable is set.
    pub(super) fn from_environment(
        shaders: &'a Assets<Shader>,
        device: &RenderDevice,
    ) -> Option<Self> {
        let folder = env::var_os(VARIABLE)?.into();
        let storage_buffers = device.limits().max_storage_buffers_per_shader_stage;
        Some(Self {
            folder,
            shaders,
            storage_buffers: ShaderDefVal::UInt(
                "AVAILABLE_STORAGE_BUFFER_BINDINGS".into(),
                storage_buffers,
            ),
        })
    }

    /// Writes the shader of one stage of a pipeline.
    pub(super) fn write(&self, stage: &str, shader: &Shader, defs: &[ShaderDefVal]) {
        let Some(wgsl) = self.wgsl(shader, defs) else {
            return;
        };
        let file = self
            .folder
            .join(format!("{}.wgsl", stage.replace('/', ".")));
        let written = fs::create_dir_all(&self.folder).and_then(|()| fs::write(&file, wgsl));
        let file = file.display();
        match written {
            Ok(()) => info!("The WGSL of {stage} is in {file}."),
            Err(error) => warn!("The WGSL of {stage} cannot be written to {file}: {error}."),
        }
    }

    /// The composed module. If it cannot be composed, the source of the shader alone, with its conditions resolved.
    fn wgsl(&self, shader: &Shader, defs: &[ShaderDefVal]) -> Option<String> {
        let Source::Wgsl(source) = &shader.source else {
            return None;
        };
        let defs = defs.iter().chain(&shader.shader_defs);
        let defs = definitions(defs.chain([&self.storage_buffers]));
        // Without validation, naga may panic.
        let composed = catch_unwind(AssertUnwindSafe(|| self.compose(shader, defs.clone())));
        composed.ok().flatten().or_else(|| preprocess(source, defs))
    }

    fn compose(&self, shader: &Shader, shader_defs: Definitions) -> Option<String> {
        let by_import: HashMap<&ShaderImport, &Shader> = self
            .shaders
            .iter()
            .map(|(_, shader)| (&shader.import_path, shader))
            .collect();
        let mut composer = Composer::non_validating().with_capabilities(Capabilities::all());
        self.add_imports(shader, &by_import, &mut composer)?;
        let descriptor = NagaModuleDescriptor {
            shader_defs,
            ..shader.into()
        };
        let module = composer.make_naga_module(descriptor).ok()?;
        let info = Validator::new(ValidationFlags::empty(), Capabilities::all())
            .validate(&module)
            .ok()?;
        write_string(&module, &info, WriterFlags::empty()).ok()
    }

    /// Adds the modules that `shader` imports, and those that they import.
    fn add_imports(
        &self,
        shader: &Shader,
        by_import: &HashMap<&ShaderImport, &Shader>,
        composer: &mut Composer,
    ) -> Option<()> {
        for import in &shader.imports {
            if composer.contains_module(&import.module_name()) {
                continue;
            }
            let module: &Shader = by_import.get(import)?;
            self.add_imports(module, by_import, composer)?;
            let mut descriptor = ComposableModuleDescriptor::from(module);
            let storage_buffers = definitions([&self.storage_buffers]);
            descriptor.shader_defs.extend(storage_buffers);
            composer.add_composable_module(descriptor).ok()?;
        }
        Some(())
    }
}

fn preprocess(source: &str, mut shader_defs: Definitions) -> Option<String> {
    let preprocessor = Preprocessor::default();
    let metadata = preprocessor.get_preprocessor_metadata(source, true).ok()?;
    shader_defs.extend(metadata.defines);
    let output = preprocessor.preprocess(&metadata.cleaned_source, &shader_defs);
    Some(output.ok()?.preprocessed_source)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PART: &str = "
#define_import_path tests::part
fn seven() -> u32 { return 7u; }
";

    const WHOLE: &str = "
#import tests::part::seven
#ifdef TWICE
fn whole() -> u32 { return 2u * seven(); }
#else
fn whole() -> u32 { return seven(); }
#endif
@compute @workgroup_size(1)
fn main() { var number = whole(); }
";

    fn with_dump(folder: PathBuf, act: impl FnOnce(&WgslDump)) {
        let mut shaders = Assets::<Shader>::default();
        let _part = shaders.add(Shader::from_wgsl(PART, "part.wgsl"));
        act(&WgslDump {
            folder,
            shaders: &shaders,
            storage_buffers: ShaderDefVal::UInt("AVAILABLE_STORAGE_BUFFER_BINDINGS".into(), 8),
        });
    }

    #[test]
    fn modules_are_composed_by_their_definitions() {
        with_dump(PathBuf::new(), |dump| {
            let whole = Shader::from_wgsl(WHOLE, "whole.wgsl");
            let once = dump.wgsl(&whole, &[]).expect("it is WGSL");
            assert!(once.contains("7u") && !once.contains("2u"), "{once}");
            let twice = dump.wgsl(&whole, &["TWICE".into()]).expect("it is WGSL");
            assert!(twice.contains("7u") && twice.contains("2u"), "{twice}");
        });
    }

    #[test]
    fn faulty_shaders_are_written_too() {
        let folder = env::temp_dir().join(format!("lean_dump_wgsl_{}", std::process::id()));
        with_dump(folder.clone(), |dump| {
            for fault in [
                "fn faulty() -> u32 { return missing_name; }",
                "fn faulty() -> u32 { }",
                "#import tests::nothing\nfn faulty() -> u32 { return 1u; }",
            ] {
                let source = format!("#ifdef ASKED\n{fault}\n#else\nfn other() {{ }}\n#endif\n");
                let shader = Shader::from_wgsl(source, "faulty.wgsl");
                dump.write("lean_deferred/gpu/faulty", &shader, &["ASKED".into()]);
                let written = fs::read_to_string(folder.join("lean_deferred.gpu.faulty.wgsl"));
                let written = written.expect("it is written");
                assert!(written.contains("fn faulty"), "{written}");
                assert!(!written.contains("fn other"), "{written}");
                fs::remove_dir_all(&folder).expect("it is there");
            }
        });
    }
}
