//! Makes the positions of Bevy's vertex shaders `@invariant`, by a change of their text as soon as it is loaded: then all pipelines
//! compute the same depth of a mesh. Those of Bevy may differ by rounding, where compilers contract products and sums in one pipeline
//! and not in the other.

use bevy::{
    asset::AssetPath,
    prelude::*,
    render::{Extract, ExtractSchedule, RenderApp},
    shader::Source,
};

use crate::gbuffer::masked::MaskedPipelines;

/// Modules with the output of vertex shaders, of the prepass and of the main pass.
const MODULES: [&str; 2] = [
    "embedded://bevy_pbr/prepass/prepass_io.wgsl",
    "embedded://bevy_pbr/render/forward_io.wgsl",
];
const POSITION: &str = "    @builtin(position) ";
const INVARIANT: &str = "    @invariant @builtin(position) ";

/// The modules, and if they were looked at since their text changed.
#[derive(Resource)]
struct Modules([(Handle<Shader>, bool); 2]);

/// Bevy's text is not the expected one.
#[derive(Resource)]
struct PositionsVary;

pub(in crate::gbuffer) fn add_to(app: &mut App) {
    app.add_systems(Startup, load_modules)
        // Before the events of this frame's assets, so that no pipeline is compiled from Bevy's text.
        .add_systems(
            Update,
            make_positions_invariant.run_if(resource_exists::<Modules>),
        );
    if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
        render_app.add_systems(ExtractSchedule, draw_masked_meshes_once);
    }
}

fn load_modules(mut commands: Commands, asset_server: Res<AssetServer>) {
    let load = |path| asset_server.load(AssetPath::parse(path).into_owned());
    commands.insert_resource(Modules(MODULES.map(|path| (load(path), false))));
}

fn make_positions_invariant(
    mut commands: Commands,
    mut modules: ResMut<Modules>,
    mut events: MessageReader<AssetEvent<Shader>>,
    mut shaders: ResMut<Assets<Shader>>,
) {
    for event in events.read() {
        for (module, is_done) in &mut modules.0 {
            *is_done &= !event.is_modified(module.id());
        }
    }
    for (module, is_done) in modules.0.iter_mut().filter(|(_, is_done)| !is_done) {
        let Some(Source::Wgsl(text)) = shaders.get(module.id()).map(|shader| &shader.source) else {
            continue;
        };
        *is_done = true;
        if text.contains(INVARIANT) {
            continue;
        }
        if text.matches(POSITION).count() != 1 {
            warn_once!(
                "Alpha-masked meshes are drawn once, which is slower where many lie behind one another: `prepass_io.wgsl` or `forward_io.wgsl` \
                is not Bevy 0.19's."
            );
            commands.insert_resource(PositionsVary);
            continue;
        }
        let text = text.replace(POSITION, INVARIANT);
        if let Some(mut shader) = shaders.get_mut(module.id()) {
            shader.source = Source::Wgsl(text.into());
        }
    }
}

fn draw_masked_meshes_once(
    vary: Extract<Option<Res<PositionsVary>>>,
    mut masked: ResMut<MaskedPipelines>,
) {
    if vary.is_some() && masked.are_in_use() {
        masked.turn_off();
    }
}
