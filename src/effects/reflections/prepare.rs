//! Per-view resources of the passes: uniform, textures and bind groups. Bind groups are recreated only when their resources change.

use bevy::{
    camera::MainPassResolutionOverride,
    core_pipeline::prepass::{MotionVectorPrepass, ViewPrepassTextures},
    diagnostic::FrameCount,
    pbr::DistanceFog,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{BindGroup, DynamicUniformBuffer, IntoBinding, Texture, TextureView},
        renderer::{RenderDevice, RenderQueue},
        texture::FallbackImageZero,
        view::{ExtractedView, ViewDepthTexture},
    },
};

use super::{
    active::ActiveReflections,
    binding_numbers::{
        DEPTH_SAMPLER, DEPTH_TEXTURE, FILTERED_OUTPUT, FILTERED_TEXTURE, HI_Z_OUTPUT, HI_Z_TEXTURE,
        HISTORY_SAMPLER, HISTORY_TEXTURE, HITS_OUTPUT, HITS_TEXTURE, LOBES_OUTPUT, LOBES_TEXTURE,
        MOTION_TEXTURE, NORMAL_TEXTURE, OUTPUT_TEXTURE, RAYS_OUTPUT, RAYS_TEXTURE,
        SPECIALIZATION_TEXTURE, SURFACES_OUTPUT, SURFACES_TEXTURE, VALID_MASK_TEXTURE, VIEW,
    },
    fixtures::ReflectionFixtures,
    pipelines::{
        HI_Z_FORMAT, HITS_FORMAT, LIGHT_FORMAT, LOBES_FORMAT, PASSES, ReflectionPipelines,
        SURFACES_FORMAT,
    },
    uniforms::ReflectionUniform,
};
use crate::{
    effects::{
        debug_view::RayHits, history::ViewHistory, history_validity::LastFrame, resolution,
        world_shift::WorldShift,
    },
    gbuffer::GBufferTextures,
    gpu::{
        bind_group_cache::CachedBindGroup, growing_size::GrowingSize,
        storage_texture::StorageTexture, texture_bytes::texture_bytes,
    },
    shader_library::{distance_fog::FogUniform, tiles},
    view::{
        ActiveLeanView, FrameAveraging, GBufferTargets, IndirectSpecular, LightingIo, OutOfMemory,
    },
};

/// Pixels per side of the largest cells.
const LARGEST_CELL: u32 = 64;
/// Side of a workgroup, in texels when it writes lobes, and in pixels when it resolves. Same value as in `texels.wgsl`.
pub const WORKGROUP_SIDE: u32 = 16;
/// Frames in which scattered rays take all of their directions. Same value as in `lobes.wgsl`.
pub const PHASES: u32 = 4;

/// Uniforms of all views.
#[derive(Resource, Default)]
pub(super) struct ReflectionUniforms(DynamicUniformBuffer<ReflectionUniform>);

/// On a view with reflections: the outputs of the passes.
#[derive(Component)]
pub struct ViewReflections {
    hi_z: StorageTexture,
    surfaces: StorageTexture,
    rays: StorageTexture,
    hits: StorageTexture,
    filtered: StorageTexture,
    /// This frame's, and the last one's, in turns.
    lobes: [StorageTexture; 2],
    output: StorageTexture,
    growing: GrowingSize,
    /// Size of `output`. Other textures follow from it, and from the side of their texels.
    allocated: UVec2,
    divisor: u32,
    /// Number of the frame in which the view has these textures.
    phase: u32,
    viewport_size: UVec2,
    texture_size: UVec2,
    /// Motion vectors reproject moving meshes; otherwise only the camera's motion is known.
    has_motion: bool,
    pub(super) offset: u32,
}

impl ViewReflections {
    /// Textures for viewports of up to `allocated` pixels, with texels of `divisor` pixels per side.
    fn new(device: &RenderDevice, allocated: UVec2, divisor: u32) -> Self {
        let hi_z = cell_count(allocated);
        // Cells of 4, 16 and 64 pixels, stacked vertically.
        let hi_z = UVec2::new(hi_z.x * 16, hi_z.y * (16 + 4 + 1));
        let texels = resolution::texels(allocated, divisor);
        let texture = |label, size, format| StorageTexture::new(device, label, size, format);
        Self {
            hi_z: texture("lean_deferred/effects/reflections/hi_z", hi_z, HI_Z_FORMAT),
            surfaces: texture(
                "lean_deferred/effects/reflections/surfaces",
                texels,
                SURFACES_FORMAT,
            ),
            rays: texture(
                "lean_deferred/effects/reflections/rays",
                texels,
                LIGHT_FORMAT,
            ),
            hits: texture(
                "lean_deferred/effects/reflections/hits",
                texels,
                HITS_FORMAT,
            ),
            filtered: texture(
                "lean_deferred/effects/reflections/spatial_filter",
                texels,
                LIGHT_FORMAT,
            ),
            lobes: [(); 2].map(|()| {
                texture(
                    "lean_deferred/effects/reflections/lobes",
                    texels,
                    LOBES_FORMAT,
                )
            }),
            output: texture(
                "lean_deferred/effects/reflections/output",
                allocated,
                LIGHT_FORMAT,
            ),
            growing: default(),
            allocated,
            divisor,
            phase: 0,
            viewport_size: UVec2::ZERO,
            texture_size: UVec2::ZERO,
            has_motion: false,
            offset: 0,
        }
    }

