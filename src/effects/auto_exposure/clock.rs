//! Clocks that exposure can adapt by.

use bevy::{prelude::*, render::Extract, time::Real};

use super::settings::ExposureClock;

/// Seconds since the start of the app, by each clock.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(super) struct Clocks {
    real: f64,
    virtual_time: f64,
}

impl Clocks {
    /// Seconds since `last`, by one of the clocks.
    pub(super) fn seconds_since(&self, last: &Self, clock: ExposureClock) -> f32 {
        let seconds = match clock {
            ExposureClock::Real => self.real - last.real,
            ExposureClock::Virtual => self.virtual_time - last.virtual_time,
        };
        seconds as f32
    }
}

pub(super) fn extract_clocks(
    mut clocks: ResMut<Clocks>,
    real: Extract<Option<Res<Time<Real>>>>,
    virtual_time: Extract<Option<Res<Time>>>,
) {
    if let Some(time) = &*real {
        clocks.real = time.elapsed_secs_f64();
    }
    if let Some(time) = &*virtual_time {
        clocks.virtual_time = time.elapsed_secs_f64();
    }
}
