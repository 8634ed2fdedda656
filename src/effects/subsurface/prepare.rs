//! Per-view resources of the passes: uniforms, scattered light and bind groups. Bind groups are recreated only when their resources
//! change.

use bevy::{
    camera::MainPassResolutionOverride,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{BindGroup, DynamicUniformBuffer, IntoBinding, Texture},
        renderer::{RenderDevice, RenderQueue},
        view::{ExtractedView, ViewTarget},
    },
};

use super::{
    active::ActiveScattering,
    binding_numbers::{
        COARSER_TEXTURE, ENTERING_TEXTURE, LAST_OUTPUT, LEVEL_OUTPUT, LIGHT_TEXTURE, NEXT_OUTPUT,
        NORMAL_TEXTURE, OUTPUT_TEXTURE, PICTURE_TEXTURE, SCATTERED_OUTPUT, SCATTERED_TEXTURE,
        TILES, VIEW,
    },
    pipelines::{PASSES, SubsurfacePipelines},
    uniforms::SubsurfaceUniform,
};
use crate::{
    effects::history_validity::LastFrame,
    gbuffer::GBufferTextures,
    gpu::{
        bind_group_cache::CachedBindGroup, picture_bind_groups::PictureBindGroups,
        storage_texture::StorageTexture, texture_bytes::texture_bytes,
    },
    lighting::{SUBSURFACE_BLOCK_LOG, SUBSURFACE_LIGHT_FORMAT, SubsurfaceLight},
    view::{ActiveLeanView, OutOfMemory},
};

const LABEL: &str = "lean_deferred/effects/subsurface/scattered";
/// Level of the light that each pass reads.
const READ: [usize; PASSES.len()] = [0, 2, 5, 3, 1, 0];
/// Finest level that each pass writes; the last pass writes the image.
const WRITTEN: [u32; PASSES.len()] = [1, 3, 5, 3, 1, 0];

/// Uniforms of all views, one per pass.
#[derive(Resource, Default)]
pub(super) struct SubsurfaceUniforms(DynamicUniformBuffer<SubsurfaceUniform>);

/// On a view with subsurface scattering.
#[derive(Component)]
pub struct ViewSubsurface {
    /// Scattered light of levels 1, 3 and 5; the passes compute the levels in between on the fly.
    scattered: StorageTexture<5>,
    pub(super) size: UVec2,
    /// Offsets of the uniforms, by pass.
    pub(super) offsets: [u32; PASSES.len()],
    /// Bind groups of all passes but the last.
    groups: [CachedBindGroup; PASSES.len() - 1],
    /// Those of the last.
    picture: PictureBindGroups,
}

impl ViewSubsurface {
    fn new(device: &RenderDevice, size: UVec2) -> Self {
        Self {
            scattered: StorageTexture::new(device, LABEL, size / 2, SUBSURFACE_LIGHT_FORMAT),
            size,
            offsets: default(),
            groups: default(),
            picture: default(),
        }
    }

    /// The bind group of a pass; that of the last pass writes to `picture`.
    pub(super) fn group(&self, pass: usize, picture: &Texture) -> Option<&BindGroup> {
        match self.groups.get(pass) {
            Some(group) => group.get(),
            None => self.picture.of(picture),
        }
    }

    /// Bind groups that are reused across frames while nothing changes.
    pub fn lasting_bind_groups(&self) -> impl Iterator<Item = &BindGroup> {
        let groups = self.groups.iter().filter_map(CachedBindGroup::get);
        self.picture.all().chain(groups)
    }

    pub(super) fn bytes(&self) -> u64 {
        texture_bytes(self.texture())
    }

    /// GPU memory that it holds in addition to [`SubsurfaceLight`].
    pub fn texture(&self) -> &Texture {
        &self.scattered.texture
    }
}