    /// Workgroups of the passes.
    pub(super) fn workgroups(&self) -> [UVec2; PASSES.len()] {
        let of = |size: UVec2| size.map(|length| length.div_ceil(WORKGROUP_SIDE));
        [
            cell_count(self.viewport_size),
            tiles::count(self.texture_size),
            of(self.texture_size),
            of(self.viewport_size),
        ]
    }

    /// Index of the texture of lobes that this frame writes.
    pub(super) fn written(&self) -> usize {
        (self.phase % 2) as usize
    }

    pub(super) fn bytes(&self) -> u64 {
        self.textures().map(texture_bytes).sum()
    }

    /// The cells, as rays of forward meshes read them.
    pub(super) fn hi_z(&self) -> &TextureView {
        &self.hi_z.view
    }

    /// All textures that it holds.
    pub fn textures(&self) -> impl Iterator<Item = &Texture> {
        [
            &self.hi_z,
            &self.surfaces,
            &self.rays,
            &self.hits,
            &self.filtered,
            &self.output,
        ]
        .into_iter()
        .chain(&self.lobes)
        .map(|held| &held.texture)
    }
}

/// Number of the largest cells in a viewport.
fn cell_count(viewport_size: UVec2) -> UVec2 {
    viewport_size.map(|side| side.div_ceil(LARGEST_CELL).max(1))
}

/// Creates missing textures, sets [`IndirectSpecular`] to the output, and writes [`ReflectionUniforms`].
pub(super) fn prepare_reflections(
    mut commands: Commands,
    mut uniforms: ResMut<ReflectionUniforms>,
    (device, queue): (Res<RenderDevice>, Res<RenderQueue>),
    frame: Res<FrameCount>,
    shift: Res<WorldShift>,
    mut memory: ResMut<OutOfMemory>,
    mut views: Query<(
        Entity,
        (&ActiveReflections, &ActiveLeanView),
        (&ExtractedCamera, &ExtractedView),
        (Option<&MainPassResolutionOverride>, Option<&DistanceFog>),
        (Option<&FrameAveraging>, Has<MotionVectorPrepass>),
        Option<&ViewHistory>,
        (
            Option<&mut ViewReflections>,
            &mut IndirectSpecular,
            Has<RayHits>,
        ),
    )>,
) {
    let Some(mut writer) = (uniforms.0).get_writer(views.iter().len(), &device, &queue) else {
        return;
    };
    let largest = device.limits().max_texture_dimension_2d;
    for (entity, (active, lean), (camera, view), shown, of_view, history, held) in &mut views {
        let (resolution, fog) = shown;
        let ((averaging, has_motion), (reflections, mut found, has_hits)) = (of_view, held);
        // The first frame has no history.
        let Some(history) = history else {
            found.0 = None;
            continue;
        };
        if !lean.io.contains(LightingIo::INDIRECT_SPECULAR) {
            continue;
        }
        let now = LastFrame::of(view, resolution, camera.exposure, &shift);
        let mut uniform =
            ReflectionUniform::new(&active.settings, active.key.divisor, &now, history.last());
        uniform.fog = FogUniform::new(fog);
        uniform.history_size = history.size().as_vec2();
        uniform.turn = FrameAveraging::turn(averaging, &frame);
        uniform.has_specialization = lean.targets.contains(GBufferTargets::SPECIALIZATION).into();
        uniform.shows_hits = active.shows_hits.into();
        let mut made = None;
        let (size, divisor) = (uniform.viewport_size, active.key.divisor);
        let mut growing = reflections
            .as_ref()
            .map(|held| held.growing)
            .unwrap_or_default();
        let allocated = growing.fit(size, largest, false);
        let fits = |held: &ViewReflections| (held.allocated, held.divisor) == (allocated, divisor);
        let reflections = match reflections {
            Some(held) if fits(&held) => {
                let held = held.into_inner();
                held.phase = held.phase.wrapping_add(1);
                uniform.has_lobes = history.last().is_some().into();
                held
            }
            _ => {
                let label = "lean_deferred/effects/reflections";
                let make = |size| ViewReflections::new(&device, size, divisor);
                let Some(new) = memory.fit_growing(&device, entity, label, &mut growing, make)
                else {
                    found.0 = None;
                    commands.entity(entity).remove::<ViewReflections>();
                    continue;
                };
                made.insert(new)
            }
        };
        uniform.has_motion = has_motion.into();
        // Hits that are shown rest.
        uniform.phase = if active.shows_hits {
            0
        } else {
            reflections.phase % PHASES
        };
        reflections.growing = growing;
        reflections.viewport_size = size;
        reflections.texture_size = uniform.texture_size;
        reflections.has_motion = has_motion;
        reflections.offset = writer.write(&uniform);
        found.0 = Some(reflections.output.view.clone());
        if active.shows_hits {
            let texture = reflections.hits.view.clone();
            let hits = RayHits { texture, divisor };
            commands.entity(entity).insert(hits);
        } else if has_hits {
            commands.entity(entity).remove::<RayHits>();
        }
        if let Some(made) = made {
            commands.entity(entity).insert(made);
        }
    }
}

