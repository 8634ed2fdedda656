//! Per-view resources of the passes: uniform and bind groups, and the creation of textures. Bind groups are recreated only when their
//! resources change.

use bevy::{
    camera::MainPassResolutionOverride,
    core_pipeline::prepass::{MotionVectorPrepass, ViewPrepassTextures},
    diagnostic::FrameCount,
    pbr::DistanceFog,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{BindGroup, BindingResource, DynamicUniformBuffer, IntoBinding},
        renderer::{RenderDevice, RenderQueue},
        texture::FallbackImageZero,
        view::{ExtractedView, ViewDepthTexture},
    },
};

use super::{
    active::ActiveGi,
    binding_numbers::{
        DEPTH_TEXTURE, DIFFUSE_LIGHT_TEXTURE, GATHERED_OUTPUT, GATHERED_TEXTURE, LAST_LEVELS,
        LEVEL_0, LEVEL_3, LEVELS, MOTION_TEXTURE, NORMAL_TEXTURE, OUTPUT_TEXTURE, SHOWN_EXPOSURE,
        VIEW,
    },
    pipelines::{GiPipelines, PASSES},
    textures::ViewGi,
    uniforms::GiUniform,
};
use crate::{
    effects::{
        history_validity::{FrameNumber, HistoryValidity, LastFrame},
        world_shift::WorldShift,
    },
    gbuffer::GBufferTextures,
    gpu::bind_group_cache::CachedBindGroup,
    shader_library::distance_fog::FogUniform,
    view::{
        ActiveLeanView, CameraCuts, DiffuseLight, FrameAveraging, IndirectDiffuse, LightingIo,
        OutOfMemory,
    },
};

const LABEL: &str = "lean_deferred/effects/diffuse_gi";

/// Uniforms of all views.
#[derive(Resource, Default)]
pub(super) struct GiUniforms(DynamicUniformBuffer<GiUniform>);

impl GiUniforms {
    /// `None` without views.
    pub(super) fn binding(&self) -> Option<BindingResource<'_>> {
        self.0.binding()
    }
}

/// Creates missing textures, sets [`IndirectDiffuse`] to the output, and writes [`GiUniforms`].
pub(super) fn prepare_gi(
    mut commands: Commands,
    mut uniforms: ResMut<GiUniforms>,
    (device, queue): (Res<RenderDevice>, Res<RenderQueue>),
    (frame, number): (Res<FrameCount>, Res<FrameNumber>),
    shift: Res<WorldShift>,
    mut memory: ResMut<OutOfMemory>,
    mut views: Query<(
        Entity,
        (&ActiveGi, &ActiveLeanView),
        (&ExtractedCamera, &ExtractedView),
        (Option<&MainPassResolutionOverride>, Option<&DistanceFog>),
        Option<&CameraCuts>,
        (Option<&FrameAveraging>, Has<MotionVectorPrepass>),
        (Option<&mut ViewGi>, &mut IndirectDiffuse),
    )>,
) {
    let Some(mut writer) = (uniforms.0).get_writer(views.iter().len(), &device, &queue) else {
        return;
    };
    let largest = device.limits().max_texture_dimension_2d;
    for (entity, (active, lean), (camera, view), shown, cuts, of_view, of_gi) in &mut views {
        let (resolution, fog) = shown;
        let ((averaging, has_motion), (gi, mut found)) = (of_view, of_gi);
        if !lean.io.contains(LightingIo::INDIRECT_DIFFUSE) {
            continue;
        }
        let now = LastFrame::of(view, resolution, camera.exposure, &shift);
        let mut made = None;
        let GiUniform {
            texture_size: size,
            divisor,
            ..
        } = GiUniform::new(&active.settings, &now, None);
        let mut growing = gi.as_ref().map(|gi| gi.growing).unwrap_or_default();
        let has_other_texels =
            (gi.as_ref()).is_some_and(|gi| gi.levels[gi.current].divisor != divisor);
        let allocated = growing.fit(size, largest, has_other_texels);
        let held = match gi {
            Some(gi) => {
                let gi = gi.into_inner();
                gi.frames.advance(now, cuts, &number);
                gi.current = 1 - gi.current;
                let is_of_size = gi.is_of(allocated);
                let resize = |size| gi.resize(&device, size);
                let is_resized = is_of_size
                    || (memory.fit_growing(&device, entity, LABEL, &mut growing, resize)).is_some();
                is_resized.then_some(gi)
            }
            None => {
                let make = || ViewGi::new(&device, view, size, HistoryValidity::new(now, cuts));
                made = memory.fit(&device, entity, LABEL, make);
                made.as_mut()
            }
        };
        let Some(gi) = held else {
            *found = IndirectDiffuse::default();
            commands.entity(entity).remove::<ViewGi>();
            continue;
        };
        let mut uniform = GiUniform::new(&active.settings, &now, gi.frames.last());
        gi.growing = growing;
        gi.texture_size = size;
        gi.levels[gi.current].divisor = uniform.divisor;
        gi.levels[gi.current].size = size;
        let last = &gi.levels[1 - gi.current];
        uniform.last_divisor = last.divisor;
        uniform.last_texture_size = last.size;
        uniform.fog = FogUniform::new(fog);
        uniform.turn = FrameAveraging::turn(averaging, &frame);
        uniform.has_motion = has_motion.into();
        gi.has_motion = has_motion;
        gi.viewport_size = uniform.viewport_size;
        gi.offset = writer.write(&uniform);
        *found = IndirectDiffuse {
            texture: Some(gi.output.view.clone()),
            is_half: uniform.divisor == 2,
        };
        if let Some(made) = made {
            commands.entity(entity).insert(made);
        }
    }
}

