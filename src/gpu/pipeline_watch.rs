//! Pipelines of this crate that cannot be compiled: each is reported once, with the cause.
//!
//! Bevy logs what is wrong with a shader that it cannot compose, but not which effect is off for it. For an import that
//! nothing provides it waits for ever, without a word.

use core::time::Duration;

use alloc::sync::Arc;

use bevy::{
    asset::{AssetId, LoadState},
    platform::{
        collections::{HashMap, HashSet},
        time::Instant,
    },
    prelude::*,
    render::{
        Extract,
        render_resource::{
            CachedComputePipelineId, CachedPipeline, CachedPipelineState, PipelineCache,
            PipelineDescriptor,
        },
    },
    shader::{CachedPipelineId, ShaderCacheError, ShaderImport},
};

/// What the labels of this crate's pipelines begin with.
const PREFIX: &str = "lean_deferred/";
/// How long a pipeline may wait for shaders that nothing provides. Those of plugins are there within a few frames; those
/// that an app loads from files may take longer, and are not missing while they load.
const PATIENCE: Duration = Duration::from_secs(3);

/// In the render world: the pipelines of this crate that cannot be compiled.
#[derive(Resource, Default)]
pub(crate) struct PipelineWatch {
    /// Since when pipelines have been waiting for shaders.
    waiting: HashMap<CachedPipelineId, Instant>,
    failures: HashMap<CachedPipelineId, Failure>,
}

#[derive(Clone, PartialEq)]
struct Failure {
    /// Its label and the file of its shader.
    name: String,
    cause: Arc<str>,
    /// It may come yet, and the pipeline is compiled then.
    awaits_shader: bool,
}

impl PipelineWatch {
    /// Why the pipeline cannot be compiled; `None` if it is, or may soon be.
    pub(crate) fn failure(&self, pipeline: CachedComputePipelineId) -> Option<Arc<str>> {
        let failure = self.failures.get(&pipeline.id())?;
        Some(failure.cause.clone())
    }

    /// Many pipelines may fail for one cause, which is logged once.
    fn fail(&mut self, id: CachedPipelineId, failure: Failure) {
        if self.failures.values().all(|other| *other != failure) {
            let Failure { name, cause, .. } = &failure;
            error!("{name} cannot be compiled, and what needs it is off or left to Bevy: {cause}.");
        }
        self.failures.insert(id, failure);
    }
}

/// In `ExtractSchedule`, where both the pipelines of the last frame and the shaders of the main world can be seen.
/// Looks only at pipelines that are not compiled.
pub(crate) fn watch_pipelines(
    mut watch: ResMut<PipelineWatch>,
    cache: Res<PipelineCache>,
    shaders: Extract<Res<Assets<Shader>>>,
    asset_server: Extract<Res<AssetServer>>,
) {
    let pipeline = |id| cache.pipelines().nth(id);
    if !watch.waiting.is_empty() || !watch.failures.is_empty() {
        let watch = &mut *watch;
        watch.waiting.retain(|id, _| {
            pipeline(*id).is_some_and(|pipeline| match &pipeline.state {
                CachedPipelineState::Ok(_) => false,
                CachedPipelineState::Err(error) => awaits_shader(error),
                _ => true,
            })
        });
        watch.failures.retain(|id, failure| {
            pipeline(*id).is_some_and(|pipeline| match &pipeline.state {
                CachedPipelineState::Ok(_) => false,
                CachedPipelineState::Err(error) => failure.awaits_shader == awaits_shader(error),
                // Bevy tries again each frame, or was told of another shader.
                _ => failure.awaits_shader,
            })
        });
    }

    for id in cache.waiting_pipelines() {
        let Some((pipeline, label)) = pipeline(id).and_then(|p| Some((p, own_label(p)?))) else {
            continue;
        };
        let CachedPipelineState::Err(error) = &pipeline.state else {
            continue;
        };
        let name = || match file(pipeline, &shaders) {
            Some(file) => format!("{label} ({file})"),
            None => label.into(),
        };
        if !awaits_shader(error) {
            let failure = Failure {
                name: name(),
                cause: error.to_string().into(),
                awaits_shader: false,
            };
            watch.fail(id, failure);
            continue;
        }
        let now = Instant::now();
        let since = *watch.waiting.entry(id).or_insert(now);
        if now.duration_since(since) < PATIENCE || watch.failures.contains_key(&id) {
            continue;
        }
        let missing = missing_shaders(pipeline, &shaders, &asset_server);
        if missing.is_empty() {
            watch.waiting.insert(id, now);
        } else {
            let failure = Failure {
                name: name(),
                cause: format!("nothing provides the shader {}", missing.join(", ")).into(),
                awaits_shader: true,
            };
            watch.fail(id, failure);
        }
    }
}

