//! The bind groups, made anew only when what they bind changed.

use bevy::{
    ecs::system::SystemParam,
    prelude::*,
    render::{
        render_asset::RenderAssets,
        render_resource::{BindGroup, IntoBinding, TextureViewId},
        renderer::RenderDevice,
        texture::{FallbackImage, GpuImage},
        view::{ViewTarget, ViewUniforms},
    },
};

use super::{
    pipelines::{ExposurePipelines, ViewExposurePipelines},
    state::ExposureHistory,
    uniforms::{ExposureUniforms, ViewExposure},
};
use crate::gpu::bind_group_cache::{CachedBindGroup, Entries};

/// On a view with auto exposure: the bind groups of its passes.
#[derive(Component, Default)]
pub struct ExposureBindings {
    /// Post-processing swaps the two main textures: there is a group for each.
    pub(super) meter: [(Option<TextureViewId>, CachedBindGroup); 2],
    pub(super) adapt: CachedBindGroup,
}

impl ExposureBindings {
    /// Those that stay from frame to frame as long as nothing changes.
    pub fn lasting_bind_groups(&self) -> impl Iterator<Item = &BindGroup> {
        let meter = self.meter.iter().map(|(_, group)| group);
        meter.chain([&self.adapt]).filter_map(CachedBindGroup::get)
    }
}

/// Makes the bind groups of all views with auto exposure.
pub(super) fn prepare_exposure_bind_groups(
    mut commands: Commands,
    device: Res<RenderDevice>,
    pipelines: Option<Res<ExposurePipelines>>,
    (uniforms, view_uniforms): (Res<ExposureUniforms>, Res<ViewUniforms>),
    masks: Masks,
    mut views: Query<(
        Entity,
        &ViewExposure,
        &ViewExposurePipelines,
        &ExposureHistory,
        &ViewTarget,
        Option<&mut ExposureBindings>,
    )>,
) {
    let (Some(pipelines), Some(uniforms), Some(view_uniforms)) = (
        pipelines,
        uniforms.0.binding(),
        view_uniforms.uniforms.binding(),
    ) else {
        return;
    };
    for (entity, view, own_pipelines, history, target, bindings) in &mut views {
        let mut new = None;
        let bindings = match bindings {
            Some(bindings) => bindings.into_inner(),
            None => new.insert(ExposureBindings::default()),
        };
        let pictures = [target.main_texture_view(), target.main_texture_other_view()];
        if bindings.meter[0].0 == Some(pictures[1].id()) {
            bindings.meter.swap(0, 1);
        }
        let Some(layout) = pipelines.meter_layout(own_pipelines.key) else {
            continue;
        };
        for (slot, picture) in bindings.meter.iter_mut().zip(pictures) {
            slot.0 = Some(picture.id());
            slot.1.update(&device, layout, |entries| {
                entries.push(0, uniforms.clone())?;
                entries.push(1, picture.into_binding())?;
                entries.push(2, view.sums.as_entire_binding())?;
                masks.push(3, own_pipelines, entries)
            });
        }
        bindings
            .adapt
            .update(&device, &pipelines.adapt_layout, |entries| {
                entries.push(0, uniforms.clone())?;
                entries.push(1, view_uniforms.clone())?;
                entries.push(2, view.sums.as_entire_binding())?;
                entries.push(3, history.state.as_entire_binding())
            });
        if let Some(new) = new {
            commands.entity(entity).insert(new);
        }
    }
}

/// The images that cameras are metered by.
#[derive(SystemParam)]
pub(super) struct Masks<'w> {
    images: Res<'w, RenderAssets<GpuImage>>,
    fallback: Res<'w, FallbackImage>,
}

impl Masks<'_> {
    /// The mask of `pipelines` and its sampler at `binding` and the next, if there is one. All pixels count if it has
    /// been unloaded.
    pub(super) fn push(
        &self,
        binding: u32,
        pipelines: &ViewExposurePipelines,
        entries: &mut Entries,
    ) -> Option<()> {
        let Some(mask) = &pipelines.mask else {
            return Some(());
        };
        let image = self.images.get(mask).unwrap_or(&self.fallback.d2);
        entries.push(binding, image.texture_view.into_binding())?;
        entries.push(binding + 1, image.sampler.into_binding())
    }
}
