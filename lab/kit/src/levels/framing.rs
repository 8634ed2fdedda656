//! A view of a whole model.

use bevy::{camera::primitives::Aabb, prelude::*};

/// A view of all meshes from the front, a little above and to the right; `None` if no mesh has bounds.
pub fn framing_view(world: &mut World) -> Option<Transform> {
    let mut bounds: Option<(Vec3, Vec3)> = None;
    let mut meshes = world.query::<(&Aabb, &GlobalTransform)>();
    for (aabb, transform) in meshes.iter(world) {
        let center = transform.transform_point(aabb.center.into());
        let radius = transform.radius_vec3a(aabb.half_extents);
        let (low, high) = bounds.unwrap_or((center, center));
        bounds = Some((low.min(center - radius), high.max(center + radius)));
    }
    let (low, high) = bounds?;
    let (center, size) = ((low + high) / 2.0, (high - low).length());
    let place = center + Vec3::new(0.35, 0.25, 1.0) * size * 0.55;
    Some(Transform::from_translation(place).looking_at(center, Vec3::Y))
}
