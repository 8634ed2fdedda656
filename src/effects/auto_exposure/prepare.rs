//! Per-view resources of the passes: uniform, buffers and bind groups. Bind groups are recreated only when their resources change.

use bevy::{
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_asset::RenderAssets,
        render_resource::{
            BindGroup, Buffer, BufferDescriptor, BufferUsages, DynamicUniformBuffer, IntoBinding,
            TextureDimension, TextureSampleType, TextureViewDimension, TextureViewId,
        },
        renderer::{RenderDevice, RenderQueue},
        texture::{FallbackImage, GpuImage},
        view::{ViewTarget, ViewUniforms},
    },
};

use super::{
    active::ViewExposurePipelines,
    binding_numbers::{BEVY_VIEW, MASK, MASK_SAMPLER, PARTIALS, PICTURE, STATE, VIEW},
    clock::Clocks,
    key::{ExposureKey, workgroups},
    pipelines::ExposurePipelines,
    settings::LeanAutoExposure,
    state::ExposureHistory,
    uniforms::ExposureUniform,
};
use crate::{
    gpu::{
        bind_group_cache::{CachedBindGroup, Entries},
        named::system_param,
    },
    view::CameraCuts,
};

/// Uniforms of all views.
#[derive(Resource, Default)]
pub(super) struct ExposureUniforms(pub(super) DynamicUniformBuffer<ExposureUniform>);

/// On a view with auto exposure: the offset of its uniform, and the buffer between the passes.
#[derive(Component)]
pub struct ViewExposure {
    pub(super) offset: u32,
    pub(super) workgroups: UVec2,
    /// Output of the first pass: partial sums, or the histogram.
    pub(super) sums: Buffer,
    is_histogram: bool,
}

impl ViewExposure {
    fn new(device: &RenderDevice, key: ExposureKey, viewport_size: UVec2) -> Self {
        Self {
            offset: 0,
            workgroups: UVec2::ZERO,
            sums: device.create_buffer(&BufferDescriptor {
                label: Some("lean_deferred/effects/auto_exposure/sums"),
                size: key.sums_size(viewport_size),
                usage: BufferUsages::STORAGE,
                mapped_at_creation: false,
            }),
            is_histogram: key.has_histogram(),
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        self.sums.size()
    }

    /// True if the buffer has the layout that the shaders of `key` expect.
    fn fits(&self, key: ExposureKey, viewport_size: UVec2) -> bool {
        self.sums.size() == key.sums_size(viewport_size) && self.is_histogram == key.has_histogram()
    }
}

/// Fills [`ExposureUniforms`], and creates buffers where none fits.
pub(super) fn write_exposure_uniforms(
    mut commands: Commands,
    mut uniforms: ResMut<ExposureUniforms>,
    (device, queue, now): (Res<RenderDevice>, Res<RenderQueue>, Res<Clocks>),
    mut views: Query<(
        Entity,
        &LeanAutoExposure,
        &ExtractedCamera,
        &CameraCuts,
        &ViewExposurePipelines,
        &ViewTarget,
        &mut ExposureHistory,
        Option<&mut ViewExposure>,
    )>,
) {
    let Some(mut writer) = uniforms.0.get_writer(views.iter().len(), &device, &queue) else {
        return;
    };
    for (entity, settings, camera, cuts, pipelines, target, mut history, view) in &mut views {
        let key = pipelines.key;
        let (origin, size) = match &camera.viewport {
            Some(viewport) => (viewport.physical_position, viewport.physical_size),
            None => {
                // The camera's own target size may lag behind a target that is resized or replaced.
                let picture = target.main_texture();
                (UVec2::ZERO, UVec2::new(picture.width(), picture.height()))
            }
        };
        // Viewports may be empty.
        let size = size.max(UVec2::ONE);
        let mut new = None;
        let view = match view {
            Some(view) => view.into_inner(),
            None => new.insert(ViewExposure::new(&device, key, size)),
        };
        if !view.fits(key, size) {
            *view = ViewExposure::new(&device, key, size);
        }
        let seconds = now.seconds_since(&history.rendered, settings.clock);
        history.rendered = *now;
        view.offset = writer.write(&ExposureUniform::new(
            settings, origin, size, seconds, cuts.0,
        ));
        view.workgroups = workgroups(size);
        if let Some(new) = new {
            commands.entity(entity).insert(new);
        }
    }
}

/// On a view with auto exposure: the bind groups of its passes.
#[derive(Component, Default)]
pub struct ExposureBindings {
    /// One per main texture, since post-processing swaps the two.
    pub(super) meter: [(Option<TextureViewId>, CachedBindGroup); 2],
    pub(super) adapt: CachedBindGroup,
}

impl ExposureBindings {
    /// Bind groups that are reused across frames while nothing changes.
    pub fn lasting_bind_groups(&self) -> impl Iterator<Item = &BindGroup> {
        let meter = self.meter.iter().map(|(_, group)| group);
        meter.chain([&self.adapt]).filter_map(CachedBindGroup::get)
    }
}

/// Updates the bind groups of all views with auto exposure.
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
                entries.push(VIEW, uniforms.clone())?;
                entries.push(PICTURE, picture.into_binding())?;
                entries.push(PARTIALS, view.sums.as_entire_binding())?;
                masks.push(own_pipelines, entries)
            });
        }
        bindings
            .adapt
            .update(&device, &pipelines.adapt_layout, |entries| {
                entries.push(VIEW, uniforms.clone())?;
                entries.push(PARTIALS, view.sums.as_entire_binding())?;
                entries.push(STATE, history.state.as_entire_binding())?;
                entries.push(BEVY_VIEW, view_uniforms.clone())
            });
        if let Some(new) = new {
            commands.entity(entity).insert(new);
        }
    }
}

