//! Warns once per camera that a part of an effect is off, with the reason. For effects as a whole, `effect_statuses.rs` does so.

use core::fmt::Display;

use bevy::{
    prelude::*,
    render::sync_world::{MainEntity, MainEntityHashMap},
};

/// The last warning per camera.
pub(crate) struct WarnOnce<R> {
    told: MainEntityHashMap<R>,
}

impl<R> Default for WarnOnce<R> {
    fn default() -> Self {
        Self { told: default() }
    }
}

impl<R: Display + PartialEq> WarnOnce<R> {
    /// Call in each frame in which `camera` is rendered, with the reason that `part` of an effect is off on it. Warns if
    /// the reason differs from that of the last such frame.
    pub(crate) fn tell(&mut self, part: &str, camera: MainEntity, reason: Option<R>) {
        let Some(reason) = reason else {
            self.told.remove(&camera);
            return;
        };
        if self.told.get(&camera) != Some(&reason) {
            warn!("{part} on camera {} is off: {reason}.", camera.id());
            self.told.insert(camera, reason);
        }
    }

    /// Forgets cameras that are not among `cameras`: those with the effect, rendered or not.
    pub(crate) fn keep_only<'a>(&mut self, cameras: impl Iterator<Item = &'a MainEntity> + Clone) {
        self.told
            .retain(|camera, _| cameras.clone().any(|other| other == camera));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_told_is_forgotten_with_the_camera_and_with_the_cause() {
        let mut warnings = WarnOnce::default();
        let [one, other] =
            [1, 2].map(|index| MainEntity::from(Entity::from_raw_u32(index).unwrap()));
        warnings.tell("An effect", one, Some("a reason"));
        warnings.tell("An effect", other, Some("a reason"));
        assert_eq!(warnings.told.len(), 2);
        warnings.keep_only([other].iter());
        assert_eq!(warnings.told.len(), 1);
        warnings.tell("An effect", other, Some("another reason"));
        assert_eq!(warnings.told[&other], "another reason");
        warnings.tell("An effect", other, None);
        assert!(warnings.told.is_empty());
    }
}
