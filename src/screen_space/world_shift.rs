//! Shifts of the world: apps whose cameras go far move all that there is from time to time, cameras and meshes alike, so that these stay
//! near the origin, where floats are exact ("floating origin": Thorne 2005, "Using a Floating Origin to Improve Fidelity and
//! Performance of Large, Distributed Virtual Worlds").
//!
//! Nothing in the picture moves then, and what was kept of the last frame is where it was.

use bevy::{
    ecs::entity::EntityHashMap,
    math::DVec3,
    pbr::PreviousGlobalTransform,
    prelude::*,
    render::extract_resource::{ExtractResource, ExtractResourcePlugin},
};

use crate::view::LeanDeferred;

/// By how much the world has been shifted since the app began.
#[derive(Resource, ExtractResource, Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct WorldShift(pub(super) DVec3);

/// How far a camera goes in a frame at least, in metres, before somebody looks whether all else went along. At 60 frames a second it
/// would be as fast as a bullet.
const LEAST: f32 = 16.0;
/// So many meshes are looked at, evenly among all.
const SAMPLES: usize = 256;
/// Of these, so many in four have to have gone the same way: others may move by themselves.
const ALIKE: usize = 3;
/// They may have gone further or less far by this share of the way: what moves by itself, and the rounding of floats.
const TOLERANCE: f32 = 0.02;

/// Notices that all was shifted. Looks at meshes only in frames in which a camera was moved far.
fn notice_world_shifts(
    mut shift: ResMut<WorldShift>,
    mut last: Local<EntityHashMap<Vec3>>,
    cameras: Query<(Entity, &GlobalTransform), (With<Camera>, With<LeanDeferred>)>,
    meshes: Query<(&GlobalTransform, &PreviousGlobalTransform), With<Mesh3d>>,
) {
    last.retain(|camera, _| cameras.contains(*camera));
    let mut is_far = false;
    for (camera, transform) in &cameras {
        let now = transform.translation();
        let before = last.insert(camera, now).unwrap_or(now);
        is_far |= now.distance(before) > LEAST;
    }
    if !is_far {
        return;
    }
    let step = meshes.iter().len().div_ceil(SAMPLES).max(1);
    let moves = meshes.iter().step_by(step).map(|(now, before)| {
        now.translation().as_dvec3() - Vec3::from(before.0.translation).as_dvec3()
    });
    if let Some(moved) = common_move(moves.collect()) {
        shift.0 += moved;
    }
}

/// By how much most have moved, if that is far.
fn common_move(moves: Vec<DVec3>) -> Option<DVec3> {
    let middle = |axis: fn(&DVec3) -> f64| -> Option<f64> {
        let mut along: Vec<f64> = moves.iter().map(axis).collect();
        along.sort_by(f64::total_cmp);
        along.get(along.len() / 2).copied()
    };
    let middle = DVec3::new(middle(|v| v.x)?, middle(|v| v.y)?, middle(|v| v.z)?);
    let far = middle.length();
    let near_it = moves
        .iter()
        .filter(|moved| moved.distance(middle) < f64::from(TOLERANCE) * far);
    let is_common = 4 * near_it.count() >= ALIKE * moves.len();
    (is_common && far.is_finite() && far > f64::from(LEAST)).then_some(middle)
}

/// Notices shifts, and tells the render world of them.
pub(super) fn add_to(app: &mut App) {
    app.init_resource::<WorldShift>()
        .add_plugins(ExtractResourcePlugin::<WorldShift>::default())
        // Where transforms are those of this frame, and the previous ones those of the last.
        .add_systems(
            Last,
            notice_world_shifts.run_if(any_with_component::<LeanDeferred>),
        );
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHIFT: DVec3 = DVec3::new(-2048.0, 0.0, 512.0);

    #[test]
    fn what_most_have_done_is_a_shift() {
        let walker = SHIFT + DVec3::new(0.3, 0.0, 0.1);
        let moves = vec![SHIFT, SHIFT, walker, SHIFT, DVec3::ZERO];
        assert_eq!(common_move(moves), Some(SHIFT));
    }

    #[test]
    fn what_stays_or_goes_a_way_of_its_own_is_none() {
        assert_eq!(common_move(Vec::new()), None);
        assert_eq!(common_move(vec![DVec3::ZERO; 8]), None);
        // A carriage with its passengers, in a world that stays.
        assert_eq!(common_move([[SHIFT; 3], [DVec3::ZERO; 3]].concat()), None);
        // All somewhere else.
        let apart = (0..16).map(|i| SHIFT * f64::from(i));
        assert_eq!(common_move(apart.collect()), None);
        assert_eq!(common_move(vec![DVec3::NAN; 4]), None);
        assert_eq!(common_move(vec![DVec3::X; 4]), None);
    }
}
