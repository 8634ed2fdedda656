//! What a camera keeps from frame to frame: its exposure, on the GPU, and how many cuts it had.

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

/// On a view with auto exposure, also while it is off: its exposure.
#[derive(Component)]
pub struct ExposureHistory {
    /// An [`ExposureState`].
    pub(super) state: Buffer,
    /// When the view was rendered last: it may have paused.
    pub(super) rendered: Clocks,
}

/// Gives views their histories.
pub(super) fn begin_histories(
    mut commands: Commands,
    device: Res<RenderDevice>,
    views: Query<Entity, (With<LeanAutoExposure>, Without<ExposureHistory>)>,
) {
    for entity in &views {
        commands.entity(entity).insert(ExposureHistory {
            // Zeros: no frame has been seen yet.
            state: device.create_buffer(&BufferDescriptor {
                label: Some("lean_deferred/auto_exposure/state"),
                size: ExposureState::min_size().get(),
                usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
            rendered: Clocks::default(),
        });
    }
}

/// Without auto exposure nothing is metered.
pub(super) fn remove_state(removed: On<Remove, LeanAutoExposure>, mut commands: Commands) {
    commands
        .entity(removed.entity)
        .queue_silenced(|mut camera: EntityWorldMut| {
            if let Some(mut metered) = camera.get_mut::<MeteredExposure>() {
                metered.set_if_neq(MeteredExposure::default());
            }
        });
}
