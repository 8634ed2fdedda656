//! Changes cameras only for effects that the device can run.

use bevy::{ecs::component::ComponentId, prelude::*};

use super::{
    needs::{CameraNeeds, Need},
    record::CameraOverrides,
};

/// Changes cameras that already have effects for those that the device can run, and reverts changes for others. Call it
/// for each new device, once [`LeanSupport`](crate::LeanSupport) tells of it.
pub(crate) fn fit_device(world: &mut World) {
    let runs: Vec<bool> = (world.resource::<CameraNeeds>().0.iter())
        .map(|effect| (effect.can_run)(world))
        .collect();
    let mut changed: Vec<(ComponentId, &'static [Need])> = Vec::new();
    for (effect, runs) in (world.resource_mut::<CameraNeeds>().0.iter_mut()).zip(runs) {
        if effect.runs != runs {
            effect.runs = runs;
            changed.push((effect.effect, if runs { effect.needs } else { &[] }));
        }
    }
    if changed.is_empty() {
        return;
    }
    let cameras: Vec<(Entity, Vec<Need>)> = (world.query::<EntityRef>().iter(world))
        .filter_map(|camera| {
            let mut had = changed
                .iter()
                .filter(|(effect, _)| camera.contains_id(*effect))
                .peekable();
            had.peek()?;
            let needs = had.flat_map(|(_, needs)| needs.iter().copied()).collect();
            Some((camera.id(), needs))
        })
        .collect();
    for (camera, needs) in cameras {
        if let Ok(mut camera) = world.get_entity_mut(camera) {
            CameraOverrides::change(&mut camera, |overrides, camera| {
                overrides.fit_all(camera, &needs);
                overrides.give_back(camera);
            });
        }
    }
}
