//! Per-view resources of the passes: uniform, buffers and bind groups. Bind groups are recreated only when their resources change.

use bevy::{
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{
            BindGroup, Buffer, BufferDescriptor, BufferUsages, DynamicUniformBuffer, IntoBinding,
            Texture,
        },
        renderer::{RenderDevice, RenderQueue},
        view::{ViewTarget, ViewUniforms},
    },
};

use super::{
    active::ActiveExposure,
    binding_numbers::{BEVY_VIEW, MASK, MASK_SAMPLER, PARTIALS, PICTURE, STATE, VIEW},
    clock::Clocks,
    key::{ExposureKey, workgroups},
    masks::Masks,
    pipelines::{ExposurePipelines, PASSES},
    settings::LeanAutoExposure,
    state::ExposureHistory,
    uniforms::ExposureUniform,
};
use crate::{
    gpu::{bind_group_cache::CachedBindGroup, picture_bind_groups::PictureBindGroups},
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
        &ActiveExposure,
        &ViewTarget,
        &mut ExposureHistory,
        Option<&mut ViewExposure>,
    )>,
) {
    let Some(mut writer) = uniforms.0.get_writer(views.iter().len(), &device, &queue) else {
        return;
    };
    for (entity, settings, camera, cuts, active, target, mut history, view) in &mut views {
        let key = active.key;
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
    meter: PictureBindGroups,
    adapt: CachedBindGroup,
}

impl ExposureBindings {
    /// Bind groups of the passes, of which the first reads `picture`.
    pub(super) fn groups(&self, picture: &Texture) -> [Option<&BindGroup>; PASSES.len()] {
        [self.meter.of(picture), self.adapt.get()]
    }

    /// Bind groups that are reused across frames while nothing changes.
    pub fn lasting_bind_groups(&self) -> impl Iterator<Item = &BindGroup> {
        self.meter.all().chain(self.adapt.get())
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
        &ActiveExposure,
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
    for (entity, view, active, history, target, bindings) in &mut views {
        let mut new = None;
        let bindings = match bindings {
            Some(bindings) => bindings.into_inner(),
            None => new.insert(ExposureBindings::default()),
        };
        let [meter, adapt] = pipelines.layouts() else {
            continue;
        };
        let mask = masks.bound(active.mask.as_ref());
        let resource = |binding: u32| {
            Some(match binding {
                VIEW => uniforms.clone(),
                PARTIALS => view.sums.as_entire_binding(),
                MASK => mask.texture_view.into_binding(),
                MASK_SAMPLER => mask.sampler.into_binding(),
                STATE => history.state.as_entire_binding(),
                BEVY_VIEW => view_uniforms.clone(),
                _ => return None,
            })
        };
        (bindings.meter).bind(&device, meter, target, |binding, picture| match binding {
            PICTURE => Some(picture.into_binding()),
            _ => resource(binding),
        });
        bindings.adapt.bind(&device, adapt, resource);
        if let Some(new) = new {
            commands.entity(entity).insert(new);
        }
    }
}
