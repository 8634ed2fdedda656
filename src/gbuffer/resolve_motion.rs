//! Resolves motion vectors of lean meshes into the texture in which Bevy's prepass writes those of all others.
//!
//! On a view with `MotionVectorPrepass`, lean meshes skip Bevy's prepass. Those that move or deform write the motion
//! target of the G-buffer. A full-screen triangle then writes the motion of these and of static ones to
//! `ViewPrepassTextures::motion_vectors`, which temporal anti-aliasing and motion blur read. It discards pixels without
//! a lean mesh, which keep the output of Bevy's prepass: forward-only meshes and the background.
//!
//! This is a raster pass because Bevy creates that texture without `STORAGE_BINDING`, and not every device can store to
//! `Rg16Float`.
//!
//! With two-phase occlusion culling it runs after each phase. After the first, the G-buffer marks the pixels of lean
//! meshes. Bevy's late prepass then overdraws some of them. After the second, pixels of lean meshes are therefore those
//! whose depth differs from the copy that the late prepass made. That copy exists only with `DepthPrepass`; views
//! without it, and those with `NormalPrepass`, leave motion vectors to Bevy's prepass.

use bevy::{
    asset::load_embedded_asset,
    core_pipeline::{
        FullscreenShader,
        prepass::{
            MOTION_VECTOR_PREPASS_FORMAT, PreviousViewData, PreviousViewUniformOffset,
            PreviousViewUniforms, ViewPrepassTextures,
        },
    },
    platform::collections::HashMap,
    prelude::*,
    render::{
        render_resource::{
            BindGroupLayoutDescriptor, CachedRenderPipelineId, ColorTargetState, ColorWrites,
            FragmentState, IntoBinding, PipelineCache, RenderPassDescriptor,
            RenderPipelineDescriptor, ShaderStages, TextureSampleType,
            binding_types::{texture_2d, texture_depth_2d, uniform_buffer},
        },
        renderer::{RenderContext, RenderDevice},
        view::{ViewDepthTexture, ViewUniform, ViewUniformOffset, ViewUniforms},
    },
};

use super::{
    binding_numbers::resolve_motion::{
        DEPTH_TEXTURE, EARLIER_DEPTH_TEXTURE, MOTION_TEXTURE, NORMAL_TEXTURE, PREVIOUS_VIEW,
        VALID_MASK_TEXTURE, VIEW,
    },
    textures::GBufferTextures,
};
use crate::{
    gpu::{
        bind_group_cache::{CachedBindGroup, ResolvedLayout},
        bindings::layout,
        pipeline_watch::PipelineWatch,
    },
    view::{ActiveLeanView, GBufferTargets},
};

/// Pipeline key of the resolve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct ResolveKey {
    /// Runs after the second phase of culling.
    late: bool,
    /// The view has a motion target.
    motion_target: bool,
}

impl ResolveKey {
    fn layout(self) -> BindGroupLayoutDescriptor {
        let words = || texture_2d(TextureSampleType::Uint);
        let drawn = if self.late {
            (EARLIER_DEPTH_TEXTURE, texture_depth_2d())
        } else {
            (NORMAL_TEXTURE, words())
        };
        let motion = [(MOTION_TEXTURE, words()), (VALID_MASK_TEXTURE, words())];
        layout(
            "lean_deferred/gbuffer/resolve_motion",
            ShaderStages::FRAGMENT,
            [
                (VIEW, uniform_buffer::<ViewUniform>(true)),
                (PREVIOUS_VIEW, uniform_buffer::<PreviousViewData>(true)),
                (DEPTH_TEXTURE, texture_depth_2d()),
                drawn,
            ]
            .into_iter()
            .chain(motion.into_iter().filter(|_| self.motion_target)),
        )
    }
}

/// The pipelines of the resolve, queued when a view first needs them.
#[derive(Resource)]
pub(crate) struct MotionResolvePipelines {
    shader: Handle<Shader>,
    fullscreen_shader: FullscreenShader,
    by_key: HashMap<ResolveKey, (CachedRenderPipelineId, ResolvedLayout)>,
}

pub(super) fn init_motion_resolve_pipelines(
    mut commands: Commands,
    asset_server: Res<AssetServer>,
    fullscreen_shader: Res<FullscreenShader>,
) {
    commands.insert_resource(MotionResolvePipelines {
        shader: load_embedded_asset!(asset_server.as_ref(), "resolve_motion.wgsl"),
        fullscreen_shader: fullscreen_shader.clone(),
        by_key: HashMap::default(),
    });
}

impl MotionResolvePipelines {
    /// True if all pipelines that a view may need are compiled, with and without a motion target. Queues missing ones, as far as
    /// the budget of `watch` admits.
    pub(crate) fn are_ready(
        &mut self,
        cache: &PipelineCache,
        watch: &PipelineWatch,
        in_two_phases: bool,
    ) -> bool {
        let mut ready = true;
        for late in [false, true] {
            for motion_target in [false, true] {
                if late <= in_two_phases {
                    let key = ResolveKey {
                        late,
                        motion_target,
                    };
                    let is_requested = self.by_key.contains_key(&key) || watch.budget.admits();
                    ready &= is_requested && {
                        let pipeline = self.specialize(cache, key);
                        cache.get_render_pipeline(pipeline).is_some()
                    };
                }
            }
        }
        ready
    }

