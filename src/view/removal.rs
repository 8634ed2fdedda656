//! Removes dependent components together with their source.

use bevy::{app::SubApp, prelude::*};

/// Removes `B` from views that lose `C`: when it is removed from the camera, and with a lost device.
pub(crate) fn remove_with<C: Component, B: Bundle>(render_app: &mut SubApp) {
    render_app
        .world_mut()
        .add_observer(|removed: On<Remove, C>, mut commands: Commands| {
            commands
                .entity(removed.entity)
                .queue_silenced(|mut view: EntityWorldMut| {
                    view.remove::<B>();
                });
        });
}