/// Inserts or removes [`ViewSubsurface`], and writes [`SubsurfaceUniforms`]. Runs after [`SubsurfaceLight`] is created.
pub(super) fn prepare_subsurface(
    mut commands: Commands,
    mut uniforms: ResMut<SubsurfaceUniforms>,
    (device, queue): (Res<RenderDevice>, Res<RenderQueue>),
    mut memory: ResMut<OutOfMemory>,
    mut views: Query<(
        Entity,
        (&ActiveScattering, &ActiveLeanView),
        (&ExtractedCamera, &ExtractedView),
        Option<&MainPassResolutionOverride>,
        Option<&SubsurfaceLight>,
        Option<&mut ViewSubsurface>,
    )>,
) {
    let count = views.iter().len() * PASSES.len();
    let Some(mut writer) = (uniforms.0).get_writer(count, &device, &queue) else {
        return;
    };
    for (entity, (active, lean), (camera, view), resolution, light, held) in &mut views {
        let Some(light) = light.filter(|_| lean.scatters()) else {
            if held.is_some() {
                commands.entity(entity).remove::<ViewSubsurface>();
            }
            continue;
        };
        let size = light.size();
        let now = LastFrame::of(view, resolution, camera.exposure, &default());
        let mut made = None;
        let held = match held {
            Some(held) if held.size == size => held.into_inner(),
            _ => {
                let make = || ViewSubsurface::new(&device, size);
                let Some(new) = memory.fit(&device, entity, LABEL, make) else {
                    commands.entity(entity).remove::<ViewSubsurface>();
                    continue;
                };
                made.insert(new)
            }
        };
        let blocks = size >> SUBSURFACE_BLOCK_LOG;
        held.offsets = WRITTEN.map(|level| {
            let settings = &active.settings;
            writer.write(&SubsurfaceUniform::new(settings, &now, blocks, level))
        });
        if let Some(made) = made {
            commands.entity(entity).insert(made);
        }
    }
}

/// Updates the bind groups of all views with subsurface scattering.
pub(super) fn prepare_subsurface_bind_groups(
    device: Res<RenderDevice>,
    pipelines: Option<Res<SubsurfacePipelines>>,
    uniforms: Res<SubsurfaceUniforms>,
    mut views: Query<(
        &mut ViewSubsurface,
        &SubsurfaceLight,
        &GBufferTextures,
        &ViewTarget,
    )>,
) {
    let (Some(pipelines), Some(uniforms)) = (pipelines, uniforms.0.binding()) else {
        return;
    };
    for (mut held, subsurface, gbuffer, target) in &mut views {
        let ViewSubsurface {
            scattered,
            groups,
            picture,
            ..
        } = &mut *held;
        let light = &subsurface.light.levels;
        let scattered_at = |level: usize| &scattered.levels[level - 1];
        for (number, layout) in pipelines.layouts().iter().enumerate() {
            let level = READ[number];
            let resource = |binding: u32| {
                let view = match binding {
                    VIEW => return Some(uniforms.clone()),
                    TILES => return Some(subsurface.tiles.as_entire_binding()),
                    LIGHT_TEXTURE => &light[level],
                    COARSER_TEXTURE | LEVEL_OUTPUT => &light[level + 1],
                    NEXT_OUTPUT => &light[level + 2],
                    LAST_OUTPUT => &light[level + 3],
                    // The pass before wrote it.
                    SCATTERED_TEXTURE => scattered_at(WRITTEN[number - 1] as usize),
                    SCATTERED_OUTPUT => scattered_at(level),
                    NORMAL_TEXTURE => &gbuffer.normal.default_view,
                    ENTERING_TEXTURE => &light[0],
                    PICTURE_TEXTURE => &subsurface.picture.view,
                    _ => return None,
                };
                Some(view.into_binding())
            };
            if let Some(group) = groups.get_mut(number) {
                group.bind(&device, layout, resource);
            } else {
                picture.bind(&device, layout, target, |binding, output| match binding {
                    OUTPUT_TEXTURE => Some(output.into_binding()),
                    _ => resource(binding),
                });
            }
        }
    }
}
