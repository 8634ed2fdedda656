//! Difficult mirrors: in other projections, thin ones, of thin things, up to edges.

use bevy::{
    camera::{ScalingMode, SubCameraView},
    math::bounding::{Aabb3d, RayCast3d},
    prelude::*,
};
use bevy_lean_deferred::prelude::*;
use kit::{
    analytic_light::{camera, show, surface},
    analytic_mirrors::{metal, mirror_app, show_mirror},
    headless::Headless,
    lean::change_cameras,
    own_process::in_own_process,
};

use super::scenes::{
    EYE, SIZE, SMALL, light_at, looking, mirror_ray, mirrored, reflections, show_next, spawn_floor,
};

#[test]
fn mirrors_are_exact_in_any_projection() {
    in_own_process(|| {
        let orthographic = |camera: &mut EntityWorldMut| {
            camera.insert(Projection::Orthographic(OrthographicProjection {
                scaling_mode: ScalingMode::FixedVertical {
                    viewport_height: 2.6,
                },
                ..OrthographicProjection::default_3d()
            }));
        };
        // The upper left of a larger picture.
        let off_center = |camera: &mut EntityWorldMut| {
            let mut camera = camera.get_mut::<Camera>().expect("it is one");
            camera.sub_camera_view = Some(SubCameraView {
                full_size: SIZE * 3 / 2,
                offset: Vec2::new(40.0, 70.0),
                size: SIZE,
            });
        };
        let grazing = |camera: &mut EntityWorldMut| {
            camera.insert(looking(Vec3::new(0.0, 0.35, 3.2), 0.3));
        };
        type Dress<'a> = &'a dyn Fn(&mut EntityWorldMut);
        let cases: [(&str, Dress, f32); 3] = [
            ("orthographic", &orthographic, 36.0),
            ("off-centre", &off_center, 36.0),
            ("grazing", &grazing, 30.0),
        ];
        let mut headless = mirror_app(SIZE, 0.0, |camera| {
            camera.insert(reflections());
        });
        for (name, dress, least) in cases {
            change_cameras(&mut headless, |camera| {
                camera.insert(Projection::default());
                let mut shown = camera.get_mut::<Camera>().expect("it is one");
                shown.sub_camera_view = None;
                dress(camera);
            });
            headless.settle();
            headless.frames(6);
            let found = show_mirror(&mut headless);
            found.seen.save(&format!("mirror_{name}"), 1.0);
            println!(
                "{name}: {:.1} dB, without outlines {:.1} dB, {:.2} in the picture",
                found.everywhere.psnr(),
                found.inside.psnr(),
                found.share
            );
            assert!(found.share > 0.5 && found.inside.psnr() > least);
        }
    });
}

/// In the mirror a thin pole hides only what is behind it, though its thickness is unknown.
#[test]
fn a_thin_pole_hides_no_more_than_itself() {
    in_own_process(|| {
        const POLE: Vec3 = Vec3::new(0.015, 0.5, 0.015);
        const WALL_Z: f32 = -4.0;
        let middle = Vec3::Y * POLE.y;
        let eye = Vec3::new(0.0, 1.0, 3.0);
        let (mut headless, seen) = show(SIZE, 6, |s| {
            let wall = Rectangle::new(6.0, 3.0);
            s.mesh(
                wall,
                surface(0.0, 1.0),
                Transform::from_xyz(0.0, 1.5, WALL_Z),
            );
            let pole = Cuboid::from_size(2.0 * POLE);
            s.mesh(pole, surface(0.0, 0.0), Transform::from_translation(middle));
            spawn_floor(s, metal(0.0), 0.0);
            camera(s, looking(eye, 0.4), 0.0, reflections());
        });
        seen.save("pole", 1.0);
        // Pixels that are dark, and pixels in which the pole truly hides the wall.
        let bounds = Aabb3d::new(middle, POLE);
        let (mut dark, mut hidden) = (0, 0);
        for (_, place, light) in seen.on_plane(Vec3::ZERO, Vec3::Y) {
            // Excludes the pole itself and the floor beyond it.
            let Some(ray) = mirror_ray(eye, place) else {
                continue;
            };
            let at = ray.get_point((WALL_Z - place.z) / ray.direction.z);
            let is_on_wall = at.y > 0.1 && at.y < 2.9 && at.x.abs() < 2.8;
            if place.z <= POLE.z || !is_on_wall || light_at(&mut headless, &seen, at).is_none() {
                continue;
            }
            let cast = RayCast3d::from_ray(ray, 100.0);
            hidden += i32::from(cast.aabb_intersection_at(&bounds).is_some());
            dark += i32::from(light < 0.5);
        }
        println!("{hidden} pixels mirror the pole, {dark} are dark");
        assert!(hidden > 100 && (dark - hidden).abs() < hidden / 4);
    });
}