fn own_label(pipeline: &CachedPipeline) -> Option<&str> {
    let label = match &pipeline.descriptor {
        PipelineDescriptor::RenderPipelineDescriptor(descriptor) => &descriptor.label,
        PipelineDescriptor::ComputePipelineDescriptor(descriptor) => &descriptor.label,
    };
    label.as_deref().filter(|label| label.starts_with(PREFIX))
}

/// Where the shader that tells a pipeline from others of its kind was loaded from.
fn file<'a>(pipeline: &CachedPipeline, shaders: &'a Assets<Shader>) -> Option<&'a str> {
    let shader = match &pipeline.descriptor {
        PipelineDescriptor::RenderPipelineDescriptor(descriptor) => {
            let fragment = descriptor.fragment.as_ref().map(|state| &state.shader);
            fragment.unwrap_or(&descriptor.vertex.shader)
        }
        PipelineDescriptor::ComputePipelineDescriptor(descriptor) => &descriptor.shader,
    };
    Some(&shaders.get(shader)?.path)
}

/// Whether Bevy tries again by itself.
fn awaits_shader(error: &ShaderCacheError) -> bool {
    matches!(
        error,
        ShaderCacheError::ShaderNotLoaded(_) | ShaderCacheError::ShaderImportNotYetAvailable
    )
}

/// The names of shaders that `pipeline` needs, of itself or through imports, and that are neither there nor loading.
fn missing_shaders(
    pipeline: &CachedPipeline,
    shaders: &Assets<Shader>,
    asset_server: &AssetServer,
) -> Vec<String> {
    let by_import: HashMap<&ShaderImport, AssetId<Shader>> = shaders
        .iter()
        .map(|(id, shader)| (&shader.import_path, id))
        .collect();
    let mut unseen: Vec<AssetId<Shader>> = match &pipeline.descriptor {
        PipelineDescriptor::RenderPipelineDescriptor(descriptor) => {
            let fragment = descriptor.fragment.iter().map(|state| state.shader.id());
            fragment.chain([descriptor.vertex.shader.id()]).collect()
        }
        PipelineDescriptor::ComputePipelineDescriptor(descriptor) => vec![descriptor.shader.id()],
    };
    let mut seen = HashSet::new();
    let mut missing = Vec::new();
    while let Some(id) = unseen.pop() {
        if !seen.insert(id) {
            continue;
        }
        let Some(shader) = shaders.get(id) else {
            if !matches!(asset_server.get_load_state(id), Some(LoadState::Loading)) {
                let path = asset_server.get_path(id);
                missing.push(path.map_or_else(|| id.to_string(), |path| path.to_string()));
            }
            continue;
        };
        for import in &shader.imports {
            match by_import.get(import) {
                Some(id) => unseen.push(*id),
                None if is_loading(import, shader, asset_server) => {}
                None => missing.push(import.module_name().into_owned()),
            }
        }
    }
    missing.sort_unstable();
    missing.dedup();
    missing
}

/// Whether `shader` names `import` by the path of a file that is on its way.
fn is_loading(import: &ShaderImport, shader: &Shader, asset_server: &AssetServer) -> bool {
    matches!(import, ShaderImport::AssetPath(_))
        && (shader.file_dependencies.iter())
            .any(|file| matches!(asset_server.get_load_state(file), Some(LoadState::Loading)))
}
