//! Detects shifts of the world. Apps with distant cameras shift everything from time to time, cameras and meshes alike, to stay near
//! the origin, where floats are precise ("floating origin": Thorne 2005, "Using a Floating Origin to Improve Fidelity and Performance
//! of Large, Distributed Virtual Worlds").
//!
//! A shift moves nothing in the picture, so the history stays valid.

use bevy::{
    ecs::entity::EntityHashMap,
    math::DVec3,
    pbr::PreviousGlobalTransform,
    prelude::*,
    render::extract_resource::{ExtractResource, ExtractResourcePlugin},
};

use crate::view::LeanDeferred;

/// Sum of all world shifts since the app started, in metres.
#[derive(Resource, ExtractResource, Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct WorldShift(pub(super) DVec3);

/// Least movement of a camera in a frame, in metres, for which meshes are checked. At 60 frames per second this is the speed of a
/// bullet.
pub(super) const LEAST: f32 = 16.0;
/// Number of meshes to check, evenly spread over all.
const SAMPLES: usize = 256;
/// Quarters of the checked meshes that must share the movement. The others may move on their own.
const ALIKE: usize = 3;
/// Tolerated deviation from the common movement, as a share of its length: allows for own movement and float rounding.
const TOLERANCE: f32 = 0.02;

/// Adds up shifts of the world. Checks meshes only in frames in which a camera moved far.
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

/// The movement that most meshes share, if it is far.
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

/// Detects shifts and extracts their sum to the render world.
pub(super) fn add_to(app: &mut App) {
    app.init_resource::<WorldShift>()
        .add_plugins(ExtractResourcePlugin::<WorldShift>::default())
        // In `Last`, `GlobalTransform` is that of this frame and `PreviousGlobalTransform` that of the last.
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
        // Half of the meshes move, like a train with its passengers.
        assert_eq!(common_move([[SHIFT; 3], [DVec3::ZERO; 3]].concat()), None);
        // Each mesh moves by another distance.
        let apart = (0..16).map(|i| SHIFT * f64::from(i));
        assert_eq!(common_move(apart.collect()), None);
        assert_eq!(common_move(vec![DVec3::NAN; 4]), None);
        assert_eq!(common_move(vec![DVec3::X; 4]), None);
    }
}
