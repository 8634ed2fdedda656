//! The lighting pass: a compute dispatch over the packed G-buffer in workgroups of 8×8 pixels, and an indirect dispatch over the
//! tiles with special surfaces.
//!
//! Lights each pixel with the formulas of Bevy's forward pass: directional, point, spot and rectangular lights, shadow maps and
//! contact shadows, environment maps, reflection probes, irradiance volumes, lightmaps, clustered decals, ambient light, fog. The
//! shader is compiled for, and binds, only those that the view has. Until it is compiled, general pipelines light the view: they have
//! all parts, skip those that the view does not need, and bind placeholders for what it lacks. [`LightCulling`](crate::LightCulling)
//! selects how out-of-range lights are culled.
//!
//! Systems that must run before or after it in `Core3d` order themselves by [`LightingPasses`]. All others of Bevy's main pass run
//! after it. Its GPU time is recorded as `lean_deferred/lighting`.

// - `features.rs`: selects the pipeline of a view from its features.
// - `tile_list.{rs,wgsl}`: the list of tiles with special surfaces.
// - `light_layers.{rs,wgsl}`: the layers of lights, decals and light probes, which limit the meshes that each affects.
// - `light_layer_table.rs`: these layers as the shader reads them.
// - `layouts.rs`: layouts of bind groups.
// - `pipeline.rs`: pipelines.
// - `coverage.rs`: views that pipelines light beside those that they fit.
// - `general.rs`: general pipelines, which light a view until those compiled for it are there.
// - `level.rs`: pipelines that fit a whole level, for cameras that are prewarmed.
// - `placeholders.rs`: what the general pipelines bind in place of resources that a view does not have.
// - `definitions.rs`: shader definitions of the crate's part of the shader, by the pipeline key.
// - `implied.rs`: those that follow from others.
// - `parts.{rs,wgsl}`: parts that the general pipelines skip where a view does not need them.
// - `state.rs`: the state of a view.
// - `inputs.rs`: the inputs, per view and of the scene.
// - `buffers.rs`: the crate's own buffers.
// - `bindings.rs`: bind groups, recreated only when a bound resource has changed.
// - `binding_numbers.rs`, `bindings.wgsl`: binding numbers and declarations of the crate's own bindings.
// - `bevy/`: rules of Bevy that are repeated: shader definitions, bindings, indices of lights, the background, shadows.
// - `diffuse_light.rs`: the texture of diffuse light, for effects that read it.
// - `subsurface_light.{rs,wgsl}`: the light that enters scattering surfaces, for the scattering pass.
// - `scattering_tiles.wgsl`: writes that light and marks its tiles.
// - `pass.rs`: the dispatches.
// - `fragment.{rs,wgsl}`: the same by a fragment shader, for benches.
// - `lighting.wgsl`: the entry point.
// - `shade.wgsl`: the light of a pixel.
// - `surface.wgsl`: unpacks the G-buffer for Bevy's lighting functions.
// - `visibility.wgsl`: applies ambient occlusion.
// - `debug_view.wgsl`: shows channels of the G-buffer or parts of the light in place of all light.
// - `forward/`: lights meshes that Bevy's passes draw.
// - `lights/`: the light of each kind of source.
// - `lights/emission.wgsl`: emitted light.
// - `lights/lit.wgsl`: outgoing light, diffuse and specular apart.
// - `lights/environment.wgsl`, `lights/irradiance_volumes.wgsl`: light of environment maps and light probes.
// - `lights/shading_point.wgsl`, `lights/brdf.wgsl`: terms and BRDF that all lights share.
// - `lights/screen_space_light.wgsl`: indirect light that other effects computed.
// - `lights/reach.wgsl`: culls lights that reach no pixel of a tile.
// - `lights/clustered_lights.wgsl`: the loop over point and spot lights.

#[doc(hidden)]
pub mod bevy;
#[doc(hidden)]
pub mod binding_numbers;
mod bindings;
mod buffers;
mod coverage;
mod definitions;
mod diffuse_light;
mod features;
#[doc(hidden)]
pub mod forward;
#[cfg(feature = "test_hooks")]
mod fragment;
mod general;
#[doc(hidden)]
pub mod implied;
mod inputs;
mod layouts;
mod level;
mod light_layer_table;
mod light_layers;
#[doc(hidden)]
pub mod parts;
mod pass;
mod pipeline;
mod placeholders;
mod state;
#[doc(hidden)]
pub mod subsurface_light;
mod tile_list;

pub use crate::view::LightingPasses;
pub use forward::define_lean_lighting;
#[cfg(feature = "test_hooks")]
pub use fragment::LightsByFragments;
// For tests and benches.
pub(crate) use features::{LightingKey, SceneFeatures, SceneLights};
use forward::ForwardLightPlugin;
pub(crate) use level::LevelLights;
pub(crate) use pass::lighting_pass;
pub(crate) use pipeline::LightingPipelines;
pub(crate) use subsurface_light::{
    BLOCK_LOG as SUBSURFACE_BLOCK_LOG, SUBSURFACE_LIGHT_FORMAT, prepare_subsurface_light,
};
#[doc(hidden)]
pub use {
    buffers::LightingUniform, general::CompiledLighting, light_layer_table::LightLayersTable,
    state::ViewLighting, subsurface_light::SubsurfaceLight,
};

