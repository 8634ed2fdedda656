//! The packed G-buffer: the surface of each pixel for lighting, in 64 bits beside depth.
//!
//! | target | format | bytes per pixel | contents | allocated |
//! |---|---|---|---|---|
//! | surface | `R32Uint` | 4 | albedo (square roots 7 + 7 + 7), its exponent, metallic and occlusion (10), mesh-normal flag (1) | always |
//! | normal | `R32Uint` | 4 | octahedral shading normal (12 + 12), perceptual roughness (8) | always |
//! | valid mask | `R8Uint` | 1 | mask of the targets below that hold a word of this surface (4), lightmapped light in the first of them (2) | with any of them |
//! | emissive | `R32Uint` | 4 | emitted or lightmapped light (9 + 9 + 9, shared exponent 5) | while a visible mesh writes it |
//! | specialization | `R32Uint` | 4 | specular constant, shading model with its arguments, flags | while a visible mesh writes it |
//! | motion | `R32Uint` | 4 | motion vector (two half floats) | while a visible mesh writes it, with `MotionVectorPrepass` |
//! | visibility mask | `R32Uint` | 4 | render layers of the mesh, one bit each | while a visible mesh writes it, with light layers |
//!
//! Numbers in parentheses are bits. A view has light layers if a light, decal or light probe has layers that exclude some meshes. The
//! last four targets are [`GBufferTargets`]. [`GBufferUsage`], on each lean camera, lists its targets and their bytes.
//!
//! # Meshes
//!
//! The G-buffer has all opaque and alpha-masked meshes whose material fits into it. [`GBufferMaterial::gbuffer_needs`] returns, per
//! material, [`GBufferNeeds`], or the [`ForwardReason`] if it does not fit. Bevy's forward pass draws the others on the same camera,
//! against the same depth; [`LeanForwardMeshes`], added to the camera, counts them by reason. `StandardMaterial` is registered. For
//! your own materials implement [`GBufferMaterial`] (or [`GBufferMaterialExtension`]) and add [`GBufferMaterialPlugin`]; for those of
//! other crates add [`GBufferMaterialPlugin::new`].
//!
//! # Order
//!
//! The systems of [`GBufferPasses`] draw it in `Core3d`, before [`LightingPasses`](crate::lighting::LightingPasses). Render-world
//! systems get the textures from [`GBufferTextures`] on the view. GPU time is recorded as `lean_deferred/gbuffer`.

// - `targets.rs`: the optional targets, and the needs of a material.
// - `forward_reason.rs`: the reasons for which forward draws a mesh.
// - `material.rs`: decides which materials the G-buffer carries.
// - `custom_material.wgsl`: the shader of the example in `material.rs`.
// - `registration.rs`: the plugin that registers materials.
// - `mesh_overrides.rs`: meshes whose other components add to the needs of their material.
// - `moving.rs`: meshes that need motion vectors of their own.
// - `draw_functions.rs`: draws meshes, with or without their previous positions.
// - `demand.rs`: optional targets that the visible meshes of a view need.
// - `masked.rs`, `masked_depth.wgsl`: draws the depth of alpha-masked meshes before the rest of them.
// - `lookup.rs`: the needs of a mesh.
// - `phase.rs`, `phase_item.rs`: the render phases and their items.
// - `pipeline.rs`: specializes pipelines.
// - `specialize.rs`: looks up the pipeline of a mesh.
// - `prewarm.rs`: requests the pipelines of all meshes while cameras are prewarmed.
// - `queue.rs`: sorts meshes into the G-buffer or leaves them to Bevy.
// - `left_meshes.rs`: the meshes that views leave to Bevy, for lighting.
// - `forward_meshes.rs`: reports the meshes that are left to Bevy.
// - `placement.rs`: places meshes in the passes of a view.
// - `next_targets.rs`: prepares meshes for the targets that a view should have next.
// - `visibility_masks.rs`: uniforms of the render layers of meshes.
// - `textures.rs`: allocates the targets.
// - `pass.rs`: the raster passes.
// - `usage.rs`: reports the targets of a camera and their bytes.
// - `resolve_motion.{rs,wgsl}`: resolves motion vectors into Bevy's texture.
// - `bevy/`: rules of Bevy that are repeated, and changes to its phases and passes.
// - `binding_numbers.rs`: binding numbers.
// - `pack.wgsl`: packs a `PbrInput` into the targets.
// - `gbuffer.wgsl`: the fragment shader of `StandardMaterial`.