/// On a view with reflections: the bind groups of its passes, for frames that write either texture of lobes.
#[derive(Component, Default)]
pub struct ReflectionBindings([[CachedBindGroup; PASSES.len()]; 2]);

impl ReflectionBindings {
    /// Bind groups in the order of the passes, for a frame that writes texture `written` of lobes.
    pub(super) fn groups(&self, written: usize) -> [Option<&BindGroup>; PASSES.len()] {
        self.0[written].each_ref().map(CachedBindGroup::get)
    }

    /// Bind groups that are reused across frames while nothing changes.
    pub fn lasting_bind_groups(&self) -> impl Iterator<Item = &BindGroup> {
        self.0.iter().flatten().filter_map(CachedBindGroup::get)
    }
}

/// Updates the bind groups of all active views.
pub(super) fn prepare_reflection_bind_groups(
    mut commands: Commands,
    device: Res<RenderDevice>,
    pipelines: Option<Res<ReflectionPipelines>>,
    (uniforms, fixtures): (Res<ReflectionUniforms>, Res<ReflectionFixtures>),
    no_motion: Res<FallbackImageZero>,
    mut views: Query<(
        Entity,
        (&ViewReflections, &ViewHistory),
        (&GBufferTextures, &ViewDepthTexture),
        Option<&ViewPrepassTextures>,
        Option<&mut ReflectionBindings>,
    )>,
) {
    let (Some(pipelines), Some(uniforms)) = (pipelines, uniforms.0.binding()) else {
        return;
    };
    for (entity, (held, history), (gbuffer, depth), prepass, bindings) in &mut views {
        let fixtures = fixtures.get(&device);
        let mut made = None;
        let bindings = match bindings {
            Some(bindings) => bindings.into_inner(),
            None => made.insert(ReflectionBindings::default()),
        };
        let special = gbuffer.optional(GBufferTargets::SPECIALIZATION);
        let written = held.written();
        let valid_mask = special.and(gbuffer.valid_mask.as_ref());
        let resource = |binding: u32| {
            let view = match binding {
                VIEW => return Some(uniforms.clone()),
                DEPTH_SAMPLER => return Some(fixtures.depth_sampler.into_binding()),
                HISTORY_SAMPLER => return Some(fixtures.history_sampler.into_binding()),
                DEPTH_TEXTURE => depth.view(),
                NORMAL_TEXTURE => &gbuffer.normal.default_view,
                VALID_MASK_TEXTURE => valid_mask.map_or(&fixtures.nothing, |t| &t.default_view),
                SPECIALIZATION_TEXTURE => special.map_or(&fixtures.nothing, |t| &t.default_view),
                MOTION_TEXTURE if held.has_motion => {
                    &prepass?.motion_vectors.as_ref()?.texture.default_view
                }
                MOTION_TEXTURE => &no_motion.texture_view,
                HISTORY_TEXTURE => history.view(),
                HI_Z_TEXTURE | HI_Z_OUTPUT => &held.hi_z.view,
                SURFACES_TEXTURE | SURFACES_OUTPUT => &held.surfaces.view,
                RAYS_TEXTURE | RAYS_OUTPUT => &held.rays.view,
                HITS_TEXTURE | HITS_OUTPUT => &held.hits.view,
                FILTERED_TEXTURE | FILTERED_OUTPUT => &held.filtered.view,
                LOBES_TEXTURE => &held.lobes[1 - written].view,
                LOBES_OUTPUT => &held.lobes[written].view,
                OUTPUT_TEXTURE => &held.output.view,
                _ => return None,
            };
            Some(view.into_binding())
        };
        for (group, layout) in bindings.0[written].iter_mut().zip(pipelines.layouts()) {
            group.bind(&device, layout, resource);
        }
        if let Some(made) = made {
            commands.entity(entity).insert(made);
        }
    }
}