/// The image of a wall that the camera looks along, whose depth steps far from pixel to pixel, is whole: rays do not pass between its
/// pixels.
#[test]
fn walls_at_grazing_angles_are_reflected() {
    in_own_process(|| {
        const WALL_X: f32 = 1.0;
        const HEIGHT: f32 = 3.0;
        /// Ends of the wall.
        const ENDS: (f32, f32) = (-36.0, 4.0);
        let (mut headless, seen) = show(SIZE, 8, |s| {
            let plane = Plane3d::default().mesh().size(80.0, 80.0);
            s.mesh(plane, metal(0.0), Transform::default());
            let wall = Rectangle::new(ENDS.1 - ENDS.0, HEIGHT);
            let middle = Vec3::new(WALL_X, 0.5 * HEIGHT, 0.5 * (ENDS.0 + ENDS.1));
            let facing = Transform::from_translation(middle).looking_to(Vec3::X, Vec3::Y);
            s.mesh(wall, surface(0.0, 1.0), facing);
            camera(s, looking(EYE, 0.6), 0.0, reflections());
        });
        seen.save("grazing_wall", 0.8);
        let (mut dark, mut count) = (0, 0);
        for (_, place, light) in seen.on_plane(Vec3::ZERO, Vec3::Y) {
            let Some(ray) = mirror_ray(EYE, place) else {
                continue;
            };
            let at = ray.get_point((WALL_X - place.x) / ray.direction.x);
            // Between 7 and 2 degrees.
            let is_grazing = (-28.0..-5.5).contains(&at.z) && (0.1..0.9 * HEIGHT).contains(&at.y);
            if is_grazing && light_at(&mut headless, &seen, at).is_some() {
                dark += i32::from(light < 0.5);
                count += 1;
            }
        }
        println!("{dark} of {count} pixels are dark");
        assert!(count > 1000 && dark < 6);
    });
}

/// Everything above a mirror is reflected in it, up to its edge.
#[test]
fn mirrored_edges_have_no_gaps() {
    in_own_process(|| {
        const WALL_Z: f32 = -0.8;
        const FLOOR: Vec3 = Vec3::new(0.0, -0.14, 0.0);
        let (_, seen) = show(SMALL, 8, |s| {
            spawn_floor(s, metal(0.0), FLOOR.y);
            s.mesh(
                Rectangle::new(3.0, 1.0),
                surface(0.0, 1.0),
                Transform::from_xyz(0.0, 0.6, WALL_Z),
            );
            camera(s, looking(EYE, 0.2), 0.3, reflections());
        });
        seen.save("edge", 0.8);
        let (mut dark, mut count) = (0, 0);
        for (_, place, light) in seen.on_plane(FLOOR, Vec3::Y) {
            let direction = mirrored(EYE, place);
            let met = place + direction * (WALL_Z - place.z) / direction.z;
            if place.z > WALL_Z && met.x.abs() < 1.3 && met.y > 0.11 && met.y < 1.0 {
                dark += i32::from(light < 0.8);
                count += 1;
            }
        }
        println!("{dark} of {count} pixels are dark");
        assert!(count > 1000 && dark < 4);
    });
}

/// Texels have one ray. A mirror that is thinner than they are has light of all of them, wherever their first pixels are.
#[test]
fn thin_mirrors_reflect() {
    in_own_process(|| {
        // 1.5 pixels high, in the middle.
        const RAIL: Vec3 = Vec3::new(0.9, 0.0, 0.06);
        let rail = Transform::from_xyz(0.0, 0.5, 0.0).with_rotation(Quat::from_rotation_y(0.15));
        let mut headless = Headless::new(SMALL);
        for (quality, resolution) in [
            (LeanQuality::Medium, LeanResolution::Full),
            (LeanQuality::Medium, LeanResolution::Half),
            (LeanQuality::Low, LeanResolution::Half),
        ] {
            let seen = show_next(&mut headless, 6, |s| {
                let wall = Rectangle::new(8.0, 4.0);
                s.mesh(wall, surface(0.0, 1.0), Transform::from_xyz(0.0, 2.0, -2.0));
                spawn_floor(s, surface(0.0, 0.0), 0.0);
                let plane = Plane3d::default().mesh().size(2.0 * RAIL.x, 2.0 * RAIL.z);
                s.mesh(plane, metal(0.0), rail);
                let effect = LeanScreenSpaceReflections {
                    quality,
                    resolution,
                    ..reflections()
                };
                camera(s, looking(EYE, 0.5), 0.0, effect);
            });
            seen.save(&format!("rail_{quality:?}_{resolution:?}"), 1.0);
            let back = rail.compute_affine().inverse();
            let on_rail = seen
                .on_plane(rail.translation, Vec3::Y)
                .filter(|(_, place, _)| {
                    let at = back.transform_point3(*place).abs();
                    at.x < RAIL.x && at.z < RAIL.z
                });
            let light: Vec<f32> = on_rail.map(|(_, _, light)| light).collect();
            let share = light.iter().sum::<f32>() / light.len() as f32;
            println!(
                "{quality:?}, {resolution:?}: {share:.3} of the light of {} pixels",
                light.len()
            );
            assert!(light.len() > 100 && share > 0.6 && share < 1.02);
        }
    });
}
