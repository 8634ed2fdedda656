//! The statuses that effects have on cameras in a frame: reported to the main world, and logged.

use core::mem::discriminant;

use bevy::{
    prelude::*,
    render::{
        MainWorld,
        sync_world::{MainEntity, MainEntityHashMap},
    },
};

use super::{
    lighting_io::LightingIo,
    settings::LeanDeferred,
    status::{Effect, EffectStatus, LeanOffReason, LeanStatus},
};

/// In the render world: the status of each effect on each camera. It is kept between frames, so that an unchanged status
/// allocates nothing.
#[derive(Resource, Default)]
pub(crate) struct EffectStatuses {
    cameras: MainEntityHashMap<CameraStatuses>,
    /// Requirements of each effect that the device does not meet, as they were logged.
    told_of_device: [String; Effect::ALL.len()],
}

#[derive(Default)]
struct CameraStatuses {
    effects: [Decided; Effect::ALL.len()],
    /// Inputs and outputs of lighting in this frame.
    io: LightingIo,
    /// It was logged that the camera has become lean.
    is_told_lean: bool,
}

#[derive(Default)]
struct Decided {
    status: EffectStatus,
    in_this_frame: bool,
}

static NOT_RENDERED: EffectStatus = EffectStatus::Off(LeanOffReason::NotRendered);
static NOT_LEAN: EffectStatus = EffectStatus::Off(LeanOffReason::NotLean);
static COMPILING: EffectStatus = EffectStatus::Compiling;

/// The input or output by which lighting takes part in an effect.
fn light_of(effect: Effect) -> Option<LightingIo> {
    match effect {
        Effect::DiffuseGi => Some(LightingIo::INDIRECT_DIFFUSE),
        Effect::Reflections => Some(LightingIo::INDIRECT_SPECULAR),
        Effect::Subsurface => Some(LightingIo::SUBSURFACE_LIGHT),
        Effect::Deferred | Effect::AmbientOcclusion | Effect::AutoExposure => None,
    }
}

impl CameraStatuses {
    /// The status that was set in this frame.
    fn decided(&self, effect: Effect) -> &EffectStatus {
        let decided = &self.effects[effect as usize];
        if decided.in_this_frame {
            &decided.status
        } else {
            &NOT_RENDERED
        }
    }

    /// As [`decided`](Self::decided), with the part of lighting: it decides after the effects that it takes part in.
    fn current(&self, effect: Effect) -> &EffectStatus {
        let status = self.decided(effect);
        let is_on = *status == EffectStatus::On;
        let may_run = is_on
            || matches!(
                status,
                // Only a lean view knows of its surfaces.
                EffectStatus::Compiling | EffectStatus::Off(LeanOffReason::NothingScatters)
            );
        let Some(light) = light_of(effect).filter(|_| may_run) else {
            return status;
        };
        match self.decided(Effect::Deferred) {
            EffectStatus::On if !is_on || self.io.contains(light) => status,
            EffectStatus::On | EffectStatus::Compiling => &COMPILING,
            EffectStatus::Off(_) | EffectStatus::Absent => &NOT_LEAN,
        }
    }
}

impl EffectStatuses {
    /// The status of `effect` on `camera`, to be set in each frame in which the camera is rendered.
    pub(crate) fn of(&mut self, camera: MainEntity, effect: Effect) -> StatusOf<'_> {
        StatusOf {
            told_of_device: &mut self.told_of_device[effect as usize],
            statuses: self.cameras.entry(camera).or_default(),
            camera,
            effect,
        }
    }

    /// Sets what lighting does on `camera` in this frame, if it is lean.
    pub(crate) fn set_lighting(&mut self, camera: MainEntity, io: LightingIo) {
        self.cameras.entry(camera).or_default().io = io;
    }

    /// True once for a camera that is lean in this frame: again only after Bevy has rendered it in its place.
    pub(crate) fn is_newly_lean(&mut self, camera: MainEntity) -> bool {
        let Some(statuses) = self.cameras.get_mut(&camera) else {
            return false;
        };
        !core::mem::replace(&mut statuses.is_told_lean, true)
    }

    /// Copies the statuses of the last frame to the cameras in the main world, and forgets effects that they have lost.
    fn report(&mut self, main_world: &mut World) {
        self.cameras.retain(|camera, statuses| {
            let mut reported = main_world.get_mut::<LeanStatus>(camera.id());
            let has = Effect::ALL.map(|effect| {
                let reported = reported.as_ref().map(|reported| reported.of(effect));
                reported.is_some_and(|reported| *reported != EffectStatus::Absent)
            });
            if let Some(reported) = &mut reported {
                for effect in Effect::ALL {
                    let status = statuses.current(effect);
                    if has[effect as usize] && reported.of(effect) != status {
                        *reported.of_mut(effect) = status.clone();
                    }
                }
            }
            for (decided, has) in statuses.effects.iter_mut().zip(has) {
                // One that was set without a component is kept for as long as it is set.
                if has || decided.in_this_frame {
                    decided.in_this_frame = false;
                } else {
                    decided.status = EffectStatus::Absent;
                }
            }
            let is_forgotten = |effect: &Decided| effect.status == EffectStatus::Absent;
            if is_forgotten(&statuses.effects[Effect::Deferred as usize]) {
                statuses.is_told_lean = false;
            }
            !statuses.effects.iter().all(is_forgotten)
        });
    }
}

