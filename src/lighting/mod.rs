//! The lighting pass: one compute dispatch over the packed G-buffer, in workgroups of 8×8 pixels, and a second one over the tiles
//! that have special surfaces.
//!
//! It lights each pixel as Bevy's forward pass does, by the same formulas: directional, point, spot and rectangular lights, shadow maps and
//! contact shadows, environment maps, reflection probes, irradiance volumes, lightmaps, clustered decals, ambient light, fog. Its
//! shader is compiled for what the view has of these, and binds nothing else. [`LightCulling`](crate::LightCulling) says how it passes by
//! lights that do not reach a pixel.
//!
//! Systems that must run before or after it in `Core3d` order themselves by [`LightingPasses`]. All others of Bevy's main pass run after it.
//! It is timed as `lean_deferred/lighting`.

// - `features.rs`: what a view has to be lit with, and so what its shader is compiled with and binds.
// - `variants.rs`: what it is compiled with for special surfaces.
// - `tile_list.{rs,wgsl}`: where on the screen these are.
// - `light_layers.{rs,wgsl}`, `light_layer_table.rs`: which lights affect which meshes, and the table in which the
//   shader finds that.
// - `pipeline.rs`: layouts and pipelines. `bevy_definitions.rs`: what Bevy's part of the shader is compiled with.
// - `inputs.rs`, `buffers.rs`: what it reads. `binding_numbers.rs`, `bindings.rs`, `view_entries.rs`: what of that it binds, and
//   where; made anew only when something of it changed.
// - `soft_shadows.rs`: a sampler of shadow maps.
// - `diffuse_light.rs`: the texture of diffuse light, for effects that read it.
// - `pass.rs`: the dispatches.
// - `lighting.wgsl`, `shade.wgsl`, `surface.wgsl`, `bindings.wgsl`: the shader. `visibility.wgsl`: ambient occlusion in it.
//   `debug_view.wgsl`: channels of the G-buffer in place of light.
// - `lights/`: light from each kind of source, diffuse and specular apart. `lit.wgsl`, `shading_point.wgsl`, `brdf.wgsl`: what
//   they share. `found_light.wgsl`: what other effects have found. `reach.wgsl`, `clustered_lights.wgsl`: the lights that can
//   reach a tile, and the loop over them.

#[doc(hidden)]
pub mod bevy_definitions;
#[doc(hidden)]
pub mod binding_numbers;
mod bindings;
mod buffers;
mod diffuse_light;
mod features;
mod inputs;
mod light_layer_table;
mod light_layers;
mod pass;
mod pipeline;
mod soft_shadows;
#[doc(hidden)]
pub mod subsurface_light;
mod tile_list;
mod variants;
mod view_entries;

pub use crate::view::LightingPasses;
// For tests and benches.
pub(crate) use features::{LightingKey, SceneFeatures};
pub(crate) use pass::lighting_pass;
pub(crate) use pipeline::LightingPipelines;
pub(crate) use subsurface_light::{
    BLOCK_LOG as SUBSURFACE_BLOCK_LOG, SUBSURFACE_LIGHT_FORMAT, prepare_subsurface_light,
};
#[doc(hidden)]
pub use {
    buffers::LightingUniform, light_layer_table::LightLayersTable,
    subsurface_light::SubsurfaceLight,
};

use bevy::{
    asset::embedded_asset,
    core_pipeline::{
        core_3d::main_opaque_pass_3d,
        schedule::{Core3d, Core3dSystems},
    },
    pbr::{MeshPipelineSystems, prepare_mesh_view_bind_groups},
    prelude::*,
    render::{
        GpuResourceAppExt, Render, RenderApp, RenderStartup, RenderSystems,
        render_resource::{BindGroup, CachedComputePipelineId},
        renderer::RenderDevice,
    },
    shader::load_shader_library,
};

use crate::{
    ambient_occlusion,
    view::{
        ActiveLeanView, DiffuseLight, EffectSystems, LeanDeferred, SharedPlugin,
        ViewTextureSystems, removal,
    },
};

/// On a view: everything its lighting pass needs. Dropped with the effect.
#[doc(hidden)]
#[derive(Component, Default)]
pub struct ViewLighting {
    /// The keys and pipelines of this frame, that for plain surfaces first.
    pub(crate) pipelines: Vec<(LightingKey, CachedComputePipelineId)>,
    tile_list: Option<tile_list::TileList>,
    light_layers: Option<light_layer_table::LightLayersBuffer>,
    bindings: bindings::ViewLightingBindings,
}

impl ViewLighting {
    /// Makes the list of tiles anew if it is not the one that `key` needs.
    fn update_tile_list(&mut self, device: &RenderDevice, key: LightingKey, capacity: u32) {
        if key.listed.is_empty() {
            self.tile_list = None;
        } else if !(self.tile_list.as_ref()).is_some_and(|list| list.fits(capacity)) {
            self.tile_list = Some(tile_list::TileList::new(device, capacity));
        }
    }

    /// The bind groups that stay as they are from frame to frame until something that they bind is replaced: light
    /// probes and decals, and the G-buffer with either main texture. Another one, of the view, follows Bevy, which
    /// makes the buffers of the light clusters anew in each frame.
    pub fn lasting_bind_groups(&self) -> impl Iterator<Item = &BindGroup> {
        self.bindings.lasting()
    }

    /// How many textures of light probes and decals are bound.
    pub fn textures_in_arrays(&self) -> usize {
        self.bindings.textures_in_arrays()
    }
}

/// Lights the packed G-buffer.
pub(crate) struct LightingPlugin;

impl Plugin for LightingPlugin {
    fn build(&self, app: &mut App) {
        SharedPlugin::add_to(app);
        ambient_occlusion::load_shader_library(app);
        load_shader_library!(app, "bindings.wgsl");
        load_shader_library!(app, "surface.wgsl");
        load_shader_library!(app, "subsurface_light.wgsl");
        load_shader_library!(app, "scattering_tiles.wgsl");
        load_shader_library!(app, "tile_list.wgsl");
        load_shader_library!(app, "light_layers.wgsl");
        load_shader_library!(app, "visibility.wgsl");
        load_shader_library!(app, "shade.wgsl");
        load_shader_library!(app, "debug_view.wgsl");
        load_shader_library!(app, "lights/lit.wgsl");
        load_shader_library!(app, "lights/shading_point.wgsl");
        load_shader_library!(app, "lights/brdf.wgsl");
        load_shader_library!(app, "lights/shadow_maps.wgsl");
        load_shader_library!(app, "lights/contact_shadow.wgsl");
        load_shader_library!(app, "lights/directional_light.wgsl");
        load_shader_library!(app, "lights/rect_light.wgsl");
        load_shader_library!(app, "lights/clustered_light.wgsl");
        load_shader_library!(app, "lights/reach.wgsl");
        load_shader_library!(app, "lights/clustered_lights.wgsl");
        load_shader_library!(app, "lights/indirect_light.wgsl");
        load_shader_library!(app, "lights/found_light.wgsl");
        embedded_asset!(app, "lighting.wgsl");

        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        removal::remove_with::<LeanDeferred, ViewLighting>(render_app);
        removal::remove_with::<ActiveLeanView, (DiffuseLight, SubsurfaceLight)>(render_app);
        render_app
            .init_gpu_resource::<buffers::LightingBuffers>()
            .init_gpu_resource::<soft_shadows::BlockerSampler>()
            .init_resource::<light_layers::LightLayers>()
            .add_systems(
                ExtractSchedule,
                light_layers::extract_light_layers.in_set(EffectSystems::Lean),
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
                        light_layer_table::write_light_layers,
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
    }
}
