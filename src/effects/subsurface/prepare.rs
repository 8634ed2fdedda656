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
        NORMAL_TEXTURE, OUTPUT_TEXTURE, PICTURE_TEXTURE, SCATTERED_TEXTURE, TILES, VIEW,
    },
    pipelines::SubsurfacePipelines,
    uniforms::SubsurfaceUniform,
};
use crate::{
    effects::LastFrame,
    gbuffer::GBufferTextures,
    gpu::{
        bind_group_cache::CachedBindGroup, picture_bind_groups::PictureBindGroups,
        storage_texture::StorageTexture, texture_bytes::texture_bytes,
    },
    lighting::{SUBSURFACE_BLOCK_LOG, SUBSURFACE_LIGHT_FORMAT, SubsurfaceLight},
    view::{ActiveLeanView, OutOfMemory},
};

const LABEL: &str = "lean_deferred/effects/subsurface/scattered";
/// Finest level that each pass writes, in order; the last pass writes the image.
pub(super) const PASSES: [u32; 6] = [1, 3, 5, 3, 1, 0];

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
    pub(super) first: CachedBindGroup,
    pub(super) down: CachedBindGroup,
    pub(super) turn: CachedBindGroup,
    pub(super) up: CachedBindGroup,
    pub(super) last: CachedBindGroup,
    pub(super) picture: PictureBindGroups,
}

impl ViewSubsurface {
    fn new(device: &RenderDevice, size: UVec2) -> Self {
        Self {
            scattered: StorageTexture::new(device, LABEL, size / 2, SUBSURFACE_LIGHT_FORMAT),
            size,
            offsets: default(),
            first: default(),
            down: default(),
            turn: default(),
            up: default(),
            last: default(),
            picture: default(),
        }
    }

    /// Bind groups that are reused across frames while nothing changes.
    pub fn lasting_bind_groups(&self) -> impl Iterator<Item = &BindGroup> {
        let groups = [&self.first, &self.down, &self.turn, &self.up, &self.last];
        self.picture
            .all()
            .chain(groups.into_iter().filter_map(CachedBindGroup::get))
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
        held.offsets = PASSES.map(|level| {
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
    let Some(layouts) = pipelines.layouts() else {
        return;
    };
    for (mut held, subsurface, gbuffer, target) in &mut views {
        let ViewSubsurface {
            scattered,
            first,
            down,
            turn,
            up,
            last,
            picture,
            ..
        } = &mut *held;
        let light = &subsurface.light.levels;
        let scattered_at = |level: usize| &scattered.levels[level - 1];
        let tiles = || subsurface.tiles.as_entire_binding();
        let normal = &gbuffer.normal.default_view;
        first.update(&device, &layouts.first, |entries| {
            entries.push(VIEW, uniforms.clone())?;
            entries.push(TILES, tiles())?;
            entries.push(LIGHT_TEXTURE, light[0].into_binding())?;
            entries.push(LEVEL_OUTPUT, light[1].into_binding())?;
            entries.push(NEXT_OUTPUT, light[2].into_binding())
        });
        down.update(&device, &layouts.down, |entries| {
            entries.push(VIEW, uniforms.clone())?;
            entries.push(TILES, tiles())?;
            entries.push(LIGHT_TEXTURE, light[2].into_binding())?;
            entries.push(LEVEL_OUTPUT, light[3].into_binding())?;
            entries.push(NEXT_OUTPUT, light[4].into_binding())?;
            entries.push(LAST_OUTPUT, light[5].into_binding())
        });
        turn.update(&device, &layouts.turn, |entries| {
            entries.push(VIEW, uniforms.clone())?;
            entries.push(TILES, tiles())?;
            entries.push(LIGHT_TEXTURE, light[5].into_binding())?;
            entries.push(LEVEL_OUTPUT, scattered_at(5).into_binding())?;
            entries.push(NORMAL_TEXTURE, normal.into_binding())?;
            entries.push(ENTERING_TEXTURE, light[0].into_binding())
        });
        for (level, group) in [(3, up), (1, last)] {
            group.update(&device, &layouts.up, |entries| {
                entries.push(VIEW, uniforms.clone())?;
                entries.push(TILES, tiles())?;
                entries.push(LIGHT_TEXTURE, light[level].into_binding())?;
                entries.push(SCATTERED_TEXTURE, scattered_at(level + 2).into_binding())?;
                entries.push(COARSER_TEXTURE, light[level + 1].into_binding())?;
                entries.push(LEVEL_OUTPUT, scattered_at(level).into_binding())?;
                entries.push(NORMAL_TEXTURE, normal.into_binding())?;
                entries.push(ENTERING_TEXTURE, light[0].into_binding())
            });
        }
        picture.bind(&device, &layouts.picture, target, |binding, output| {
            Some(match binding {
                VIEW => uniforms.clone(),
                TILES => tiles(),
                LIGHT_TEXTURE => light[0].into_binding(),
                SCATTERED_TEXTURE => scattered_at(1).into_binding(),
                PICTURE_TEXTURE => subsurface.picture.view.into_binding(),
                OUTPUT_TEXTURE => output.into_binding(),
                _ => return None,
            })
        });
    }
}
