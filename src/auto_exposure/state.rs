//! The exposure of a camera: on the GPU, read back, and reset at cuts.

use bevy::{
    prelude::*,
    render::{
        extract_component::ExtractComponent,
        gpu_readback::{Readback, ReadbackComplete},
        storage::ShaderBuffer,
    },
};

use super::{ExposureCut, LeanAutoExposure, MeteredExposure, uniforms::ExposureState};

/// On a camera with auto exposure: the buffer that keeps its state.
#[derive(Component, ExtractComponent, Clone, Debug)]
pub struct ExposureBuffer(pub(super) Handle<ShaderBuffer>);

/// On a camera with auto exposure: how many cuts it had. The shader remembers how many it has seen, so that none is
/// lost with a frame.
#[derive(Component, ExtractComponent, Clone, Copy, Debug, Default)]
pub struct ExposureCuts(pub(super) u32);

/// What reads the state of `camera` back.
#[derive(Component)]
#[relationship(relationship_target = ExposureReaders)]
pub(super) struct ExposureReader(Entity);

/// Despawned with the camera, or with its auto exposure.
#[derive(Component)]
#[relationship_target(relationship = ExposureReader, linked_spawn)]
pub(super) struct ExposureReaders(Vec<Entity>);

pub(super) fn add_state(
    added: On<Add, LeanAutoExposure>,
    mut commands: Commands,
    mut buffers: ResMut<Assets<ShaderBuffer>>,
) {
    let camera = added.entity;
    let buffer = buffers.add(ShaderBuffer::from(ExposureState::default()));
    commands
        .entity(camera)
        .insert((ExposureBuffer(buffer.clone()), ExposureCuts::default()));
    commands
        .spawn((Readback::buffer(buffer), ExposureReader(camera)))
        .observe(keep_metered);
}

pub(super) fn remove_state(removed: On<Remove, LeanAutoExposure>, mut commands: Commands) {
    commands
        .entity(removed.entity)
        .queue_silenced(|mut camera: EntityWorldMut| {
            camera.despawn_related::<ExposureReaders>();
            camera.remove::<(ExposureBuffer, ExposureCuts, MeteredExposure)>();
        });
}

fn keep_metered(
    complete: On<ReadbackComplete>,
    readers: Query<&ExposureReader>,
    mut cameras: Query<&mut MeteredExposure>,
) {
    let Ok(reader) = readers.get(complete.entity) else {
        return;
    };
    let state: ExposureState = complete.to_shader_type();
    // Before its first frame it says nothing.
    if let Ok(mut metered) = cameras.get_mut(reader.0)
        && state.cuts_seen > 0
    {
        metered.set_if_neq(MeteredExposure {
            luminance: state.luminance,
            exposure: state.exposure,
            target_exposure: state.target_exposure,
        });
    }
}

/// Counts the cuts of this frame.
pub(super) fn count_cuts(
    mut commands: Commands,
    mut cameras: Query<(Entity, Option<&mut ExposureCuts>), With<ExposureCut>>,
) {
    for (camera, cuts) in &mut cameras {
        if let Some(mut cuts) = cuts {
            cuts.0 = cuts.0.wrapping_add(1) & 0x7fff_ffff;
        }
        commands.entity(camera).remove::<ExposureCut>();
    }
}