    fn specialize(&mut self, cache: &PipelineCache, key: ResolveKey) -> CachedRenderPipelineId {
        let entry = self.by_key.entry(key).or_insert_with(|| {
            let layout = ResolvedLayout::new(cache, key.layout());
            let mut shader_defs = Vec::new();
            if key.late {
                shader_defs.push("LATE".into());
            }
            if key.motion_target {
                shader_defs.push(GBufferTargets::MOTION.shader_def().into());
            }
            let pipeline = cache.queue_render_pipeline(RenderPipelineDescriptor {
                label: Some("lean_deferred/gbuffer/resolve_motion".into()),
                layout: vec![layout.descriptor().clone()],
                vertex: self.fullscreen_shader.to_vertex_state(),
                fragment: Some(FragmentState {
                    shader: self.shader.clone(),
                    shader_defs,
                    targets: vec![Some(ColorTargetState {
                        format: MOTION_VECTOR_PREPASS_FORMAT,
                        blend: None,
                        write_mask: ColorWrites::ALL,
                    })],
                    ..default()
                }),
                ..default()
            });
            (pipeline, layout)
        });
        entry.0
    }
}

/// Bind groups, early and late, of a view that resolves motion, and their pipelines.
#[derive(Component, Default)]
pub struct ViewMotionResolve {
    offsets: [u32; 2],
    pipelines: [Option<CachedRenderPipelineId>; 2],
    groups: [CachedBindGroup; 2],
}

pub(super) fn prepare_motion_resolve(
    mut commands: Commands,
    pipelines: Option<Res<MotionResolvePipelines>>,
    device: Res<RenderDevice>,
    (view_uniforms, previous_uniforms): (Res<ViewUniforms>, Res<PreviousViewUniforms>),
    mut views: Query<(
        Entity,
        &ActiveLeanView,
        (&GBufferTextures, &ViewDepthTexture, &ViewPrepassTextures),
        (&ViewUniformOffset, &PreviousViewUniformOffset),
        Option<&mut ViewMotionResolve>,
    )>,
    stale: Query<(Entity, Option<&ActiveLeanView>), With<ViewMotionResolve>>,
) {
    for (entity, active) in &stale {
        if !active.is_some_and(|active| active.resolves_motion) {
            commands.entity(entity).remove::<ViewMotionResolve>();
        }
    }
    let (Some(pipelines), Some(view_binding), Some(previous_binding)) = (
        pipelines,
        view_uniforms.uniforms.binding(),
        previous_uniforms.uniforms.binding(),
    ) else {
        return;
    };
    for (entity, active, (textures, depth, prepass), (offset, previous_offset), resolve) in
        &mut views
    {
        if !active.resolves_motion {
            continue;
        }
        let mut made = ViewMotionResolve::default();
        let exists = resolve.is_some();
        let resolve = resolve.map_or(&mut made, Mut::into_inner);
        resolve.offsets = [offset.offset, previous_offset.offset];
        for (index, late) in [false, true].into_iter().enumerate() {
            resolve.pipelines[index] = None;
            let motion =
                (textures.optional(GBufferTargets::MOTION)).zip(textures.valid_mask.as_ref());
            let (drawn_binding, drawn) = match (late, &prepass.depth) {
                (false, _) => (NORMAL_TEXTURE, &textures.normal),
                (true, Some(earlier)) if active.culls_in_two_phases => {
                    (EARLIER_DEPTH_TEXTURE, &earlier.texture)
                }
                _ => continue,
            };
            let key = ResolveKey {
                late,
                motion_target: motion.is_some(),
            };
            let Some((pipeline, layout)) = pipelines.by_key.get(&key) else {
                continue;
            };
            resolve.groups[index].update(&device, layout, |entries| {
                entries.push(VIEW, view_binding.clone())?;
                entries.push(PREVIOUS_VIEW, previous_binding.clone())?;
                entries.push(DEPTH_TEXTURE, depth.view().into_binding())?;
                entries.push(drawn_binding, drawn.default_view.into_binding())?;
                match motion {
                    Some((motion, written)) => {
                        entries.push(MOTION_TEXTURE, motion.default_view.into_binding())?;
                        entries.push(VALID_MASK_TEXTURE, written.default_view.into_binding())
                    }
                    None => Some(()),
                }
            });
            resolve.pipelines[index] = Some(*pipeline);
        }
        if !exists {
            commands.entity(entity).insert(made);
        }
    }
}

impl ViewMotionResolve {
    /// Draws the resolve after the early or the late pass of the G-buffer, before depth is copied.
    pub(super) fn draw(
        &self,
        late: bool,
        prepass: &ViewPrepassTextures,
        viewport: Option<&bevy::camera::Viewport>,
        cache: &PipelineCache,
        ctx: &mut RenderContext,
    ) {
        let index = usize::from(late);
        let (Some(motion_vectors), Some(pipeline), Some(group)) = (
            &prepass.motion_vectors,
            self.pipelines[index].and_then(|id| cache.get_render_pipeline(id)),
            self.groups[index].get(),
        ) else {
            return;
        };
        let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some("lean_deferred/gbuffer/resolve_motion"),
            color_attachments: &[Some(motion_vectors.get_attachment())],
            ..default()
        });
        if let Some(viewport) = viewport {
            pass.set_camera_viewport(viewport);
        }
        pass.set_render_pipeline(pipeline);
        pass.set_bind_group(0, group, &self.offsets);
        pass.draw(0..3, 0..1);
    }
}
