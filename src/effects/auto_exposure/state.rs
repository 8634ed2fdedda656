//! State of a camera across frames: its exposure and the cuts it has seen, on the GPU.

use bevy::{
    prelude::*,
    render::{
        render_resource::{Buffer, BufferDescriptor, BufferUsages, ShaderType},
        renderer::RenderDevice,
    },
};

use super::{
    clock::Clocks,
    settings::{LeanAutoExposure, MeteredExposure},
    uniforms::ExposureState,
};

/// On a view with auto exposure, even while its camera is off: its exposure.
#[derive(Component)]
pub struct ExposureHistory {
    /// An [`ExposureState`].
    pub(super) state: Buffer,
    /// Time of the view's last frame, which may have been long ago.
    pub(super) rendered: Clocks,
}

impl ExposureHistory {
    pub(super) fn bytes(&self) -> u64 {
        self.state.size()
    }
}

/// Creates missing histories.
pub(super) fn begin_histories(
    mut commands: Commands,
    device: Res<RenderDevice>,
    views: Query<Entity, (With<LeanAutoExposure>, Without<ExposureHistory>)>,
) {
    for entity in &views {
        commands.entity(entity).insert(ExposureHistory {
            // Zero-initialised: no frame has been seen yet.
            state: device.create_buffer(&BufferDescriptor {
                label: Some("lean_deferred/effects/auto_exposure/state"),
                size: ExposureState::min_size().get(),
                usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
            rendered: Clocks::default(),
        });
    }
}

/// Resets the readback, since nothing is metered without auto exposure.
pub(super) fn remove_state(removed: On<Remove, LeanAutoExposure>, mut commands: Commands) {
    commands
        .entity(removed.entity)
        .queue_silenced(|mut camera: EntityWorldMut| {
            if let Some(mut metered) = camera.get_mut::<MeteredExposure>() {
                metered.set_if_neq(MeteredExposure::default());
            }
        });
}
