//! What the passes need of a view: uniforms, the light that has scattered, and bind groups, which are made anew only when what
//! they bind changed.

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
        COARSER_TEXTURE, ENTERING_TEXTURE, LEVEL_OUTPUT, LIGHT_TEXTURE, NEXT_OUTPUT,
        NORMAL_TEXTURE, OUTPUT_TEXTURE, PICTURE_TEXTURE, SCATTERED_TEXTURE, TILES, VIEW,
    },
    pipelines::SubsurfacePipelines,
    uniforms::SubsurfaceView,
};
use crate::{
    gbuffer::GBufferTextures,
    gpu::{
        bind_group_cache::CachedBindGroup, picture_bind_groups::PictureBindGroups,
        storage_texture::StorageTexture,
    },
    lighting::{SUBSURFACE_LEVELS, SUBSURFACE_LIGHT_FORMAT, SubsurfaceLight},
    screen_space::LastFrame,
    view::{ActiveLeanView, OutOfMemory},
};

/// The coarsest level of the light: what scatters there is its mean.
const LABEL: &str = "lean_deferred/screen_space/subsurface/scattered";
const COARSEST: usize = SUBSURFACE_LEVELS - 1;
/// The finer ones of the two levels that each pass down writes, and the level that each pass up writes.
pub(super) const DOWN: [usize; 3] = [2, 4, 6];
pub(super) const UP: [usize; 3] = [5, 3, 1];

/// The uniforms of all views, one for each level.
#[derive(Resource, Default)]
pub(super) struct SubsurfaceUniforms(DynamicUniformBuffer<SubsurfaceView>);

/// On a view whose light scatters.
#[derive(Component)]
pub struct ViewSubsurface {
    /// Light that has scattered, from level 1 on; of every other level.
    scattered: StorageTexture<{ COARSEST - 2 }>,
    pub(super) size: UVec2,
    /// Of each level.
    pub(super) offsets: [u32; SUBSURFACE_LEVELS],
    pub(super) first: CachedBindGroup,
    pub(super) down: [CachedBindGroup; DOWN.len()],
    pub(super) up: [CachedBindGroup; UP.len()],
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
            up: default(),
            picture: default(),
        }
    }

    /// Those that stay from frame to frame as long as nothing changes.
    pub fn lasting_bind_groups(&self) -> impl Iterator<Item = &BindGroup> {
        let groups = [&self.first].into_iter();
        let groups = groups.chain(&self.down).chain(&self.up);
        self.picture
            .all()
            .chain(groups.filter_map(CachedBindGroup::get))
    }

    /// What it holds on the GPU beside [`SubsurfaceLight`].
    pub fn texture(&self) -> &Texture {
        &self.scattered.texture
    }
}

/// Inserts or removes [`ViewSubsurface`], and writes [`SubsurfaceUniforms`]. After [`SubsurfaceLight`] was made.
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
    let count = views.iter().len() * SUBSURFACE_LEVELS;
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
        let now = LastFrame::of(view, resolution, camera.exposure);
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
        held.offsets = core::array::from_fn(|level| {
            let settings = &active.settings;
            writer.write(&SubsurfaceView::new(settings, &now, level as u32))
        });
        if let Some(made) = made {
            commands.entity(entity).insert(made);
        }
    }
}

/// Makes the bind groups of all views whose light scatters.
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
            up,
            picture,
            ..
        } = &mut *held;
        let scattered = &*scattered;
        let light = &subsurface.light.levels;
        // By level: the coarsest one's is what enters there.
        let scattered_at = |level: usize| match level {
            COARSEST => &light[COARSEST],
            _ => &scattered.levels[level - 1],
        };
        let tiles = || subsurface.tiles.as_entire_binding();
        let normal = &gbuffer.normal.default_view;
        first.update(&device, &layouts.first, |entries| {
            entries.push(VIEW, uniforms.clone())?;
            entries.push(TILES, tiles())?;
            entries.push(LIGHT_TEXTURE, light[0].into_binding())?;
            entries.push(LEVEL_OUTPUT, light[1].into_binding())
        });
        for (level, group) in DOWN.into_iter().zip(down) {
            group.update(&device, &layouts.down, |entries| {
                entries.push(VIEW, uniforms.clone())?;
                entries.push(TILES, tiles())?;
                entries.push(LIGHT_TEXTURE, light[level - 1].into_binding())?;
                entries.push(LEVEL_OUTPUT, light[level].into_binding())?;
                entries.push(NEXT_OUTPUT, light[level + 1].into_binding())
            });
        }
        for (level, group) in UP.into_iter().zip(up) {
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
        picture.update(&device, &layouts.picture, target, |entries, output| {
            entries.push(VIEW, uniforms.clone())?;
            entries.push(TILES, tiles())?;
            entries.push(LIGHT_TEXTURE, light[0].into_binding())?;
            entries.push(SCATTERED_TEXTURE, scattered_at(1).into_binding())?;
            entries.push(NORMAL_TEXTURE, normal.into_binding())?;
            entries.push(PICTURE_TEXTURE, subsurface.picture.view.into_binding())?;
            entries.push(OUTPUT_TEXTURE, output.into_binding())
        });
    }
}
