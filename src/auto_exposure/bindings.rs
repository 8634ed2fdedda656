//! The bind groups, made anew only when what they bind changed.

use bevy::{
    prelude::*,
    render::{
        render_asset::RenderAssets,
        render_resource::{
            BindGroup, BindGroupEntry, BindingResource, IntoBinding, PipelineCache, TextureViewId,
        },
        renderer::RenderDevice,
        storage::GpuShaderBuffer,
        texture::GpuImage,
        view::{ViewTarget, ViewUniforms},
    },
};

use super::{
    LeanAutoExposure, MeteringPattern,
    pipelines::{ViewExposurePipelines, adapt_layout, meter_layout},
    state::ExposureBuffer,
    uniforms::{ExposureUniforms, ViewExposure},
};
use crate::bind_group_cache::CachedBindGroup;

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
    (device, cache): (Res<RenderDevice>, Res<PipelineCache>),
    (uniforms, view_uniforms): (Res<ExposureUniforms>, Res<ViewUniforms>),
    (buffers, images): (
        Res<RenderAssets<GpuShaderBuffer>>,
        Res<RenderAssets<GpuImage>>,
    ),
    mut views: Query<(
        Entity,
        &LeanAutoExposure,
        &ViewExposure,
        &ViewExposurePipelines,
        &ExposureBuffer,
        &ViewTarget,
        Option<&mut ExposureBindings>,
    )>,
) {
    let (Some(uniforms), Some(view_uniforms)) =
        (uniforms.0.binding(), view_uniforms.uniforms.binding())
    else {
        return;
    };
    for (entity, settings, view, pipelines, state, target, bindings) in &mut views {
        let Some(state) = buffers.get(&state.0) else {
            continue;
        };
        let mut new = None;
        let bindings = match bindings {
            Some(bindings) => bindings.into_inner(),
            None => new.insert(ExposureBindings::default()),
        };
        let key = pipelines.key;
        let mask = match &settings.pattern {
            MeteringPattern::Mask(mask) if key.has_mask() => images.get(mask),
            _ => None,
        };
        // The pipelines for new settings are still compiling: the last groups go on.
        if mask.is_some() != key.has_mask() {
            continue;
        }
        let sums = || view.sums.as_entire_binding();

        let pictures = [target.main_texture_view(), target.main_texture_other_view()];
        if bindings.meter[0].0 == Some(pictures[1].id()) {
            bindings.meter.swap(0, 1);
        }
        for (slot, picture) in bindings.meter.iter_mut().zip(pictures) {
            let mut entries = vec![uniforms.clone(), picture.into_binding(), sums()];
            if let Some(mask) = mask {
                entries.push(mask.texture_view.into_binding());
                entries.push(mask.sampler.into_binding());
            }
            slot.0 = Some(picture.id());
            slot.1
                .update(&device, &cache, &meter_layout(key), &numbered(entries));
        }

        let entries = vec![
            uniforms.clone(),
            view_uniforms.clone(),
            sums(),
            state.buffer.as_entire_binding(),
        ];
        bindings
            .adapt
            .update(&device, &cache, &adapt_layout(), &numbered(entries));
        if let Some(new) = new {
            commands.entity(entity).insert(new);
        }
    }
}

pub(super) fn numbered(resources: Vec<BindingResource>) -> Vec<BindGroupEntry> {
    resources
        .into_iter()
        .zip(0..)
        .map(|(resource, binding)| BindGroupEntry { binding, resource })
        .collect()
}