use self::bevy::soft_shadows::BlockerSampler;

use ::bevy::{
    asset::embedded_asset,
    core_pipeline::{
        core_3d::main_opaque_pass_3d,
        schedule::{Core3d, Core3dSystems},
    },
    pbr::{MeshPipelineSystems, prepare_mesh_view_bind_groups},
    prelude::*,
    render::{GpuResourceAppExt, Render, RenderApp, RenderStartup, RenderSystems},
    shader::load_shader_library,
};

use crate::view::{
    ActiveLeanView, DiffuseLight, EffectSystems, LeanDeferred, PrewarmExtraction, SharedPlugin,
    ViewTextureSystems, memory, removal,
};

/// Lights the packed G-buffer.
pub(crate) struct LightingPlugin;

impl Plugin for LightingPlugin {
    fn build(&self, app: &mut App) {
        SharedPlugin::add_to(app);
        load_shader_library!(app, "bindings.wgsl");
        load_shader_library!(app, "parts.wgsl");
        load_shader_library!(app, "surface.wgsl");
        load_shader_library!(app, "subsurface_light.wgsl");
        load_shader_library!(app, "scattering_tiles.wgsl");
        load_shader_library!(app, "tile_list.wgsl");
        load_shader_library!(app, "light_layers.wgsl");
        load_shader_library!(app, "visibility.wgsl");
        load_shader_library!(app, "shade.wgsl");
        load_shader_library!(app, "debug_view.wgsl");
        load_shader_library!(app, "lights/lit.wgsl");
        load_shader_library!(app, "lights/emission.wgsl");
        load_shader_library!(app, "lights/shading_point.wgsl");
        load_shader_library!(app, "lights/brdf.wgsl");
        load_shader_library!(app, "bevy/shadow_maps.wgsl");
        load_shader_library!(app, "bevy/contact_shadow.wgsl");
        load_shader_library!(app, "lights/directional_light.wgsl");
        load_shader_library!(app, "lights/rect_light.wgsl");
        load_shader_library!(app, "lights/clustered_light.wgsl");
        load_shader_library!(app, "lights/reach.wgsl");
        load_shader_library!(app, "lights/clustered_lights.wgsl");
        load_shader_library!(app, "lights/light_probe.wgsl");
        load_shader_library!(app, "lights/irradiance_volumes.wgsl");
        load_shader_library!(app, "lights/environment.wgsl");
        load_shader_library!(app, "lights/indirect_light.wgsl");
        load_shader_library!(app, "lights/screen_space_light.wgsl");
        embedded_asset!(app, "lighting.wgsl");
        app.add_plugins(ForwardLightPlugin);

        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        removal::remove_with::<LeanDeferred, ViewLighting>(render_app);
        removal::remove_with::<ActiveLeanView, (DiffuseLight, SubsurfaceLight)>(render_app);
        memory::count(
            render_app,
            |memory| &mut memory.lighting,
            ViewLighting::bytes,
        );
        render_app
            .init_gpu_resource::<buffers::LightingBuffers>()
            .init_gpu_resource::<BlockerSampler>()
            .init_resource::<light_layers::LightLayers>()
            .init_resource::<CompiledLighting>()
            .init_resource::<LevelLights>()
            .add_systems(
                ExtractSchedule,
                (
                    light_layers::extract_light_layers.in_set(EffectSystems::Lean),
                    level::extract_level_lights.in_set(PrewarmExtraction),
                    level::forget_levels,
                ),
            )
            .add_systems(
                RenderStartup,
                pipeline::init_lighting_pipelines.after(MeshPipelineSystems),
            )
            .add_systems(
                Render,
                (
                    (
                        diffuse_light::prepare_diffuse_light,
                        subsurface_light::prepare_subsurface_light,
                    )
                        .in_set(ViewTextureSystems),
                    buffers::write_lighting_buffers.in_set(RenderSystems::PrepareResources),
                    (
                        buffers::write_light_layers,
                        bindings::prepare_lighting_bind_groups,
                    )
                        .chain()
                        .in_set(RenderSystems::PrepareBindGroups)
                        .after(prepare_mesh_view_bind_groups),
                )
                    .in_set(EffectSystems::Lean),
            )
            .add_systems(
                Core3d,
                pass::lighting_pass
                    .in_set(EffectSystems::Lean)
                    .in_set(LightingPasses)
                    .in_set(Core3dSystems::MainPass)
                    .before(main_opaque_pass_3d),
            );
        #[cfg(feature = "test_hooks")]
        fragment::add_to(app);
    }
}
