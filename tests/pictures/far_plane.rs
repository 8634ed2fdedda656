//! Surfaces at depth 0, which is also the sky's: an orthographic camera has them at exactly `far`.

use bevy::{
    camera::visibility::NoFrustumCulling, core_pipeline::prepass::DepthPrepass, prelude::*,
};
use kit::{
    lean::{active_lean_views, build, judge, report, set_lean, settled},
    own_process::in_own_process,
    scenes::LEAST_PSNR,
};

const SIZE: UVec2 = UVec2::new(96, 64);
/// Its reciprocal is exact, and so is depth.
const FAR: f32 = 8.0;

/// A wall at `FAR`, with a ball in front of it.
fn check(name: &str, camera: impl Bundle) {
    let mut headless = build(SIZE, |s| {
        let wall = s.mesh(
            Rectangle::new(3.0, 3.0),
            StandardMaterial::from(Color::srgb(0.8, 0.4, 0.2)),
            Transform::default(),
        );
        s.world().entity_mut(wall).insert(NoFrustumCulling);
        s.mesh(
            Sphere::new(0.4),
            StandardMaterial::from(Color::srgb(0.2, 0.5, 0.8)),
            Transform::from_xyz(0.5, 0.0, 1.0),
        );
        s.sun(true);
        let projection = Projection::from(OrthographicProjection {
            scale: 0.06,
            near: 0.0,
            far: FAR,
            ..OrthographicProjection::default_3d()
        });
        s.camera(Transform::from_xyz(0.0, 0.0, FAR), (projection, camera));
    });
    set_lean(&mut headless, false);
    let forward = settled(&mut headless);
    let at = |x: u32, y: u32| ((y * SIZE.x + x) * 4) as usize;
    let [corner, wall] = [at(1, 1), at(SIZE.x / 2 - 6, SIZE.y / 2)];
    assert!(
        forward.rgba[wall] > forward.rgba[corner] + 50,
        "{name}: forward shows the wall"
    );
    set_lean(&mut headless, true);
    let lean = settled(&mut headless);
    assert_eq!(active_lean_views(&mut headless), 1);
    report([judge(name, &forward, &lean, LEAST_PSNR)]);
}

#[test]
fn walls_at_the_far_plane_are_seen() {
    in_own_process(|| {
        check("far_plane", ());
        check("far_plane_prepass", DepthPrepass);
    });
}
