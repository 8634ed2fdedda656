//! Replaces compiled-in shaders: by those of a folder, so that WGSL edits need no rebuild, or by those of a test.

use std::{borrow::Cow, path::PathBuf};

use bevy::{platform::collections::HashMap, prelude::*, shader::Shader};

use crate::wgsl::WgslModule;

/// Names the folder: `src` of the crate or a copy of it.
const VARIABLE: &str = "LEAN_SHADERS";

/// Prefix of the paths of embedded shaders.
const CRATE: &str = "bevy_lean_deferred/";

/// Sources of replaced shaders.
#[derive(Resource, Default)]
struct ReplacedShaders {
    folder: Option<PathBuf>,
    /// Sources by path in `src`.
    sources: HashMap<&'static str, String>,
}

/// Reads the crate's shaders from the folder that `LEAN_SHADERS` names, if set.
pub fn read_shader_files(app: &mut App) {
    if let Some(folder) = std::env::var_os(VARIABLE) {
        replacements(app).folder = Some(folder.into());
    }
}

/// The source of a module, from that folder or as compiled in.
pub fn shader_file(module: &WgslModule) -> Cow<'static, str> {
    let (Some(folder), Some(path)) = (std::env::var_os(VARIABLE), module.path.strip_prefix("src/"))
    else {
        return module.source.into();
    };
    let file = PathBuf::from(folder).join(path);
    let source = std::fs::read_to_string(&file);
    source
        .unwrap_or_else(|error| panic!("{}: {error}", file.display()))
        .into()
}

/// Replaces the shader at `path` in `src` by `source`. To be called before the app's first frame.
pub fn replace_shader(app: &mut App, path: &'static str, source: String) {
    replacements(app).sources.insert(path, source);
}

fn replacements(app: &mut App) -> Mut<'_, ReplacedShaders> {
    if !app.world().contains_resource::<ReplacedShaders>() {
        app.init_resource::<ReplacedShaders>()
            .add_systems(PreUpdate, replace_shaders);
    }
    app.world_mut().resource_mut()
}

fn replace_shaders(
    replaced: Res<ReplacedShaders>,
    mut loaded: MessageReader<AssetEvent<Shader>>,
    mut shaders: ResMut<Assets<Shader>>,
) {
    for event in loaded.read() {
        let AssetEvent::Added { id } = event else {
            continue;
        };
        let Some(path) = shaders.get(*id).map(|shader| shader.path.clone()) else {
            continue;
        };
        let Some((_, name)) = path.split_once(CRATE) else {
            continue;
        };
        let source = match (replaced.sources.get(name), &replaced.folder) {
            (Some(source), _) => source.clone(),
            (None, None) => continue,
            (None, Some(folder)) => match std::fs::read_to_string(folder.join(name)) {
                Ok(source) => source,
                Err(error) => {
                    warn!("{name}: {error}");
                    continue;
                }
            },
        };
        if let Err(error) = shaders.insert(*id, Shader::from_wgsl(source, path.clone())) {
            warn!("{name} is not replaced: {error}");
        }
    }
}
