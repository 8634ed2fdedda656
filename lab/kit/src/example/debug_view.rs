//! The debug view of an example's camera.

use bevy::{core_pipeline::tonemapping::Tonemapping, prelude::*};
use bevy_lean_deferred::prelude::*;

use super::panel::cameras;

/// True if the camera has the effect that the view is of.
fn has_effect(camera: EntityRef, view: DebugView) -> bool {
    match view {
        DebugView::AmbientOcclusion => camera.contains::<LeanScreenSpaceAmbientOcclusion>(),
        DebugView::GiLight | DebugView::GiVisibility => camera.contains::<LeanScreenSpaceGi>(),
        DebugView::ReflectionLight | DebugView::ReflectionConfidence | DebugView::ReflectionHit => {
            camera.contains::<LeanScreenSpaceReflections>()
        }
        DebugView::ExposureWeights => camera.contains::<LeanAutoExposure>(),
        _ => camera.contains::<LeanDeferred>(),
    }
}

/// Shows the next view of an effect that the camera has, or the one before; the picture comes after the last view.
pub fn change_view(world: &mut World, forward: bool) {
    for camera in cameras(world) {
        let entity = world.entity(camera);
        let shown = entity.get::<LeanDebugView>().copied();
        let all = DebugView::ALL.into_iter();
        let views: Vec<DebugView> = all.filter(|view| has_effect(entity, *view)).collect();
        let index = shown.and_then(|shown| views.iter().position(|view| *view == shown.shows));
        let next = match (index, forward) {
            (None, true) => views.first(),
            (None, false) => views.last(),
            (Some(index), true) => views.get(index + 1),
            (Some(index), false) => index.checked_sub(1).and_then(|index| views.get(index)),
        };
        let mut entity = world.entity_mut(camera);
        match next {
            Some(view) => entity.insert(LeanDebugView {
                shows: *view,
                split: shown.map_or(1.0, |shown| shown.split),
            }),
            None => entity.remove::<LeanDebugView>(),
        };
    }
}

/// Shows the view on the whole picture, or on its left half.
pub fn change_split(world: &mut World) {
    for camera in cameras(world) {
        if let Some(mut view) = world.get_mut::<LeanDebugView>(camera) {
            view.split = if view.split < 1.0 { 1.0 } else { 0.5 };
        }
    }
}

/// Takes tonemapping away while data cover the picture, so that they are shown unchanged.
pub fn set_tonemapping(world: &mut World) {
    for camera in cameras(world) {
        let entity = world.entity(camera);
        let shows_data = entity.get::<LeanDebugView>().is_some_and(|view| {
            let is_data = view.shows != DebugView::ExposureWeights;
            is_data && view.split >= 1.0 && has_effect(entity, view.shows)
        });
        let Some(mut tonemapping) = world.get_mut::<Tonemapping>(camera) else {
            continue;
        };
        if shows_data {
            tonemapping.set_if_neq(Tonemapping::None);
        } else if *tonemapping == Tonemapping::None {
            *tonemapping = Tonemapping::default();
        }
    }
}