mod bevy;
#[doc(hidden)]
pub mod binding_numbers;
mod demand;
mod draw_functions;
mod forward_meshes;
mod forward_reason;
mod left_meshes;
mod lookup;
mod masked;
mod material;
mod mesh_overrides;
mod moving;
mod next_targets;
mod pass;
mod phase;
mod phase_item;
mod pipeline;
mod placement;
mod prewarm;
mod queue;
mod registration;
mod resolve_motion;
mod specialize;
mod stand_in;
mod targets;
mod textures;
mod usage;
mod visibility_masks;

pub(crate) use self::bevy::forward_draws::{ForwardDraw, ForwardDrawFunctions, ForwardDraws};
use self::bevy::{
    batching::add_phase,
    depth_copy::{self, DepthCopySystems},
    forward_pipelines, invariant_positions, lightmaps, phases, pipeline_filter,
};
pub use crate::view::{GBufferPasses, GBufferTargets, ShadingModel};
pub(crate) use demand::{ViewDemands, WantedDemand};
use draw_functions::{DrawPlain, DrawWithVisibilityMask};
pub use forward_meshes::LeanForwardMeshes;
pub use forward_reason::ForwardReason;
pub(crate) use left_meshes::LeftMeshes;
pub use material::{GBufferMaterial, GBufferMaterialExtension};
pub(crate) use moving::MovingMeshes;
use phase_item::{
    AlphaMaskGBuffer, ExtendedAlphaMaskGBuffer, ExtendedOpaqueGBuffer, OpaqueGBuffer,
};
pub use registration::GBufferMaterialPlugin;
pub(crate) use resolve_motion::MotionResolvePipelines;
use resolve_motion::ViewMotionResolve;
pub use targets::GBufferNeeds;
pub use textures::{GBufferTextures, ReadsGBuffer};
pub use usage::GBufferUsage;

#[cfg(feature = "test_hooks")]
pub use masked::MaskedPipelines;
// For tests and benches.
#[doc(hidden)]
pub use {crate::shader_library::layout, queue::SortedMeshes};

use ::bevy::{
    asset::embedded_asset,
    core_pipeline::{
        core_3d::{
            extract_camera_prepass_phase, extract_core_3d_camera_phases,
            prepare_core_3d_depth_textures,
        },
        mip_generation::experimental::depth::early_downsample_depth,
        prepass::{
            BackgroundMotionVectorsPipelineId, MotionVectorPrepass,
            node::{early_prepass, late_prepass},
        },
        schedule::{Core3d, Core3dSystems},
    },
    pbr::{
        MeshExtractionSystems, StandardMaterial, main_build_indirect_parameters,
        queue_material_meshes, queue_prepass_material_meshes,
    },
    prelude::*,
    render::{
        ExtractSchedule, GpuResourceAppExt, Render, RenderApp, RenderStartup, RenderSystems,
        camera::DirtySpecializationSystems,
        render_phase::AddRenderCommand,
        render_resource::{SpecializedMeshPipelines, TextureUsages},
    },
    shader::load_shader_library,
};

use crate::{
    shading_models,
    view::{
        ActiveLeanView, EffectSystems, ForwardMeshesQueued, LeanDeferred, SharedPlugin,
        ViewTextureSystems, depth_usage::extend_depth_usage, memory, pass_order::shadow_passes,
        removal,
    },
};

/// Draws the meshes of lean cameras into the packed G-buffer.
pub(crate) struct GBufferPlugin;

