//! Receivers and sources of light: meshes that forward draws, several cameras, cameras whose components are removed.

use bevy::{camera::Viewport, core_pipeline::prepass::DepthPrepass, prelude::*};
use bevy_lean_deferred::prelude::*;
use kit::{
    analytic_light::{Seen, camera, errors, look, see, show, surface},
    analytic_mirrors::{metal, mirror_app},
    lean::{build, change_cameras},
    metrics::pixel_difference,
    own_process::in_own_process,
    scenes::SceneBuilder,
};

use super::scenes::{EYE, SIZE, SMALL, floor, gi, glowing, looking, reflections, spawn_floor};

/// Solids on a metal floor, for one or two cameras side by side.
pub fn two_views(s: &mut SceneBuilder) -> [Entity; 2] {
    spawn_floor(s, metal(0.2), 0.0);
    s.solids();
    s.sun(false);
    [(0, 0.0), (1, 1.5)].map(|(order, x)| {
        let half = SIZE / UVec2::new(2, 1);
        let shown = Camera {
            order,
            viewport: Some(Viewport {
                physical_position: UVec2::new(half.x * order as u32, 0),
                physical_size: half,
                ..default()
            }),
            ..default()
        };
        let from = looking(Vec3::new(x, 1.5, 4.0), 0.5);
        let effects = (gi(), reflections());
        s.camera(from, (LeanDeferred::default(), shown, effects))
    })
}

/// Two cameras side by side share no history: each shows what it shows alone.
#[test]
fn cameras_do_not_share_their_last_frames() {
    in_own_process(|| {
        let picture = |shown: [bool; 2]| {
            let mut headless = build(SIZE, |s| {
                let cameras = two_views(s);
                for (camera, is_active) in cameras.into_iter().zip(shown) {
                    let mut camera = s.world().entity_mut(camera);
                    camera.get_mut::<Camera>().expect("it is one").is_active = is_active;
                }
            });
            headless.settle();
            headless.frames(12);
            headless.capture()
        };
        let both = picture([true, true]);
        for (view, shown) in [[true, false], [false, true]].into_iter().enumerate() {
            let alone = picture(shown);
            let half = SIZE / UVec2::new(2, 1);
            let corner = UVec2::new(half.x * view as u32, 0);
            let rect = URect::from_corners(corner, corner + half);
            let difference = pixel_difference(&alone.crop(rect), &both.crop(rect));
            println!("view {view}: {difference}");
            assert!(difference.psnr > 60.0);
        }
    });
}

/// Meshes that forward draws are light sources on cameras that have their depth.
#[test]
fn forward_meshes_shine_on_cameras_with_a_depth_prepass() {
    in_own_process(|| {
        let sum = |prepass: bool, forward: bool| {
            let (_, seen) = show(SMALL, 12, |s| {
                spawn_floor(s, surface(0.5, 0.0), 0.0);
                let wall = Rectangle::new(3.0, 1.0);
                s.mesh(wall, glowing(forward), Transform::from_xyz(0.0, 0.5, -0.8));
                let camera = camera(s, looking(EYE, 0.3), 0.0, gi());
                if prepass {
                    s.world().entity_mut(camera).insert(DepthPrepass);
                }
            });
            seen.save(&format!("forward_shines_{prepass}_{forward}"), 4.0);
            let near = floor(&seen).filter(|(place, _)| place.z > -0.7);
            near.map(|(_, light)| light).sum::<f32>()
        };
        let lean = sum(true, false);
        let [without, with] = [false, true].map(|prepass| sum(prepass, true));
        println!("lean {lean:.1}, forward {without:.2}, with a prepass {with:.1}");
        assert!(without < 0.01 * lean && (with / lean - 1.0).abs() < 0.02);
    });
}

/// Once the components are removed, the picture is the initial one.
#[test]
fn nothing_is_left_when_they_go() {
    in_own_process(|| {
        let mut headless = build(SMALL, |s| {
            s.solids();
            s.sun(false);
            s.default_camera(LeanDeferred::default());
        });
        headless.settle();
        let before = headless.capture();
        change_cameras(&mut headless, |camera| {
            camera.insert((gi(), reflections()));
        });
        headless.settle();
        headless.frames(4);
        let with = headless.capture();
        change_cameras(&mut headless, |camera| {
            camera.remove::<(LeanScreenSpaceGi, LeanScreenSpaceReflections)>();
        });
        headless.settle();
        let after = headless.capture();
        assert!(before.rgba != with.rgba && before.rgba == after.rgba);
    });
}

