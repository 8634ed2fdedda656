//! Reports pipelines of this crate that cannot be compiled, once each, with the cause.
//!
//! Bevy logs errors of a shader that it cannot compose, but not which effect is off because of it. For an import that
//! nothing provides it waits forever and logs nothing.

use core::time::Duration;

use bevy::{
    asset::{AssetId, LoadState},
    platform::{
        collections::{HashMap, HashSet},
        time::Instant,
    },
    prelude::*,
    render::{
        Extract,
        render_resource::{CachedPipeline, CachedPipelineState, PipelineCache, PipelineDescriptor},
    },
    shader::{CachedPipelineId, ShaderCacheError, ShaderImport},
};

/// Prefix of the labels of this crate's pipelines.
const PREFIX: &str = "lean_deferred/";
/// Time for which a pipeline may wait for shaders that nothing provides. Those of plugins arrive within a few frames.
/// Those that an app loads from files may take longer, and do not count as missing while they load.
const PATIENCE: Duration = Duration::from_secs(3);

/// In the render world: the pipelines of this crate that cannot be compiled.
#[derive(Resource, Default)]
pub(crate) struct PipelineWatch {
    /// Start of each pipeline's wait for shaders.
    waiting: HashMap<CachedPipelineId, Instant>,
    failures: HashMap<CachedPipelineId, Failure>,
}

#[derive(Clone, PartialEq)]
struct Failure {
    /// Label of the pipeline and file of its shader.
    name: String,
    cause: String,
    /// True if the missing shader may still arrive; the pipeline is then compiled.
    awaits_shader: bool,
}

impl PipelineWatch {
    /// The reason that one of `pipelines` cannot be compiled; `None` if all are compiled or may soon be.
    pub(crate) fn failure(
        &self,
        pipelines: impl IntoIterator<Item = CachedPipelineId>,
    ) -> Option<&str> {
        let mut pipelines = pipelines.into_iter();
        pipelines.find_map(|id| Some(self.failures.get(&id)?.cause.as_str()))
    }

    /// Records a failure. Many pipelines may fail for one cause, which is logged once.
    fn fail(&mut self, id: CachedPipelineId, failure: Failure) {
        if self.failures.values().all(|other| *other != failure) {
            let Failure { name, cause, .. } = &failure;
            error!(
                "{name} cannot be compiled; its effect is off, or Bevy renders in its place: {cause}. \
                 Correct the shader, or add the plugin that loads it."
            );
        }
        self.failures.insert(id, failure);
    }
}

/// Checks pipelines that are not compiled. Runs in `ExtractSchedule`, where both the pipelines of the last frame and
/// the shaders of the main world are visible.
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
                // Bevy retries each frame, or was notified of another shader.
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
                cause: error.to_string(),
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
                cause: format!("nothing provides the shader {}", missing.join(", ")),
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

/// File of the shader that distinguishes a pipeline from others of its kind.
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

/// True if Bevy retries by itself.
fn awaits_shader(error: &ShaderCacheError) -> bool {
    matches!(
        error,
        ShaderCacheError::ShaderNotLoaded(_) | ShaderCacheError::ShaderImportNotYetAvailable
    )
}

/// Names of shaders that `pipeline` needs, directly or through imports, and that are neither loaded nor loading.
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

/// True if `shader` imports `import` by the path of a file that is still loading.
fn is_loading(import: &ShaderImport, shader: &Shader, asset_server: &AssetServer) -> bool {
    matches!(import, ShaderImport::AssetPath(_))
        && (shader.file_dependencies.iter())
            .any(|file| matches!(asset_server.get_load_state(file), Some(LoadState::Loading)))
}