/// The status of one effect on one camera.
pub(crate) struct StatusOf<'a> {
    statuses: &'a mut CameraStatuses,
    told_of_device: &'a mut String,
    camera: MainEntity,
    effect: Effect,
}

impl StatusOf<'_> {
    /// Sets the status, and logs reasons that are of the camera or the device.
    fn set(&mut self, status: EffectStatus) {
        let decided = &mut self.statuses.effects[self.effect as usize];
        decided.in_this_frame = true;
        if decided.status == status {
            return;
        }
        if let EffectStatus::Off(reason) = &status {
            let component = self.effect.component();
            match reason {
                LeanOffReason::Device(missing) if *self.told_of_device != *missing => {
                    warn!("{component} is off on all cameras: {reason}.");
                    self.told_of_device.clone_from(missing);
                }
                reason if reason.is_of_camera() => {
                    let camera = self.camera.id();
                    warn!("{component} on camera {camera} is off: {reason}.");
                }
                _ => {}
            }
            if self.effect == Effect::Deferred {
                self.statuses.is_told_lean = false;
            }
        }
        self.statuses.effects[self.effect as usize].status = status;
    }

    /// Sets it to off for a reason with a `text`, which is copied only if it differs from the current one.
    fn set_off_for(&mut self, reason: fn(String) -> LeanOffReason, text: &str) {
        let decided = &mut self.statuses.effects[self.effect as usize];
        if let EffectStatus::Off(known) = &decided.status
            && known.text() == Some(text)
            && discriminant(known) == discriminant(&reason(String::new()))
        {
            decided.in_this_frame = true;
            return;
        }
        self.set(EffectStatus::Off(reason(text.into())));
    }

    /// Sets it to off, and returns true, if there is a `reason`.
    pub(crate) fn is_off_for(&mut self, reason: Option<LeanOffReason>) -> bool {
        let is_off = reason.is_some();
        if let Some(reason) = reason {
            self.set(EffectStatus::Off(reason));
        }
        is_off
    }

    /// Sets it to off, and returns true, if the camera has no `LeanDeferred` or one that is not enabled.
    pub(crate) fn is_off_without(&mut self, lean: Option<&LeanDeferred>) -> bool {
        self.is_off_for(match lean {
            None => Some(LeanOffReason::NoLeanDeferred),
            Some(lean) => (!lean.enabled).then_some(LeanOffReason::NotLean),
        })
    }

    /// Sets it to off, and returns true, if the device does not `support` the effect.
    pub(crate) fn is_off_by_device(&mut self, support: &Result<(), String>) -> bool {
        if let Err(missing) = support {
            self.set_off_for(LeanOffReason::Device, missing);
        }
        support.is_err()
    }

    /// Sets it to off, and returns true, if the texture with this label does not fit into memory.
    pub(crate) fn is_off_by_memory(&mut self, label: Option<&str>) -> bool {
        if let Some(label) = label {
            self.set_off_for(LeanOffReason::OutOfMemory, label);
        }
        label.is_some()
    }

    /// Sets the status of an effect that has no reason to be off: on while it `runs`, with its pipelines or former ones;
    /// otherwise compiling, or off for a `failure` of a shader.
    pub(crate) fn set_running(&mut self, runs: bool, failure: Option<&str>) {
        match (runs, failure) {
            (true, _) => self.set(EffectStatus::On),
            (false, None) => self.set(EffectStatus::Compiling),
            (false, Some(cause)) => self.set_off_for(LeanOffReason::Shader, cause),
        }
    }
}

/// True while a camera has a status to report.
pub(super) fn are_statuses_known(statuses: Res<EffectStatuses>) -> bool {
    !statuses.cameras.is_empty()
}

/// Copies the statuses of the last frame to the cameras in the main world.
pub(super) fn report_statuses(
    mut main_world: ResMut<MainWorld>,
    mut statuses: ResMut<EffectStatuses>,
) {
    statuses.report(&mut main_world);
}

#[cfg(test)]
mod tests {
    use super::*;

    const GI: Effect = Effect::DiffuseGi;
    const LEAN: Effect = Effect::Deferred;

    fn off(reason: LeanOffReason) -> EffectStatus {
        EffectStatus::Off(reason)
    }

