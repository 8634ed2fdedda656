//! Shaders from files in place of those that are compiled in: what is edited in WGSL is seen without building anything.

use std::path::PathBuf;

use bevy::{prelude::*, shader::Shader};

/// Names the folder, `src` of the crate or a copy of it.
const VARIABLE: &str = "LEAN_SHADERS";

/// How the paths of embedded shaders begin.
const CRATE: &str = "bevy_lean_deferred/";

/// Where shaders are read from.
#[derive(Resource)]
struct ShaderFiles(PathBuf);

/// Reads the crate's shaders from the folder that `LEAN_SHADERS` names, if it does.
pub fn read_shader_files(app: &mut App) {
    if let Some(folder) = std::env::var_os(VARIABLE) {
        app.insert_resource(ShaderFiles(folder.into()))
            .add_systems(PreUpdate, replace_shaders);
    }
}

fn replace_shaders(
    files: Res<ShaderFiles>,
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
        let file = files.0.join(name);
        match std::fs::read_to_string(&file) {
            Ok(source) => {
                if let Err(error) = shaders.insert(*id, Shader::from_wgsl(source, path.clone())) {
                    warn!("{name} is not replaced: {error}");
                }
            }
            Err(error) => warn!("{}: {error}", file.display()),
        }
    }
}
