//! History textures of views, and their validity.

use bevy::{
    camera::MainPassResolutionOverride,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{
            BindGroup, DynamicUniformBuffer, IntoBinding, PipelineCache, Texture, TextureView,
        },
        renderer::{RenderDevice, RenderQueue},
        texture::CachedTexture,
        view::{ExtractedView, ViewDepthTexture, ViewTarget},
    },
};

use super::{
    binding_numbers::{
        COLOR_TEXTURE, DEPTH_TEXTURE, LEVEL_0, LEVEL_2, LEVEL_3, SHOWN_EXPOSURE, VIEW,
    },
    distance::units_per_metre,
    pipelines::{FORMAT, HistoryKey, HistoryPipelines, LEVELS, PASSES},
    request::ReadsHistory,
    uniforms::HistoryUniform,
};
use crate::{
    effects::{
        history_validity::{FrameNumber, HistoryValidity, LastFrame},
        shown_exposure::{BoundedByWhite, ShownExposure},
        world_shift::WorldShift,
    },
    gpu::{
        bind_group_cache::CachedBindGroup, growing_size::GrowingSize,
        picture_bind_groups::PictureBindGroups, pipeline_watch::PipelineWatch,
        storage_texture::StorageTexture, texture_bytes::texture_bytes,
    },
    view::{CameraCuts, OutOfMemory},
};

const LABEL: &str = "lean_deferred/effects/history";
const LEVEL_COUNT: usize = (LEVELS[0] + LEVELS[1]) as usize;
/// Texels per side that a workgroup reads.
const BLOCK_SIDE: u32 = 16;
/// Side of the last level's texel, in pixels.
const BORDER: u32 = 1 << (LEVEL_COUNT - 1);

/// Uniforms of all views.
#[derive(Resource, Default)]
pub(in crate::effects) struct HistoryUniforms(DynamicUniformBuffer<HistoryUniform>);

/// On a view of the render world with [`ReadsHistory`]: its last frame.
///
/// The texture has the size of that frame's viewport, rounded up to a multiple of the last level's texel, and is larger while that
/// size changes. The picture begins in its corner. Its colour is the lit image, linear
/// and exposed as the last frame was: finite, and at most 1024 times the light that showed as white. Its alpha is the distance of
/// the surface along the view direction, in metres times [`units_per_metre`](Self::units_per_metre); 65504 where there is none.
/// Coarser levels average over their texels: colour is the light of surfaces, 0 for texels without one, and alpha the share of
/// texels with a surface.
#[derive(Component)]
pub struct ViewHistory {
    kept: StorageTexture<LEVEL_COUNT>,
    /// This frame is written to it, and not to `kept`, if its size differs.
    next: Option<StorageTexture<LEVEL_COUNT>>,
    growing: GrowingSize,
    /// Size of the part that this frame writes.
    written: UVec2,
    /// Bind groups of the first dispatch.
    pictures: PictureBindGroups,
    means: CachedBindGroup,
    frames: HistoryValidity,
    offset: u32,
    /// `Some` while the view shows meshes with specular transmission.
    pub(super) opaque_depth: Option<CachedTexture>,
    shown_exposure: ShownExposure,
}

impl ViewHistory {
    /// Parameters of the last frame; `None` if the history is invalid for this frame.
    pub fn last(&self) -> Option<&LastFrame> {
        self.frames.last()
    }

    pub(super) fn bytes(&self) -> u64 {
        let copy = self.opaque_depth.as_ref().map(|copy| &copy.texture);
        let next = self.next.as_ref().map(|next| &next.texture);
        let textures = [&self.kept.texture].into_iter().chain(next).chain(copy);
        textures.map(texture_bytes).sum::<u64>() + self.shown_exposure.bytes()
    }

    /// Unit of the last frame's distances.
    pub fn units_per_metre(&self) -> f32 {
        self.last()
            .map_or(1.0, |last| units_per_metre(last.clip_from_view))
    }

    /// View of all levels.
    pub fn view(&self) -> &TextureView {
        &self.kept.view
    }

    /// Texture of [`view`](Self::view).
    pub fn texture(&self) -> &Texture {
        &self.kept.texture
    }

    /// Texture that this frame is written to.
    fn output(&self) -> &StorageTexture<LEVEL_COUNT> {
        self.next.as_ref().unwrap_or(&self.kept)
    }

    /// Size of the first level, in texels.
    pub fn size(&self) -> UVec2 {
        size_of(&self.kept)
    }

    /// Bind groups of the dispatches, of which the first reads `picture`.
    pub(super) fn bind_groups(&self, picture: &Texture) -> [Option<&BindGroup>; PASSES.len()] {
        [self.pictures.of(picture), self.means.get()]
    }

    /// Bind groups that are reused across frames while nothing changes.
    pub fn lasting_bind_groups(&self) -> impl Iterator<Item = &BindGroup> {
        self.pictures.all().chain(self.means.get())
    }

    pub(super) fn offset(&self) -> u32 {
        self.offset
    }

    /// Workgroups of the dispatches.
    pub(super) fn workgroups(&self) -> [UVec2; PASSES.len()] {
        let last_of_first = self.written >> (LEVELS[0] - 1);
        [self.written, last_of_first].map(|texels| texels.map(|side| side.div_ceil(BLOCK_SIDE)))
    }

    /// Marks this frame's light as stored.
    pub(super) fn hold(&self, number: &FrameNumber) {
        self.frames.hold(number);
    }