impl Plugin for GBufferPlugin {
    fn build(&self, app: &mut App) {
        SharedPlugin::add_to(app);
        shading_models::load(app);
        load_shader_library!(app, "pack.wgsl");
        embedded_asset!(app, "gbuffer.wgsl");
        embedded_asset!(app, "masked_depth.wgsl");
        invariant_positions::add_to(app);
        embedded_asset!(app, "resolve_motion.wgsl");

        add_phase::<OpaqueGBuffer>(app);
        add_phase::<AlphaMaskGBuffer>(app);
        add_phase::<ExtendedOpaqueGBuffer>(app);
        add_phase::<ExtendedAlphaMaskGBuffer>(app);
        app.add_plugins(GBufferMaterialPlugin::<StandardMaterial>::default())
            .register_type::<GBufferTargets>()
            .register_type::<GBufferUsage>()
            .register_type::<LeanForwardMeshes>()
            .add_observer(usage::remove_usage)
            .add_observer(forward_meshes::clear_report);

        // Refused if cameras with `LeanDeferred` exist already; then no camera gets a `GBufferUsage`.
        let _ = app.try_register_required_components::<LeanDeferred, GBufferUsage>();

        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        memory::count::<GBufferTextures>(
            render_app,
            |memory| &mut memory.gbuffer,
            |textures| GBufferUsage::of(textures).bytes(),
        );
        removal::remove_with::<LeanDeferred, (GBufferTextures, ViewMotionResolve)>(render_app);
        // Bevy 0.19 keeps it, and draws with it into a later prepass that has no motion vectors, which ends the app.
        removal::remove_with::<MotionVectorPrepass, BackgroundMotionVectorsPipelineId>(render_app);
        render_app
            .init_resource::<mesh_overrides::MeshOverrides>()
            .init_resource::<mesh_overrides::ChangedMeshes>()
            .init_resource::<lightmaps::LightmappedMeshes>()
            .init_resource::<moving::MovingMeshes>()
            .init_resource::<ViewDemands>()
            .init_resource::<forward_meshes::ForwardMeshes>()
            .init_resource::<LeftMeshes>()
            .init_resource::<SortedMeshes>()
            .init_resource::<prewarm::PrewarmedMeshes>()
            .init_resource::<masked::MaskedPipelines>()
            .init_resource::<specialize::RequestedPipelines>()
            .init_resource::<pipeline_filter::PipelineFilter>()
            .init_resource::<forward_pipelines::WithheldMainPhases>()
            .init_resource::<forward_pipelines::ForwardPipelines>()
            .init_resource::<depth_copy::WithheldDepthCopy>()
            .init_gpu_resource::<queue::PendingGBufferQueues>()
            .init_gpu_resource::<SpecializedMeshPipelines<pipeline::GBufferPipelineSpecializer>>()
            .init_resource::<visibility_masks::VisibilityMasks>()
            .add_render_command::<ExtendedOpaqueGBuffer, DrawPlain<true>>()
            .add_render_command::<ExtendedAlphaMaskGBuffer, DrawPlain<true>>()
            .add_render_command::<ExtendedOpaqueGBuffer, DrawWithVisibilityMask<false>>()
            .add_render_command::<ExtendedAlphaMaskGBuffer, DrawWithVisibilityMask<false>>()
            .add_render_command::<ExtendedOpaqueGBuffer, DrawWithVisibilityMask<true>>()
            .add_render_command::<ExtendedAlphaMaskGBuffer, DrawWithVisibilityMask<true>>()
            .add_systems(
                RenderStartup,
                (
                    resolve_motion::init_motion_resolve_pipelines,
                    visibility_masks::forget_uploaded_visibility_masks,
                    lightmaps::forget_lightmapped_meshes,
                ),
            )
            .add_systems(
                ExtractSchedule,
                (
                    usage::report_usage,
                    forward_meshes::report_forward_meshes,
                    phase::extract_gbuffer_phases,
                    phases::drop_phases_of_views_without_pixels
                        .after(extract_core_3d_camera_phases)
                        .after(extract_camera_prepass_phase),
                    (
                        mesh_overrides::clear_changed_meshes,
                        mesh_overrides::extract_mesh_overrides,
                        moving::extract_moving_meshes,
                    )
                        .chain()
                        .after(MeshExtractionSystems),
                )
                    .in_set(EffectSystems::Lean),
            )
            // Runs without lean cameras too: it also prevents an error in Bevy's own passes.
            .add_systems(
                ExtractSchedule,
                lightmaps::extract_lightmapped_meshes
                    .in_set(DirtySpecializationSystems::CheckForChanges),
            )
            .add_systems(
                Render,
                (
                    forward_pipelines::withhold_main_phases
                        .after(RenderSystems::CreateViews)
                        .before(RenderSystems::Specialize),
                    forward_pipelines::restore_main_phases
                        .after(RenderSystems::Specialize)
                        .before(RenderSystems::PrepareViews),
                    (
                        queue::queue_gbuffer_meshes,
                        // Exclusive, but of the data of unordered systems it uses none.
                        forward_pipelines::specialize_left_meshes
                            .run_if(pipeline_filter::pipelines_are_missing)
                            .ambiguous_with_all(),
                        forward_pipelines::compile_waiting_pipelines
                            .run_if(forward_pipelines::pipelines_wait)
                            .ambiguous_with_all(),
                        pipeline_filter::filter_pipelines,
                    )
                        .chain()
                        .in_set(RenderSystems::QueueMeshes)
                        .before(queue_material_meshes)
                        .before(queue_prepass_material_meshes),
                    prewarm::prewarm_meshes
                        .in_set(RenderSystems::QueueMeshes)
                        .after(queue::queue_gbuffer_meshes)
                        .before(queue_material_meshes)
                        .before(queue_prepass_material_meshes),
                    pipeline_filter::restore_pipelines
                        .in_set(ForwardMeshesQueued)
                        .in_set(RenderSystems::QueueMeshes)
                        .after(queue_material_meshes)
                        .after(queue_prepass_material_meshes),
                    extend_depth_usage::<ActiveLeanView>(TextureUsages::TEXTURE_BINDING),
                    textures::prepare_gbuffer_textures.in_set(ViewTextureSystems),
                    textures::fit_gbuffer_textures_to_depth
                        .in_set(RenderSystems::PrepareResources)
                        .after(prepare_core_3d_depth_textures),
                    visibility_masks::upload_visibility_masks
                        .in_set(RenderSystems::PrepareResources),
                    resolve_motion::prepare_motion_resolve.in_set(RenderSystems::PrepareBindGroups),
                )
                    .in_set(EffectSystems::Lean),
            )
            .add_systems(
                Core3d,
                (
                    depth_copy::withhold_depth_copy
                        .in_set(DepthCopySystems)
                        .in_set(Core3dSystems::Prepass)
                        .before(early_prepass),
                    pass::early_gbuffer_pass
                        .in_set(Core3dSystems::Prepass)
                        .after(early_prepass)
                        .before(early_downsample_depth),
                    depth_copy::allow_late_depth_copy
                        .in_set(DepthCopySystems)
                        .in_set(Core3dSystems::Prepass)
                        .after(pass::early_gbuffer_pass)
                        .before(late_prepass),
                    pass::late_gbuffer_pass
                        .in_set(Core3dSystems::Prepass)
                        .after(late_prepass)
                        .before(main_build_indirect_parameters),
                    depth_copy::copy_depth
                        .in_set(DepthCopySystems)
                        .in_set(Core3dSystems::Prepass)
                        .after(pass::late_gbuffer_pass)
                        .before(main_build_indirect_parameters),
                    pass::main_gbuffer_pass
                        .after(main_build_indirect_parameters)
                        .before(Core3dSystems::MainPass),
                )
                    .in_set(GBufferPasses)
                    .in_set(EffectSystems::Lean),
            );
        for pass in shadow_passes() {
            render_app.configure_sets(Core3d, DepthCopySystems.ambiguous_with(pass));
        }
    }
}