/// Debug views show the gathered light, and affect neither the next frame's light nor the picture after them.
#[test]
fn debug_views_show_what_was_found() {
    in_own_process(|| {
        let mut headless = mirror_app(SMALL, 0.0, |camera| {
            camera.insert((gi(), reflections()));
        });
        let picture = see(&mut headless, 6);
        let mut shown = |view: Option<DebugView>| {
            change_cameras(&mut headless, |camera| match view {
                Some(view) => {
                    camera.insert(LeanDebugView::from(view));
                }
                None => {
                    camera.remove::<LeanDebugView>();
                }
            });
            headless.settle();
            headless.frames(4);
            look(&mut headless)
        };
        let near = |seen: &Seen| -> Vec<f32> {
            let near = floor(seen).filter(|(place, _)| place.z > 0.6 && place.z < 2.0);
            near.map(|(_, light)| light).collect()
        };
        let mirrored = near(&picture);
        // The floor of white metal shows all that it reflects.
        let light = near(&shown(Some(DebugView::ReflectionLight)));
        let (off, _) = errors(mirrored.iter().zip(&light).map(|(a, b)| a - b));
        let confidence = near(&shown(Some(DebugView::ReflectionConfidence)));
        // Pixels that reflect light have confidence, and no others.
        let agree = mirrored
            .iter()
            .zip(&confidence)
            .filter(|(light, confidence)| (**light > 0.05) == (**confidence > 0.5));
        let agree = agree.count() as f32 / mirrored.len() as f32;
        let hits = near(&shown(Some(DebugView::ReflectionHit)));
        // The path by way of the mirror is about three metres long.
        let hit = mirrored
            .iter()
            .zip(&hits)
            .filter(|(light, _)| **light > 0.3);
        let hit: Vec<f32> = hit.map(|(_, hit)| 1.0 / hit.max(1e-3) - 1.0).collect();
        let nearer = hit
            .iter()
            .filter(|metres| **metres > 2.0 && **metres < 7.0)
            .count();
        let open = near(&shown(Some(DebugView::GiVisibility)));
        let sent = near(&shown(Some(DebugView::GiLight)));
        let brightest = |of: &[f32]| of.iter().copied().fold(0.0, f32::max);
        println!(
            "light off by {off:.4}; {agree:.3} agree on confidence; {nearer} of {} hits",
            hit.len()
        );
        println!(
            "visible at most {:.3}, sent at most {:.3}",
            brightest(&open),
            brightest(&sent)
        );
        assert!(off < 0.05 && agree > 0.95 && nearer * 10 > hit.len() * 9);
        assert!(brightest(&open) > 0.5 && brightest(&open) <= 1.0 && brightest(&sent) > 0.01);
        let again = shown(None);
        let (off, _) = errors(mirrored.iter().zip(&near(&again)).map(|(a, b)| a - b));
        assert!(off < 1e-3, "the picture is off by {off}");
    });
}

/// A camera that is a child of a scaled entity shows the same: effects are in metres, and normals have unit length.
#[test]
fn scaled_cameras_show_what_others_do() {
    in_own_process(|| {
        let picture = |scale: f32, occlusion: bool| {
            let mut headless = build(SMALL, |s| {
                spawn_floor(s, metal(0.2), 0.0);
                s.solids();
                s.sun(false);
                let from = looking(Vec3::new(1.0, 1.5, 4.0), 0.5).with_scale(Vec3::splat(scale));
                let camera = s.camera(from, LeanDeferred::default());
                let mut camera = s.world().entity_mut(camera);
                if occlusion {
                    camera.insert(LeanScreenSpaceAmbientOcclusion::default());
                } else {
                    camera.insert((gi(), reflections()));
                }
            });
            headless.settle();
            headless.frames(12);
            headless.capture()
        };
        for occlusion in [false, true] {
            let usual = picture(1.0, occlusion);
            for scale in [0.4, 3.0] {
                let difference = pixel_difference(&usual, &picture(scale, occlusion));
                println!("scale {scale}, occlusion {occlusion}: {difference}");
                assert!(difference.psnr > 50.0);
            }
        }
    });
}
