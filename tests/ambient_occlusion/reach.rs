//! Limits of the radius on screen.

use std::f64::consts::FRAC_PI_8;

use bevy::math::DVec3;
use bevy_lean_deferred::effects::ambient_occlusion::LeanScreenSpaceAmbientOcclusion;

use crate::views::{RADIUS, SIZE, TALL, View, corner, kinds, run};
use kit::{
    occlusion::{geometry::Geometry, solids::Hit},
    occlusion_gpu::OcclusionGpu,
};

fn largest(occlusion: &[f32]) -> f32 {
    occlusion.iter().copied().fold(0.0, f32::max)
}

/// 0.2 m in front of a wall the radius would exceed the screen, so the result is that of the capped radius.
#[test]
fn the_radius_is_capped_near_the_camera() {
    let gpu = OcclusionGpu::new();
    let flat = View::new(
        "flat",
        Geometry::Plane {
            point: DVec3::ZERO,
            normal: DVec3::Z,
        },
        [0.0, 0.0, 0.2],
        [0.05, 0.0, 0.0],
    );
    let foot = View::new(
        "foot of a wall",
        Geometry::Wall { height: TALL },
        [0.2, 0.12, 0.1],
        [0.0, 0.0, 0.0],
    );
    for settings in kinds() {
        let seen = flat.seen_within(0.0);
        let largest = largest(&run(&gpu, &settings, &seen.image).filtered);
        println!(
            "0.2 m before a plane, {:?}, {:?}: {largest}",
            settings.advanced.kernel, settings.resolution
        );
        assert_eq!(largest, 0.0);
    }

    let mut seen = foot.seen_within(0.0);
    let view_from_world = seen.buffer.camera.world_from_view.inverse();
    let pixels_per_metre = 0.5 * f64::from(SIZE.y) / FRAC_PI_8.tan();
    // Capped to a quarter of the picture's height.
    let radius = |hit: &Hit| {
        let distance = -view_from_world.transform_point3(hit.point).z;
        RADIUS.min(0.25 * f64::from(SIZE.y) * distance / pixels_per_metre)
    };
    let hits = seen.buffer.hits.iter();
    seen.truth = hits
        .map(|hit| Some(foot.scene.occlusion(hit.as_ref()?, radius(hit.as_ref()?))? as f32))
        .collect();
    let hits = seen.buffer.hits.iter().map(Option::as_ref);
    seen.mask = hits
        .map(|hit| {
            hit.is_some_and(|hit| {
                let position = view_from_world.transform_point3(hit.point);
                seen.buffer.camera.shows_sphere(position, radius(hit))
            })
        })
        .collect();
    let errors = seen.errors(
        &run(
            &gpu,
            &LeanScreenSpaceAmbientOcclusion::default(),
            &seen.image,
        )
        .filtered,
    );
    println!("0.2 m before the foot of a wall: {errors}");
    assert!(errors.rmse <= 0.04);
}

#[test]
fn nothing_is_found_within_less_than_a_pixel() {
    let gpu = OcclusionGpu::new();
    let seen = corner().seen();
    for radius in [0.0, 1e-30, 1e-4, 0.003] {
        for settings in kinds() {
            let settings = LeanScreenSpaceAmbientOcclusion { radius, ..settings };
            let largest = largest(&run(&gpu, &settings, &seen.image).filtered);
            println!(
                "radius {radius} m, {:?}, {:?}: {largest}",
                settings.advanced.kernel, settings.resolution
            );
            assert_eq!(largest, 0.0);
        }
    }
}
