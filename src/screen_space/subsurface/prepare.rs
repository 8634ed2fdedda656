//! What the passes need of a view: its uniform, a texture, and bind groups, which are made anew only when what they bind
//! changed.

use bevy::{
    camera::MainPassResolutionOverride,
    diagnostic::FrameCount,
    prelude::*,
    render::{
        camera::{ExtractedCamera, TemporalJitter},
        render_resource::{BindGroup, DynamicUniformBuffer, IntoBinding, Texture},
        renderer::{RenderDevice, RenderQueue},
        view::{ExtractedView, ViewDepthTexture, ViewTarget},
    },
};

use super::{
    active::ActiveScattering,
    binding_numbers::{
        ACROSS_OUTPUT, ACROSS_TEXTURE, DEPTH_TEXTURE, LEVEL_0, LIGHT_TEXTURE, OUTPUT_TEXTURE,
        PICTURE_TEXTURE, TILES, VIEW,
    },
    key::Method,
    pipelines::{ACROSS_FORMAT, SubsurfacePipelines},
    uniforms::SubsurfaceView,
};
use crate::{
    gpu::{
        bind_group_cache::{CachedBindGroup, Entries},
        picture_bind_groups::PictureBindGroups,
        storage_texture::StorageTexture,
    },
    lighting::{SubsurfaceLight, ViewLighting},
    screen_space::{LastFrame, pattern::turn_of},
    view::{ActiveLeanView, LightExchange},
};

/// The uniforms of all views.
#[derive(Resource, Default)]
pub(super) struct SubsurfaceUniforms(DynamicUniformBuffer<SubsurfaceView>);

/// On a view whose light scatters.
#[derive(Component, Default)]
pub struct ViewSubsurface {
    /// Of the separable method: light that has scattered along rows.
    across: Option<StorageTexture>,
    pub(super) first: CachedBindGroup,
    pub(super) second: PictureBindGroups,
    pub(super) clear: CachedBindGroup,
    pub(super) offset: u32,
}

impl ViewSubsurface {
    /// Those that stay from frame to frame as long as nothing changes.
    pub fn lasting_bind_groups(&self) -> impl Iterator<Item = &BindGroup> {
        let others = [&self.first, &self.clear];
        let others = others.into_iter().filter_map(CachedBindGroup::get);
        self.second.all().chain(others)
    }

    /// What it holds on the GPU beside [`SubsurfaceLight`].
    pub fn textures(&self) -> impl Iterator<Item = &Texture> {
        self.across.iter().map(|across| &across.texture)
    }
}

/// Inserts or removes [`ViewSubsurface`], and writes [`SubsurfaceUniforms`].
pub(super) fn prepare_subsurface(
    mut commands: Commands,
    mut uniforms: ResMut<SubsurfaceUniforms>,
    (device, queue, frame): (Res<RenderDevice>, Res<RenderQueue>, Res<FrameCount>),
    mut views: Query<(
        Entity,
        (&ActiveScattering, &ActiveLeanView),
        (&ExtractedCamera, &ExtractedView),
        Option<&MainPassResolutionOverride>,
        Has<TemporalJitter>,
        Option<&mut ViewSubsurface>,
    )>,
) {
    let Some(mut writer) = (uniforms.0).get_writer(views.iter().len(), &device, &queue) else {
        return;
    };
    for (entity, (active, lean), (camera, view), resolution, jitters, held) in &mut views {
        let scatters = lean.exchange.contains(LightExchange::SUBSURFACE_LIGHT);
        if !scatters || !lean.variants.scatter() {
            if held.is_some() {
                commands.entity(entity).remove::<ViewSubsurface>();
            }
            continue;
        }
        let now = LastFrame::of(view, resolution, camera.exposure);
        let mut uniform = SubsurfaceView::new(&active.settings, now.clip_from_view, now.viewport);
        uniform.turn = turn_of(&frame, jitters);
        let mut made = None;
        let held = match held {
            Some(held) => held.into_inner(),
            None => made.insert(ViewSubsurface::default()),
        };
        held.offset = writer.write(&uniform);
        if active.key.method != Method::Separable {
            held.across = None;
        } else if !(held.across.as_ref()).is_some_and(|across| {
            UVec2::new(across.texture.width(), across.texture.height()) == uniform.viewport_size
        }) {
            let label = "lean_deferred/subsurface/across";
            let size = uniform.viewport_size;
            held.across = Some(StorageTexture::new(&device, label, size, ACROSS_FORMAT));
        }
        if let Some(made) = made {
            commands.entity(entity).insert(made);
        }
    }
}

/// Makes the bind groups of all views whose light scatters: after lighting has its list of tiles.
pub(super) fn prepare_subsurface_bind_groups(
    device: Res<RenderDevice>,
    pipelines: Option<Res<SubsurfacePipelines>>,
    uniforms: Res<SubsurfaceUniforms>,
    mut views: Query<(
        &mut ViewSubsurface,
        &ActiveScattering,
        (&ViewLighting, &SubsurfaceLight),
        (&ViewDepthTexture, &ViewTarget),
    )>,
) {
    let (Some(pipelines), Some(uniforms)) = (pipelines, uniforms.0.binding()) else {
        return;
    };
    for (mut held, active, (lighting, subsurface), (depth, target)) in &mut views {
        let ViewSubsurface {
            across,
            first,
            second,
            clear,
            ..
        } = &mut *held;
        let (Some(layouts), Some((_, list))) =
            (pipelines.layouts_of(active.key), lighting.special_tiles())
        else {
            *first = default();
            continue;
        };
        let (light, across) = (&subsurface.light, across.as_ref());
        let push_always = |entries: &mut Entries| {
            entries.push(VIEW, uniforms.clone())?;
            entries.push(TILES, list.as_entire_binding())
        };
        let push_levels = |entries: &mut Entries, first: usize| {
            for (number, level) in (LEVEL_0..).zip(&light.levels).skip(first) {
                entries.push(number, level.into_binding())?;
            }
            Some(())
        };
        let push_surfaces = |entries: &mut Entries| {
            push_always(entries)?;
            entries.push(LIGHT_TEXTURE, light.view.into_binding())?;
            entries.push(PICTURE_TEXTURE, subsurface.picture.view.into_binding())?;
            entries.push(DEPTH_TEXTURE, depth.view().into_binding())
        };
        first.update(&device, &layouts.first, |entries| match across {
            Some(across) => {
                push_surfaces(entries)?;
                entries.push(ACROSS_OUTPUT, across.view.into_binding())
            }
            None => {
                push_always(entries)?;
                // Others of the texture are written.
                entries.push(LIGHT_TEXTURE, light.levels[0].into_binding())?;
                push_levels(entries, 1)
            }
        });
        second.update(&device, &layouts.second, target, |entries, picture| {
            push_surfaces(entries)?;
            if let Some(across) = across {
                entries.push(ACROSS_TEXTURE, across.view.into_binding())?;
            }
            entries.push(OUTPUT_TEXTURE, picture.into_binding())
        });
        clear.update(&device, &layouts.clear, |entries| {
            push_always(entries)?;
            push_levels(entries, 0)
        });
    }
}