system_param! {
    /// Images of the metering masks.
    pub(super) struct Masks<'w> {
        device: Res<'w, RenderDevice>,
        images: Res<'w, RenderAssets<GpuImage>>,
        fallback: Res<'w, FallbackImage>,
    }
}

impl Masks<'_> {
    /// The mask's image; `None` while it is loading. The error is the reason that the image cannot be a mask.
    pub(super) fn get(&self, mask: &Handle<Image>) -> Result<Option<&GpuImage>, &'static str> {
        let Some(image) = self.images.get(mask) else {
            return Ok(None);
        };
        let texture = &image.texture_descriptor;
        let viewed = image.texture_view_descriptor.as_ref();
        let is_picture = texture.dimension == TextureDimension::D2
            && texture.size.depth_or_array_layers == 1
            && texture.sample_count == 1
            && matches!(
                viewed.and_then(|view| view.dimension),
                None | Some(TextureViewDimension::D2)
            );
        let aspect = viewed.map(|view| view.aspect);
        let kind = (texture.format).sample_type(aspect, Some(self.device.features()));
        if !is_picture {
            Err("it is no plain picture: use an image with one layer and one sample")
        } else if kind != Some(TextureSampleType::Float { filterable: true }) {
            Err("this device cannot filter its format: use another one, such as R8Unorm")
        } else {
            Ok(Some(image))
        }
    }

    /// Binds the mask of `pipelines` and its sampler, if it has one. If the mask was unloaded or replaced by an unsuitable image, all
    /// pixels count.
    pub(super) fn push(
        &self,
        pipelines: &ViewExposurePipelines,
        entries: &mut Entries,
    ) -> Option<()> {
        let Some(mask) = &pipelines.mask else {
            return Some(());
        };
        let found = self.get(mask).ok().flatten();
        let image = found.unwrap_or(&self.fallback.d2);
        entries.push(MASK, image.texture_view.into_binding())?;
        entries.push(MASK_SAMPLER, image.sampler.into_binding())
    }
}
