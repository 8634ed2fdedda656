//! Projections match Bevy's, and depth buffers are the right way up.

use bevy::math::{DVec2, DVec3, Mat4, UVec2, Vec2, Vec3};
use kit::{
    occlusion::{
        camera::{Camera, Projection},
        depth_buffer::{DepthBuffer, pixels},
        geometry::{Geometry, Scene},
    },
    random::Random,
};

use super::directions::cosine_weighted;

pub const PERSPECTIVE: Projection = Projection::Perspective {
    fov_y: 1.0,
    near: 0.1,
};

/// A camera whose up vector also suits views from straight above.
pub fn camera(eye: DVec3, target: DVec3, projection: Projection, size: UVec2) -> Camera {
    Camera::looking_at(eye, target, DVec3::new(0.0, 1.0, -0.1), projection, size)
}

#[test]
#[ignore = "nightly: tests the tests' reference"]
fn projections_are_bevys() {
    let size = UVec2::new(40, 30);
    let aspect = size.x as f32 / size.y as f32;
    // The orthographic matrix as from `OrthographicProjection::get_clip_from_view`.
    let cases = [
        (
            PERSPECTIVE,
            Mat4::perspective_infinite_reverse_rh(1.0, aspect, 0.1),
        ),
        (
            Projection::Orthographic {
                height: 3.0,
                near: 0.5,
                far: 40.0,
            },
            Mat4::orthographic_rh(-1.5 * aspect, 1.5 * aspect, -1.5, 1.5, 40.0, 0.5),
        ),
    ];
    let mut random = Random::new(3);
    for (projection, clip_from_view) in cases {
        let camera = camera(DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO, projection, size);
        assert!(
            camera
                .clip_from_view()
                .as_mat4()
                .abs_diff_eq(clip_from_view, 1e-6)
        );
        for _ in 0..100 {
            let position = Vec3::new(
                random.range(-1.0, 1.0),
                random.range(-1.0, 1.0),
                random.range(-20.0, -2.0),
            );
            let ndc = clip_from_view.project_point3(position);
            let position = position.as_dvec3();
            let depth = camera.depth(-position.z);
            assert!((depth - f64::from(ndc.z)).abs() < 1e-6);
            let pixel = camera.pixel(position);
            let expected =
                (ndc.truncate() * Vec2::new(0.5, -0.5) + 0.5).as_dvec2() * size.as_dvec2();
            assert!(pixel.distance(expected) < 1e-4);
            let again = camera.position(pixel, depth).unwrap();
            assert!(again.distance(position) < 1e-9);
            // On the ray through the pixel.
            let (origin, direction) = camera.ray(pixel);
            let on_ray = origin + direction * (-position.z - camera.near());
            let world = camera.world_from_view.transform_point3(position);
            assert!(on_ray.distance(world) < 1e-9);
        }
        assert_eq!(camera.position(size.as_dvec2(), 0.0), None);
    }
}

#[test]
#[ignore = "nightly: tests the tests' reference"]
fn depth_buffers_have_their_first_row_on_top() {
    let floor = Scene::new(Geometry::Plane {
        point: DVec3::ZERO,
        normal: DVec3::Y,
    });
    let camera = camera(
        DVec3::new(0.0, 1.0, 5.0),
        DVec3::Y,
        PERSPECTIVE,
        UVec2::new(4, 6),
    );
    let buffer = DepthBuffer::new(camera, &floor);
    let (sky, ground) = buffer.depths.split_at(12);
    assert!(sky.iter().all(|depth| *depth == 0.0));
    assert!(ground.iter().all(|depth| *depth > 0.0));
    assert!(ground[0] < ground[8], "near the horizon is far away");
    assert_eq!(buffer.normals()[23], Some(Vec3::Y));
    assert_eq!(buffer.truth(&floor, 1.0)[11], None);
    assert_eq!(buffer.truth(&floor, 1.0)[12], Some(0.0));
}

#[test]
#[ignore = "nightly: tests the tests' reference"]
fn interiors_hold_whole_spheres() {
    let floor = Scene::new(Geometry::Plane {
        point: DVec3::ZERO,
        normal: DVec3::Y,
    });
    let size = UVec2::new(64, 48);
    let orthographic = Projection::Orthographic {
        height: 4.0,
        near: 0.0,
        far: 20.0,
    };
    for projection in [PERSPECTIVE, orthographic] {
        let camera = camera(DVec3::new(0.0, 3.0, 3.0), DVec3::ZERO, projection, size);
        let buffer = DepthBuffer::new(camera, &floor);
        let interior = buffer.interior(5, 0.5);
        let view_from_world = camera.world_from_view.inverse();
        let mut touching = 0;
        for (((pixel, _), inside), hit) in pixels(size).zip(interior).zip(&buffer.hits) {
            let bordered = pixel.cmpge(UVec2::splat(5)).all() && pixel.cmplt(size - 5).all();
            // Points on the sphere around the hit, from `directions` over two hemispheres.
            let shown = |radius: f64| {
                cosine_weighted(2, 24).flat_map(|d| [d, -d]).all(|d| {
                    let center = view_from_world.transform_point3(hit.unwrap().point);
                    let at = camera.pixel(center + d * radius);
                    at.cmpge(DVec2::ZERO).all() && at.cmple(size.as_dvec2()).all()
                })
            };
            assert!(!inside || bordered && shown(0.5), "{pixel}");
            // A slightly larger sphere does not fit either at a pixel that the mask excludes.
            assert!(inside || !bordered || !shown(0.52), "{pixel}");
            touching += usize::from(inside);
        }
        assert!(touching > 100);
    }
}