    fn new(
        device: &RenderDevice,
        view: &ExtractedView,
        size: UVec2,
        frames: HistoryValidity,
    ) -> Self {
        Self {
            kept: StorageTexture::new(device, LABEL, size, FORMAT),
            next: None,
            growing: default(),
            written: size,
            pictures: default(),
            means: default(),
            frames,
            offset: 0,
            opaque_depth: None,
            shown_exposure: ShownExposure::new(device, view),
        }
    }
}

impl BoundedByWhite for ViewHistory {
    fn shown_exposure(&self) -> &ShownExposure {
        &self.shown_exposure
    }
}

fn size_of(texture: &StorageTexture<LEVEL_COUNT>) -> UVec2 {
    UVec2::new(texture.texture.width(), texture.texture.height())
}

/// Size of the texture for a viewport: a multiple of the last level's texel.
fn texture_size(viewport_size: UVec2) -> UVec2 {
    viewport_size.map(|length| length.max(1).next_multiple_of(BORDER))
}

/// Drops all histories. Runs on each new device.
pub(super) fn forget_histories(mut commands: Commands, views: Query<Entity, With<ViewHistory>>) {
    for view in &views {
        commands.entity(view).remove::<ViewHistory>();
    }
}

/// Creates missing textures, and updates the validity of the others.
pub(in crate::effects) fn prepare_histories(
    mut commands: Commands,
    mut uniforms: ResMut<HistoryUniforms>,
    (device, queue): (Res<RenderDevice>, Res<RenderQueue>),
    (number, shift, mut memory): (Res<FrameNumber>, Res<WorldShift>, ResMut<OutOfMemory>),
    mut views: Query<
        (
            Entity,
            (&ExtractedView, &ExtractedCamera),
            (&Msaa, Has<Camera3d>),
            Option<&MainPassResolutionOverride>,
            Option<&CameraCuts>,
            Option<&mut ViewHistory>,
        ),
        With<ReadsHistory>,
    >,
) {
    let Some(mut writer) = (uniforms.0).get_writer(views.iter().len(), &device, &queue) else {
        return;
    };
    // Multiples of the last level's texel.
    let largest = device.limits().max_texture_dimension_2d & !(BORDER - 1);
    for (entity, (view, camera), (msaa, is_3d), resolution, cuts, history) in &mut views {
        // Multisampled depth cannot be resolved, and the depth of 2D cameras cannot be sampled.
        if msaa.samples() != 1 || !is_3d {
            commands.entity(entity).remove::<ViewHistory>();
            continue;
        }
        let now = LastFrame::of(view, resolution, camera.exposure, &shift);
        let needed = texture_size(now.viewport.size());
        let mut growing = history
            .as_ref()
            .map(|held| held.growing)
            .unwrap_or_default();
        let mut size = texture_size(growing.fit(needed, largest, false));
        let mut made = None;
        let held = match history {
            Some(history) => {
                let history = history.into_inner();
                history.frames.advance(now, cuts, &number);
                if let Some(next) = history.next.take() {
                    history.kept = next;
                }
                if history.size() != size {
                    let make =
                        |size| StorageTexture::new(&device, LABEL, texture_size(size), FORMAT);
                    history.next = memory.fit_growing(&device, entity, LABEL, &mut growing, make);
                    size = texture_size(growing.allocated());
                }
                (size_of(history.output()) == size).then_some(history)
            }
            None => {
                let frames = HistoryValidity::new(now, cuts);
                let make = || ViewHistory::new(&device, view, size, frames);
                made = memory.fit(&device, entity, LABEL, make);
                made.as_mut()
            }
        };
        let Some(history) = held else {
            commands.entity(entity).remove::<ViewHistory>();
            continue;
        };
        history.growing = growing;
        // A border of the last pixels, so that readers interpolate with these at the edge.
        history.written = (needed + BORDER).min(size);
        history.offset = writer.write(&HistoryUniform::new(&now));
        if let Some(made) = made {
            commands.entity(entity).insert(made);
        }
    }
}

/// Updates the bind groups of all views with a history.
pub(in crate::effects) fn prepare_history_bind_groups(
    device: Res<RenderDevice>,
    (cache, watch): (Res<PipelineCache>, Res<PipelineWatch>),
    pipelines: Option<ResMut<HistoryPipelines>>,
    uniforms: Res<HistoryUniforms>,
    mut views: Query<(&mut ViewHistory, &ViewTarget, &ViewDepthTexture)>,
) {
    let (Some(mut pipelines), Some(uniforms)) = (pipelines, uniforms.0.binding()) else {
        return;
    };
    for (mut history, target, depth) in &mut views {
        let history = &mut *history;
        let depth = match &history.opaque_depth {
            Some(copy) => &copy.default_view,
            None => depth.view(),
        };
        let shown_exposure = &history.shown_exposure;
        let output = history.next.as_ref().unwrap_or(&history.kept);
        let (first, rest) = output.levels.split_at(LEVELS[0] as usize);
        let [of_picture, of_level] = pipelines.specialize(&cache, &watch, HistoryKey) else {
            continue;
        };
        (history.pictures).bind(&device, of_picture, target, |binding, picture| {
            Some(match binding {
                COLOR_TEXTURE => picture.into_binding(),
                LEVEL_0..=LEVEL_3 => first[(binding - LEVEL_0) as usize].into_binding(),
                VIEW => uniforms.clone(),
                DEPTH_TEXTURE => depth.into_binding(),
                SHOWN_EXPOSURE => shown_exposure.binding(),
                _ => return None,
            })
        });
        (history.means).bind(&device, of_level, |binding| {
            Some(match binding {
                COLOR_TEXTURE => first.last()?.into_binding(),
                LEVEL_0..=LEVEL_2 => rest[(binding - LEVEL_0) as usize].into_binding(),
                _ => return None,
            })
        });
    }
}
