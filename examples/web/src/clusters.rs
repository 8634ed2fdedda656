//! Capacity for the lights of the scene in Bevy's lists.

use bevy::{light::cluster::GlobalClusterSettings, prelude::*};

/// Reserves it up front: when Bevy grows the lists at run time, they hold garbage for some frames.
pub fn reserve(mut settings: ResMut<GlobalClusterSettings>) {
    if let Some(gpu) = &mut settings.gpu_clustering {
        gpu.initial_z_slice_list_capacity = 1 << 15;
        gpu.initial_index_list_capacity = 1 << 19;
    }
}
