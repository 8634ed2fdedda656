//! Room for the lights of the scene in Bevy's lists.

use bevy::{light::cluster::GlobalClusterSettings, prelude::*};

/// When Bevy grows them at run time, they are garbage for some frames.
pub fn reserve(mut settings: ResMut<GlobalClusterSettings>) {
    if let Some(gpu) = &mut settings.gpu_clustering {
        gpu.initial_z_slice_list_capacity = 1 << 15;
        gpu.initial_index_list_capacity = 1 << 19;
    }
}
