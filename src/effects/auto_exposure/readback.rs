//! Readback of the exposure for cameras with [`MeteredExposure`]: copied after adaptation and mapped asynchronously, so that nothing
//! waits for the GPU.
//!
//! Bevy's `Readback` is not used, since it panics on device loss.

use std::sync::{Arc, Mutex};

use bevy::{
    prelude::*,
    render::{
        MainWorld,
        render_resource::{
            Buffer, BufferDescriptor, BufferUsages, CommandEncoder, MapMode, ShaderType,
            encase::StorageBuffer,
        },
        renderer::RenderDevice,
        sync_world::MainEntity,
    },
};

use super::{
    prepare::ViewExposure, settings::MeteredExposure, state::ExposureHistory,
    uniforms::ExposureState,
};

/// Frames in flight. Frames are not read back while no slot is free.
const SLOTS: usize = 4;

/// On a view whose exposure is read back.
#[derive(Component)]
pub struct ExposureReadback {
    slots: [Slot; SLOTS],
    /// Number of frames copied so far.
    frames: Mutex<u64>,
}

struct Slot {
    buffer: Buffer,
    progress: Arc<Mutex<Progress>>,
}

/// State of a slot, with the number of its frame.
#[derive(Clone, Copy, Default)]
enum Progress {
    #[default]
    Free,
    Copied(u64),
    /// Waiting for the GPU, or abandoned after device loss.
    Mapping,
    Read(u64, ExposureState),
}

impl Slot {
    fn progress(&self) -> Progress {
        *lock(&self.progress)
    }

    fn set(&self, progress: Progress) {
        *lock(&self.progress) = progress;
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}

impl ExposureReadback {
    fn new(device: &RenderDevice) -> Self {
        let slot = |_| Slot {
            buffer: device.create_buffer(&BufferDescriptor {
                label: Some("lean_deferred/effects/auto_exposure/readback"),
                size: ExposureState::min_size().get(),
                usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
                mapped_at_creation: false,
            }),
            progress: Arc::default(),
        };
        Self {
            slots: core::array::from_fn(slot),
            frames: Mutex::new(0),
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        self.slots.iter().map(|slot| slot.buffer.size()).sum()
    }

    /// Copies this frame's `state` if a slot is free.
    pub(super) fn copy(&self, state: &Buffer, encoder: &mut CommandEncoder) {
        let is_free = |slot: &&Slot| matches!(slot.progress(), Progress::Free);
        let Some(slot) = self.slots.iter().find(is_free) else {
            return;
        };
        encoder.copy_buffer_to_buffer(state, 0, &slot.buffer, 0, slot.buffer.size());
        let mut frames = lock(&self.frames);
        *frames += 1;
        slot.set(Progress::Copied(*frames));
    }

    /// The newest state that has arrived since the last call.
    fn latest(&self) -> Option<ExposureState> {
        let read = self.slots.iter().filter_map(|slot| match slot.progress() {
            Progress::Read(frame, state) => {
                slot.set(Progress::Free);
                Some((frame, state))
            }
            _ => None,
        });
        let (_, state) = read.max_by_key(|(frame, _)| *frame)?;
        Some(state)
    }
}

/// Creates readbacks for views with [`MeteredExposure`].
pub(super) fn prepare_readbacks(
    mut commands: Commands,
    device: Res<RenderDevice>,
    new: Query<
        Entity,
        (
            With<MeteredExposure>,
            With<ViewExposure>,
            Without<ExposureReadback>,
        ),
    >,
) {
    for entity in &new {
        commands
            .entity(entity)
            .insert(ExposureReadback::new(&device));
    }
}

/// Maps the slots that were copied this frame. Runs after the frame is submitted.
pub(super) fn map_readbacks(views: Query<&ExposureReadback>) {
    for slot in views.iter().flat_map(|readback| &readback.slots) {
        let Progress::Copied(frame) = slot.progress() else {
            continue;
        };
        slot.set(Progress::Mapping);
        let (buffer, progress) = (slot.buffer.clone(), slot.progress.clone());
        slot.buffer
            .slice(..)
            .map_async(MapMode::Read, move |result| {
                if result.is_err() {
                    return;
                }
                let bytes = StorageBuffer::new(buffer.slice(..).get_mapped_range().to_vec());
                buffer.unmap();
                *lock(&progress) = match bytes.create::<ExposureState>() {
                    // 0 before the first metered frame.
                    Ok(state) if state.cuts_seen > 0 => Progress::Read(frame, state),
                    _ => Progress::Free,
                };
            });
    }
}

/// Writes the states that have arrived to the cameras in the main world.
pub(super) fn report_metered(
    mut main_world: ResMut<MainWorld>,
    views: Query<(&MainEntity, &ExposureReadback), With<ExposureHistory>>,
) {
    for (camera, readback) in &views {
        if let Some(state) = readback.latest()
            && let Some(mut metered) = main_world.get_mut::<MeteredExposure>(camera.id())
        {
            metered.set_if_neq(MeteredExposure {
                luminance: state.luminance,
                exposure: state.exposure,
                target_exposure: state.target_exposure,
            });
        }
    }
}