    /// A world with a camera that has `LeanDeferred` and diffuse GI.
    fn world() -> (World, MainEntity) {
        let mut world = World::new();
        let camera = world.spawn(LeanStatus {
            deferred: NOT_RENDERED.clone(),
            diffuse_gi: NOT_RENDERED.clone(),
            ..default()
        });
        let camera = camera.id().into();
        (world, camera)
    }

    fn reported(
        statuses: &mut EffectStatuses,
        world: &mut World,
        camera: MainEntity,
    ) -> LeanStatus {
        statuses.report(world);
        world.get::<LeanStatus>(camera.id()).unwrap().clone()
    }

    #[test]
    fn a_reason_that_is_no_news_is_not_copied() {
        let mut statuses = EffectStatuses::default();
        let camera = MainEntity::from(Entity::from_raw_u32(1).unwrap());
        let mut text = |reason: fn(String) -> LeanOffReason, text: &str| {
            statuses.of(camera, GI).set_off_for(reason, text);
            let decided = &statuses.cameras[&camera].effects[GI as usize];
            assert!(decided.in_this_frame);
            let EffectStatus::Off(reason) = &decided.status else {
                panic!("{:?}", decided.status);
            };
            let text = reason.text().expect("it has one");
            (text.as_ptr(), reason.clone())
        };
        let (first, _) = text(LeanOffReason::Device, "compute shaders");
        let (second, reason) = text(LeanOffReason::Device, "compute shaders");
        assert_eq!(first, second);
        assert_eq!(reason, LeanOffReason::Device("compute shaders".into()));
        let (_, reason) = text(LeanOffReason::Shader, "compute shaders");
        assert_eq!(reason, LeanOffReason::Shader("compute shaders".into()));
    }

    #[test]
    fn light_is_on_once_lighting_takes_part_in_it() {
        let (mut world, camera) = world();
        let mut statuses = EffectStatuses::default();
        let mut frame = |lean: Option<EffectStatus>, io: LightingIo| {
            statuses.of(camera, GI).set_running(true, None);
            if let Some(lean) = lean {
                statuses.of(camera, LEAN).set(lean);
            }
            statuses.set_lighting(camera, io);
            reported(&mut statuses, &mut world, camera).diffuse_gi
        };
        let (on, nothing) = (EffectStatus::On, LightingIo::empty());
        let light = LightingIo::INDIRECT_DIFFUSE;
        assert_eq!(frame(Some(on.clone()), light), on);
        assert_eq!(frame(Some(on), nothing), COMPILING);
        assert_eq!(frame(Some(COMPILING.clone()), light), COMPILING);
        assert_eq!(frame(Some(off(LeanOffReason::Msaa)), light), NOT_LEAN);
        // Without the plugin of `LeanDeferred`.
        assert_eq!(frame(None, nothing), NOT_LEAN);
    }

    #[test]
    fn statuses_are_kept_in_pauses_and_forgotten_with_the_component() {
        let (mut world, camera) = world();
        let mut statuses = EffectStatuses::default();
        let status = |statuses: &EffectStatuses, effect: Effect| {
            let of_camera = statuses.cameras.get(&camera);
            of_camera.map(|statuses| statuses.effects[effect as usize].status.clone())
        };
        statuses.of(camera, GI).set(off(LeanOffReason::Msaa));
        statuses.of(camera, LEAN).set(off(LeanOffReason::NotHdr));
        let seen = reported(&mut statuses, &mut world, camera);
        assert_eq!(seen.diffuse_gi, off(LeanOffReason::Msaa));
        assert_eq!(seen.deferred, off(LeanOffReason::NotHdr));
        assert_eq!(seen.auto_exposure, EffectStatus::Absent);

        let seen = reported(&mut statuses, &mut world, camera);
        assert_eq!(seen.diffuse_gi, NOT_RENDERED);
        assert_eq!(status(&statuses, GI), Some(off(LeanOffReason::Msaa)));

        world.get_mut::<LeanStatus>(camera.id()).unwrap().diffuse_gi = EffectStatus::Absent;
        statuses.report(&mut world);
        assert_eq!(status(&statuses, GI), Some(EffectStatus::Absent));
        assert_eq!(status(&statuses, LEAN), Some(off(LeanOffReason::NotHdr)));
        world.despawn(camera.id());
        statuses.report(&mut world);
        assert_eq!(status(&statuses, LEAN), None);
    }

    #[test]
    fn a_camera_is_newly_lean_after_bevy_has_rendered_it() {
        let camera = MainEntity::from(Entity::from_raw_u32(1).unwrap());
        let mut statuses = EffectStatuses::default();
        assert!(!statuses.is_newly_lean(camera));
        for _ in 0..2 {
            statuses.of(camera, LEAN).set_running(true, None);
            assert!(statuses.is_newly_lean(camera));
            assert!(!statuses.is_newly_lean(camera));
            statuses
                .of(camera, LEAN)
                .is_off_for(Some(LeanOffReason::Msaa));
        }
    }
}
