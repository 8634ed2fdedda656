//! Tells users once for each camera why an effect is off.

use core::fmt::Display;

use bevy::{
    prelude::*,
    render::sync_world::{MainEntity, MainEntityHashMap},
};

/// What users have been told of, by camera.
pub(crate) struct WarnOnce<R> {
    told: MainEntityHashMap<R>,
}

impl<R> Default for WarnOnce<R> {
    fn default() -> Self {
        Self { told: default() }
    }
}

impl<R: Display + PartialEq> WarnOnce<R> {
    /// Called in each frame in which `camera` is rendered, with the reason why its `effect` is off. Warns if that is another one
    /// than in the last of these frames.
    pub(crate) fn tell(&mut self, effect: &str, camera: MainEntity, reason: Option<R>) {
        self.tell_that("is off", effect, camera, reason);
    }

    /// As [`tell`](Self::tell), of an effect of which there is something else to be said.
    pub(crate) fn tell_that(
        &mut self,
        state: &str,
        effect: &str,
        camera: MainEntity,
        reason: Option<R>,
    ) {
        let Some(reason) = reason else {
            self.told.remove(&camera);
            return;
        };
        if self.told.get(&camera) != Some(&reason) {
            warn!("{effect} on camera {} {state}: {reason}.", camera.id());
            self.told.insert(camera, reason);
        }
    }

    /// Forgets the cameras that are not among `cameras`: those that have the effect, rendered or not.
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
