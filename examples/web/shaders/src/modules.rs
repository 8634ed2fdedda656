//! Composes shaders from files as Bevy's `ShaderCache` does.

use std::{
    collections::HashMap,
    fs,
    path::{Path, PathBuf},
};

use naga::{
    back::wgsl::{WriterFlags, write_string},
    valid::{Capabilities, ValidationFlags, Validator},
};
use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue,
    get_preprocessor_data,
};

use super::{Definitions, SOURCES};

/// Capabilities that `wgpu` gives every device in a browser.
const WEBGPU: Capabilities = Capabilities::from_bits_truncate(
    Capabilities::MULTISAMPLED_SHADING.bits()
        | Capabilities::CUBE_ARRAY_TEXTURES.bits()
        | Capabilities::SHADER_FLOAT16_IN_FLOAT32.bits(),
);

/// Array sizes that Bevy defines on devices with storage buffers.
const SIZES: [(&str, u32); 3] = [
    ("MAX_DIRECTIONAL_LIGHTS", 10),
    ("MAX_CASCADES_PER_LIGHT", 4),
    ("MAX_RECT_LIGHTS", 8),
];

pub struct Modules {
    composer: Composer,
    /// Files by import path.
    files: HashMap<String, PathBuf>,
}

fn find_modules(folder: &Path, files: &mut HashMap<String, PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            find_modules(&path, files);
        } else if path
            .extension()
            .is_some_and(|extension| extension == "wgsl")
        {
            let source = fs::read_to_string(&path).unwrap_or_default();
            if let (Some(name), ..) = get_preprocessor_data(&source) {
                files.insert(name, path);
            }
        }
    }
}

impl Modules {
    pub fn new(bevy: &[String]) -> Self {
        let mut files = HashMap::new();
        for folder in bevy.iter().map(String::as_str).chain([SOURCES]) {
            find_modules(Path::new(folder), &mut files);
        }
        Self {
            composer: Composer::non_validating().with_capabilities(WEBGPU),
            files,
        }
    }

    fn add(&mut self, imports: Vec<String>) -> Result<(), String> {
        for name in imports {
            if self.composer.contains_module(&name) {
                continue;
            }
            let path = self.files.get(&name).ok_or(format!("no module {name}"))?;
            let path = path.to_string_lossy().into_owned();
            let source = fs::read_to_string(&path).map_err(|error| error.to_string())?;
            let (_, imports, _) = get_preprocessor_data(&source);
            self.add(imports.into_iter().map(|import| import.import).collect())?;
            let added = self
                .composer
                .add_composable_module(ComposableModuleDescriptor {
                    source: &source,
                    file_path: &path,
                    shader_defs: SIZES
                        .map(|(name, size)| (name.to_string(), ShaderDefValue::UInt(size)))
                        .into(),
                    ..Default::default()
                })
                .map(|_| ());
            added.map_err(|error| error.emit_to_string(&self.composer))?;
        }
        Ok(())
    }

    fn compose(&mut self, path: &str, definitions: Definitions) -> Result<naga::Module, String> {
        let file = format!("{SOURCES}/{path}");
        let source = fs::read_to_string(&file).map_err(|error| error.to_string())?;
        let (_, imports, _) = get_preprocessor_data(&source);
        self.add(imports.into_iter().map(|import| import.import).collect())?;
        let composed = self.composer.make_naga_module(NagaModuleDescriptor {
            source: &source,
            file_path: &file,
            shader_defs: definitions,
            ..Default::default()
        });
        composed.map_err(|error| error.emit_to_string(&self.composer))
    }

    /// The shader at this path in `src`, as the WGSL that `wgpu` writes for browsers.
    pub fn as_browsers_get_it(
        &mut self,
        path: &str,
        definitions: Definitions,
    ) -> Result<String, String> {
        let module = self.compose(path, definitions)?;
        let info = Validator::new(ValidationFlags::all(), WEBGPU)
            .validate(&module)
            .map_err(|error| format!("{:?}", error.into_inner()))?;
        write_string(&module, &info, WriterFlags::empty()).map_err(|error| error.to_string())
    }
}
