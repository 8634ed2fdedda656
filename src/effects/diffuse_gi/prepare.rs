//! Per-view resources of the passes: uniform, textures and bind groups. Bind groups are recreated only when their resources change.

use bevy::{
    camera::MainPassResolutionOverride,
    core_pipeline::prepass::{MotionVectorPrepass, ViewPrepassTextures},
    diagnostic::FrameCount,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{BindGroup, BindingResource, DynamicUniformBuffer, IntoBinding, Texture},
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
    pipelines::{GiPipelines, LEVEL_COUNT, LEVELS_FORMAT, LIGHT_FORMAT, PASSES},
    uniforms::GiUniform,
};
use crate::{
    effects::{
        history_validity::{FrameNumber, HistoryValidity, LastFrame},
        shown_exposure::{BoundedByWhite, ShownExposure},
        world_shift::WorldShift,
    },
    gbuffer::GBufferTextures,
    gpu::{
        bind_group_cache::CachedBindGroup, storage_texture::StorageTexture,
        texture_bytes::texture_bytes,
    },
    shader_library::tiles,
    view::{
        ActiveLeanView, CameraCuts, DiffuseLight, FrameAveraging, IndirectDiffuse, LightingIo,
        OutOfMemory,
    },
};

/// Texels per side that a workgroup of the first pass writes.
const LEVELS_SIDE: u32 = 16;
/// Texels per side of a block of the second pass.
const GATHER_SIDE: u32 = 32;
/// Workgroups that share such a block.
const PHASES: u32 = 16;

/// Uniforms of all views.
#[derive(Resource, Default)]
pub(super) struct GiUniforms(DynamicUniformBuffer<GiUniform>);

impl GiUniforms {
    /// `None` without views.
    pub(super) fn binding(&self) -> Option<BindingResource<'_>> {
        self.0.binding()
    }
}

/// On a view with diffuse GI: its history, and the outputs of the passes.
#[derive(Component)]
pub struct ViewGi {
    /// Of this frame and the last one, alternating.
    levels: [StorageTexture<{ LEVEL_COUNT as usize }>; 2],
    current: usize,
    gathered: StorageTexture,
    output: StorageTexture,
    texture_size: UVec2,
    pub(super) viewport_size: UVec2,
    /// Motion vectors reproject moving meshes; otherwise only the camera's motion is known.
    has_motion: bool,
    pub(super) frames: HistoryValidity,
    pub(super) offset: u32,
    shown_exposure: ShownExposure,
}

impl ViewGi {
    fn new(
        device: &RenderDevice,
        view: &ExtractedView,
        texture_size: UVec2,
        frames: HistoryValidity,
    ) -> Self {
        let levels = "lean_deferred/effects/diffuse_gi/levels";
        let light = |label| StorageTexture::new(device, label, texture_size, LIGHT_FORMAT);
        Self {
            levels: [(); 2]
                .map(|()| StorageTexture::new(device, levels, texture_size, LEVELS_FORMAT)),
            current: 0,
            gathered: light("lean_deferred/effects/diffuse_gi/gathered"),
            output: light("lean_deferred/effects/diffuse_gi/output"),
            texture_size,
            viewport_size: UVec2::ZERO,
            has_motion: false,
            frames,
            offset: 0,
            shown_exposure: ShownExposure::new(device, view),
        }
    }

    /// Workgroups of the passes.
    pub(super) fn workgroups(&self) -> [UVec2; PASSES.len()] {
        let of = |side: u32| self.texture_size.map(|length| length.div_ceil(side));
        [
            of(LEVELS_SIDE),
            of(GATHER_SIDE) * UVec2::new(PHASES, 1),
            tiles::count(self.texture_size),
        ]
    }

    /// Parameters of the last frame; `None` if its levels are invalid for this frame.
    pub fn last(&self) -> Option<&LastFrame> {
        self.frames.last()
    }

    pub(super) fn bytes(&self) -> u64 {
        self.textures().map(texture_bytes).sum::<u64>() + self.shown_exposure.bytes()
    }

    /// All textures that it holds.
    pub fn textures(&self) -> impl Iterator<Item = &Texture> {
        let levels = self.levels.iter().map(|levels| &levels.texture);
        levels.chain([&self.gathered.texture, &self.output.texture])
    }
}

impl BoundedByWhite for ViewGi {
    fn shown_exposure(&self) -> &ShownExposure {
        &self.shown_exposure
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
        Option<&MainPassResolutionOverride>,
        Option<&CameraCuts>,
        (Option<&FrameAveraging>, Has<MotionVectorPrepass>),
        (Option<&mut ViewGi>, &mut IndirectDiffuse),
    )>,
) {
    let Some(mut writer) = (uniforms.0).get_writer(views.iter().len(), &device, &queue) else {
        return;
    };
    for (entity, (active, lean), (camera, view), resolution, cuts, of_view, of_gi) in &mut views {
        let ((averaging, has_motion), (gi, mut found)) = (of_view, of_gi);
        if !lean.io.contains(LightingIo::INDIRECT_DIFFUSE) {
            continue;
        }
        let now = LastFrame::of(view, resolution, camera.exposure, &shift);
        let mut made = None;
        let size = GiUniform::new(&active.settings, &now, None).texture_size;
        let gi = match gi {
            Some(gi) if gi.texture_size == size => {
                let gi = gi.into_inner();
                gi.frames.advance(now, cuts, &number);
                gi.current = 1 - gi.current;
                gi
            }
            _ => {
                let make = || ViewGi::new(&device, view, size, HistoryValidity::new(now, cuts));
                let Some(new) =
                    memory.fit(&device, entity, "lean_deferred/effects/diffuse_gi", make)
                else {
                    found.0 = None;
                    commands.entity(entity).remove::<ViewGi>();
                    continue;
                };
                made.insert(new)
            }
        };
        let mut uniform = GiUniform::new(&active.settings, &now, gi.frames.last());
        uniform.turn = FrameAveraging::turn(averaging, &frame);
        uniform.has_motion = has_motion.into();
        gi.has_motion = has_motion;
        gi.viewport_size = uniform.viewport_size;
        gi.offset = writer.write(&uniform);
        found.0 = Some(gi.output.view.clone());
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
        (&ActiveGi, &ViewGi),
        (&GBufferTextures, &ViewDepthTexture, &DiffuseLight),
        Option<&ViewPrepassTextures>,
        Option<&mut GiBindings>,
    )>,
) {
    let (Some(pipelines), Some(uniforms)) = (pipelines, uniforms.binding()) else {
        return;
    };
    for (entity, (active, gi), (gbuffer, depth, light), prepass, bindings) in &mut views {
        let mut made = None;
        let bindings = match bindings {
            Some(bindings) => bindings.into_inner(),
            None => made.insert(GiBindings::default()),
        };
        bindings.current = gi.current;
        let (levels, last) = (&gi.levels[gi.current], &gi.levels[1 - gi.current]);
        let resource = |binding: u32| {
            Some(match binding {
                VIEW => uniforms.clone(),
                DEPTH_TEXTURE => depth.view().into_binding(),
                NORMAL_TEXTURE => gbuffer.normal.default_view.into_binding(),
                DIFFUSE_LIGHT_TEXTURE => light.0.default_view.into_binding(),
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
        for (group, pass) in groups.iter_mut().zip(pipelines.of(active.key)) {
            group.bind(&device, &pass.layout, resource);
        }
        if let Some(made) = made {
            commands.entity(entity).insert(made);
        }
    }
}