/// On a view with diffuse GI: the bind groups of its passes.
#[derive(Component, Default)]
pub struct GiBindings {
    /// By the index of this frame's levels.
    groups: [[CachedBindGroup; PASSES.len()]; 2],
    current: usize,
}

impl GiBindings {
    /// Bind groups in the order of the passes.
    pub(super) fn current_groups(&self) -> &[CachedBindGroup; PASSES.len()] {
        &self.groups[self.current]
    }

    /// Bind groups that are reused across frames while nothing changes.
    pub fn lasting_bind_groups(&self) -> impl Iterator<Item = &BindGroup> {
        let groups = self.groups.iter().flatten();
        groups.filter_map(CachedBindGroup::get)
    }
}

/// Updates the bind groups of all active views.
pub(super) fn prepare_gi_bind_groups(
    mut commands: Commands,
    device: Res<RenderDevice>,
    pipelines: Option<Res<GiPipelines>>,
    (uniforms, no_motion): (Res<GiUniforms>, Res<FallbackImageZero>),
    mut views: Query<(
        Entity,
        &ViewGi,
        (&GBufferTextures, &ViewDepthTexture, &DiffuseLight),
        Option<&ViewPrepassTextures>,
        Option<&mut GiBindings>,
    )>,
) {
    let (Some(pipelines), Some(uniforms)) = (pipelines, uniforms.binding()) else {
        return;
    };
    for (entity, gi, (gbuffer, depth, light), prepass, bindings) in &mut views {
        let mut made = None;
        let bindings = match bindings {
            Some(bindings) => bindings.into_inner(),
            None => made.insert(GiBindings::default()),
        };
        bindings.current = gi.current;
        let [levels, last] = [gi.current, 1 - gi.current].map(|i| &gi.levels[i].texture);
        let resource = |binding: u32| {
            Some(match binding {
                VIEW => uniforms.clone(),
                DEPTH_TEXTURE => depth.view().into_binding(),
                NORMAL_TEXTURE => gbuffer.normal.default_view.into_binding(),
                DIFFUSE_LIGHT_TEXTURE => light.last.default_view.into_binding(),
                MOTION_TEXTURE if gi.has_motion => {
                    let motion = prepass?.motion_vectors.as_ref()?;
                    motion.texture.default_view.into_binding()
                }
                MOTION_TEXTURE => no_motion.texture_view.into_binding(),
                SHOWN_EXPOSURE => gi.shown_exposure.binding(),
                LAST_LEVELS => last.view.into_binding(),
                LEVELS => levels.view.into_binding(),
                LEVEL_0..=LEVEL_3 => levels.levels[(binding - LEVEL_0) as usize].into_binding(),
                GATHERED_TEXTURE | GATHERED_OUTPUT => gi.gathered.view.into_binding(),
                OUTPUT_TEXTURE => gi.output.view.into_binding(),
                _ => return None,
            })
        };
        let groups = &mut bindings.groups[gi.current];
        for (group, layout) in groups.iter_mut().zip(pipelines.layouts()) {
            group.bind(&device, layout, resource);
        }
        if let Some(made) = made {
            commands.entity(entity).insert(made);
        }
    }
}
