//! Reports pipelines of this crate that cannot be compiled, once each, with the cause.
//!
//! Bevy logs errors of a shader that it cannot compose, but neither which effect is off because of it nor the shader
//! definitions. For an import that nothing provides it waits forever and logs nothing.

use core::{mem::replace, time::Duration};

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
        renderer::RenderDevice,
    },
    shader::{CachedPipelineId, ShaderCacheError, ShaderDefVal, ShaderImport},
};

use super::{pipeline_budget::PipelineBudget, wgsl_dump::WgslDump};

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
    /// Number of pipelines in the last frame.
    seen: usize,
    compiles_in_background: bool,
    /// Of the frame; limited while cameras are prewarmed.
    pub(crate) budget: PipelineBudget,
}

/// Numbers of this crate's pipelines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PipelineCounts {
    /// Compiled, or known to fail.
    pub(crate) settled: usize,
    /// Requested.
    pub(crate) waiting: usize,
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

    /// True if a pipeline was seen to compile while frames go on. Bevy compiles within the frame on macOS, on the web, without
    /// its feature `multi_threaded`, and if told to; which of these holds, it does not tell.
    pub(crate) fn compiles_in_background(&self) -> bool {
        self.compiles_in_background
    }

    /// Counts the pipelines of this crate that were requested up to the last frame. Iterates over all pipelines.
    pub(crate) fn count(&self, cache: &PipelineCache) -> PipelineCounts {
        let mut counts = PipelineCounts::default();
        for (id, pipeline) in cache.pipelines().enumerate() {
            if own_label(pipeline).is_none() {
                continue;
            }
            if is_settled(&pipeline.state) || self.failures.contains_key(&id) {
                counts.settled += 1;
            } else {
                counts.waiting += 1;
            }
        }
        counts
    }

    /// Records a failure. Many pipelines may fail for one cause, which is logged once, with the definitions of the first.
    fn fail(&mut self, id: CachedPipelineId, failure: Failure, stages: &[Stage]) {
        if self.failures.values().all(|other| *other != failure) {
            let Failure { name, cause, .. } = &failure;
            let definitions = definitions(stages);
            error!(
                "{name} cannot be compiled; its effect is off, or Bevy renders in its place: \
                 {cause}. Correct the shader, or add the plugin that loads it. Shader definitions: \
                 {definitions}."
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
    device: Res<RenderDevice>,
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

    if !watch.compiles_in_background {
        let mut waiting = cache.waiting_pipelines().filter_map(pipeline);
        watch.compiles_in_background =
            waiting.any(|waiting| matches!(waiting.state, CachedPipelineState::Creating(_)));
    }

    // New pipelines may have failed at once, and wait no longer.
    let count = cache.pipelines().count();
    let new = replace(&mut watch.seen, count).min(count)..count;
    let waiting = (cache.waiting_pipelines()).filter(|id| !new.contains(id));
    for id in waiting.chain(new.clone()) {
        let Some((pipeline, label)) = pipeline(id).and_then(|p| Some((p, own_label(p)?))) else {
            continue;
        };
        let CachedPipelineState::Err(error) = &pipeline.state else {
            continue;
        };
        let stages = stages(pipeline);
        let name = || match file(&stages, &shaders) {
            Some(file) => format!("{label} ({file})"),
            None => label.into(),
        };
        if !awaits_shader(error) {
            let failure = Failure {
                name: name(),
                cause: error.to_string(),
                awaits_shader: false,
            };
            watch.fail(id, failure, &stages);
            if let Some(dump) = WgslDump::from_environment(&shaders, &device) {
                for Stage { name, shader, defs } in stages {
                    if let Some(shader) = shaders.get(shader) {
                        dump.write(&format!("{label}-{id}.{name}"), shader, defs);
                    }
                }
            }
            continue;
        }
        let now = Instant::now();
        let since = *watch.waiting.entry(id).or_insert(now);
        if now.duration_since(since) < PATIENCE || watch.failures.contains_key(&id) {
            continue;
        }
        let missing = missing_shaders(&stages, &shaders, &asset_server);
        if missing.is_empty() {
            watch.waiting.insert(id, now);
        } else {
            let failure = Failure {
                name: name(),
                cause: format!("nothing provides the shader {}", missing.join(", ")),
                awaits_shader: true,
            };
            watch.fail(id, failure, &stages);
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

/// A shader of a pipeline.
struct Stage<'a> {
    name: &'static str,
    shader: &'a Handle<Shader>,
    defs: &'a [ShaderDefVal],
}

/// The shaders of a pipeline. The first one distinguishes it from others of its kind.
fn stages(pipeline: &CachedPipeline) -> Vec<Stage<'_>> {
    match &pipeline.descriptor {
        PipelineDescriptor::RenderPipelineDescriptor(descriptor) => {
            let fragment = descriptor.fragment.as_ref().map(|state| Stage {
                name: "fragment",
                shader: &state.shader,
                defs: &state.shader_defs,
            });
            let vertex = Stage {
                name: "vertex",
                shader: &descriptor.vertex.shader,
                defs: &descriptor.vertex.shader_defs,
            };
            fragment.into_iter().chain([vertex]).collect()
        }
        PipelineDescriptor::ComputePipelineDescriptor(descriptor) => vec![Stage {
            name: "compute",
            shader: &descriptor.shader,
            defs: &descriptor.shader_defs,
        }],
    }
}

/// The file of a pipeline's distinguishing shader.
fn file<'a>(stages: &[Stage], shaders: &'a Assets<Shader>) -> Option<&'a str> {
    Some(&shaders.get(stages.first()?.shader)?.path)
}

/// Sorted definitions of all stages.
fn definitions(stages: &[Stage]) -> String {
    let mut definitions: Vec<String> = (stages.iter())
        .flat_map(|stage| stage.defs)
        .map(|def| match def {
            ShaderDefVal::Bool(name, true) => name.clone(),
            ShaderDefVal::Bool(name, _)
            | ShaderDefVal::Int(name, _)
            | ShaderDefVal::UInt(name, _) => format!("{name}={}", def.value_as_string()),
        })
        .collect();
    definitions.sort_unstable();
    definitions.dedup();
    if definitions.is_empty() {
        "none".into()
    } else {
        definitions.join(", ")
    }
}

/// True if the pipeline is compiled, or cannot be until a shader changes.
pub(crate) fn is_settled(state: &CachedPipelineState) -> bool {
    match state {
        CachedPipelineState::Ok(_) => true,
        CachedPipelineState::Err(error) => !awaits_shader(error),
        _ => false,
    }
}

/// True if Bevy retries by itself.
fn awaits_shader(error: &ShaderCacheError) -> bool {
    matches!(
        error,
        ShaderCacheError::ShaderNotLoaded(_) | ShaderCacheError::ShaderImportNotYetAvailable
    )
}

/// Names of shaders that `stages` need, directly or through imports, and that are neither loaded nor loading.
fn missing_shaders(
    stages: &[Stage],
    shaders: &Assets<Shader>,
    asset_server: &AssetServer,
) -> Vec<String> {
    let by_import: HashMap<&ShaderImport, AssetId<Shader>> = shaders
        .iter()
        .map(|(id, shader)| (&shader.import_path, id))
        .collect();
    let mut unseen: Vec<AssetId<Shader>> = stages.iter().map(|stage| stage.shader.id()).collect();
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
