//! Reflections against the true contents of mirrors.

use bevy::{core_pipeline::prepass::DepthPrepass, prelude::*};
use bevy_lean_deferred::prelude::*;
use kit::{
    analytic_light::{camera, surface},
    analytic_mirrors::{
        GlowingQuad, metal, mirror_app, rough_floor, rough_floor_under, show_mirror,
        with_bevys_reflections,
    },
    hdr::light,
    headless::Headless,
    lean::change_cameras,
    own_process::in_own_process,
    scenes::SceneBuilder,
};

use super::scenes::{
    self, EYE, SIZE, SMALL, TALL, floor, floor_light, glowing, looking, range, reflections,
    show_next, spawn_floor,
};

fn at_resolution(resolution: LeanResolution) -> LeanScreenSpaceReflections {
    LeanScreenSpaceReflections {
        resolution,
        ..reflections()
    }
}

#[test]
fn a_mirror_shows_what_is_above_it() {
    in_own_process(|| {
        let mut headless = mirror_app(SIZE, 0.0, |_| ());
        for (resolution, least) in [(LeanResolution::Half, 60.0), (LeanResolution::Full, 55.0)] {
            change_cameras(&mut headless, |camera| {
                camera.insert(at_resolution(resolution));
            });
            headless.settle();
            headless.frames(6);
            let found = show_mirror(&mut headless);
            found.seen.save(&format!("mirror_{resolution:?}"), 1.0);
            println!(
                "{resolution:?}: {:.1} dB, without outlines {:.1} dB, {:.2} in the picture",
                found.everywhere.psnr(),
                found.inside.psnr(),
                found.share
            );
            assert!(found.inside.psnr() > least && found.everywhere.psnr() > 28.0);
        }
    });
}

#[test]
fn a_rough_floor_shows_the_lobe_of_a_quad() {
    in_own_process(|| show_lobe_of_a_quad([0.3]));
}

#[test]
#[ignore = "nightly: further roughness"]
fn further_rough_floors_show_the_lobe_of_a_quad() {
    in_own_process(|| show_lobe_of_a_quad([0.1, 0.5]));
}

fn show_lobe_of_a_quad(roughness: impl IntoIterator<Item = f32>) {
    for roughness in roughness {
        let (seen, bevys) = rough_floor(SIZE, roughness, with_bevys_reflections);
        seen.save(&format!("rough_{roughness}_bevy"), 1.0);
        for resolution in LeanResolution::ALL {
            let (seen, found) = rough_floor(SIZE, roughness, |camera| {
                camera.insert(at_resolution(resolution));
            });
            seen.save(&format!("rough_{roughness}_{resolution:?}"), 1.0);
            println!("{roughness}, {resolution:?}: {found:.4?}, Bevy's {bevys:.4?}");
            assert!(found.rmse < 0.5 * bevys.rmse);
        }
    }
}

#[test]
fn a_rough_floor_shows_the_lobe_of_a_bulb() {
    in_own_process(|| show_lobe_of_a_bulb([(0.21, 0.087)]));
}

#[test]
#[ignore = "nightly: further roughness"]
fn further_rough_floors_show_the_lobe_of_a_bulb() {
    in_own_process(|| {
        show_lobe_of_a_bulb([
            (0.15, 0.045),
            (0.2, 0.035),
            (0.25, 0.072),
            (0.3, 0.055),
            (0.4, 0.042),
        ]);
    });
}

/// Around a bulb's mirror image a floor shows the lobe, and no square of the rays that hit the bulb. Takes the floor's roughness and the
/// largest error.
fn show_lobe_of_a_bulb(floors: impl IntoIterator<Item = (f32, f32)>) {
    let bulb = GlowingQuad {
        size: Vec2::splat(0.1),
        height: 0.35,
        light: 8.0,
    };
    for (roughness, most) in floors {
        let (seen, found) = rough_floor_under(bulb, SIZE, roughness, |camera| {
            camera.insert(LeanScreenSpaceReflections {
                // Rays that pass behind it must miss it.
                thickness: 0.02,
                ..reflections()
            });
        });
        seen.save(&format!("bulb_{roughness}"), 1.0);
        println!("{roughness}: {found:.4?}");
        assert!(found.rmse < most);
    }
}

/// In pictures of this many rows a ray serves 4×4 pixels.
#[test]
#[ignore = "nightly: another size; `settings` has its texels, and shows that they are bounded"]
fn large_pictures_need_fewer_rays() {
    in_own_process(|| {
        assert_eq!(reflections().texel_side(TALL.y), 4);
        let mut headless = mirror_app(TALL, 0.0, |camera| {
            camera.insert(reflections());
        });
        // Frames of this size are slow: those that settling takes are enough.
        headless.settle();
        let found = show_mirror(&mut headless);
        found.seen.save("mirror_tall", 1.0);
        println!(
            "{:.1} dB, without outlines {:.1} dB",
            found.everywhere.psnr(),
            found.inside.psnr()
        );
        assert!(found.inside.psnr() > 43.0 && found.everywhere.psnr() > 34.0);
        for (roughness, most) in [(0.21, 0.045), (0.3, 0.06), (0.5, 0.055)] {
            let (seen, found) = rough_floor(TALL, roughness, |camera| {
                camera.insert(reflections());
            });
            seen.save(&format!("rough_tall_{roughness}"), 1.0);
            println!("{roughness}: {found:.4?}");
            assert!(found.rmse < most);
        }
    });
}

/// A metal floor between things that glow with `glow`, under a sky of `sky`.
fn courtyard(s: &mut SceneBuilder, roughness: f32, glow: f32, sky: f32) -> Entity {
    scenes::courtyard(s, metal(roughness), surface(0.0, glow), sky, reflections())
}

#[test]
fn a_furnace_is_even() {
    in_own_process(|| {
        let mut headless = Headless::new(SMALL);
        for roughness in [0.0, 0.1, 0.3, 0.5, 0.7, 1.0] {
            let seen = show_next(&mut headless, 8, |s| {
                courtyard(s, roughness, 1.0, 1.0);
            });
            seen.save(&format!("furnace_{roughness}"), 0.5);
            let (least, most) = range(&floor_light(&seen));
            println!("roughness {roughness}: {least:.4} to {most:.4}");
            assert!(least > 0.99 && most < 1.01);
        }
    });
}

/// The environment continues past the end of reflections: nothing is brighter than both, or darker.
#[test]
fn there_are_no_seams() {
    in_own_process(|| {
        let mut headless = Headless::new(SMALL);
        for roughness in [0.0, 0.3, 0.7] {
            let seen = show_next(&mut headless, 8, |s| {
                let camera = courtyard(s, roughness, 1.0, 0.4);
                s.world()
                    .entity_mut(camera)
                    .insert(LeanScreenSpaceReflections::default());
            });
            seen.save(&format!("seams_{roughness}"), 0.7);
            let (least, most) = range(&floor_light(&seen));
            println!("roughness {roughness}: {least:.4} to {most:.4}");
            assert!(least > 0.39 && most < 1.01 && most > 0.9);
        }
    });
}

#[test]
fn rays_of_rough_floors_miss_no_walls() {
    in_own_process(|| miss_no_walls([LeanQuality::Low]));
}

#[test]
#[ignore = "nightly: further qualities"]
fn rays_of_further_qualities_miss_no_walls() {
    in_own_process(|| {
        miss_no_walls([LeanQuality::Medium, LeanQuality::High, LeanQuality::Ultra]);
    });
}

/// Rays that march in segments hit walls at an angle to the picture, however thin these are: in an empty room thickness does not matter.
fn miss_no_walls(qualities: impl IntoIterator<Item = LeanQuality>) {
    let mut headless = Headless::new(SIZE);
    let mut sum = |quality, roughness, thickness| {
        let seen = show_next(&mut headless, 4, |s| {
            spawn_floor(s, metal(roughness), 0.0);
            let back = Transform::from_xyz(0.0, 1.5, -2.0);
            s.mesh(Cuboid::new(3.4, 3.0, 0.2), surface(0.0, 1.0), back);
            for x in [-1.6, 1.6] {
                let side = Transform::from_xyz(x, 1.5, 0.0);
                s.mesh(Cuboid::new(0.2, 3.0, 4.0), surface(0.0, 1.0), side);
            }
            let effect = LeanScreenSpaceReflections {
                quality,
                thickness,
                ..reflections()
            };
            camera(s, looking(EYE, 0.5), 0.0, effect);
        });
        seen.save(&format!("room_{quality:?}_{roughness}_{thickness}"), 1.0);
        let in_room = floor(&seen).filter(|(place, _)| place.x.abs() < 1.4 && place.z > -1.8);
        in_room.map(|(_, light)| light).sum::<f32>()
    };
    for quality in qualities {
        for roughness in [0.3, 0.6] {
            let [thin, thick] = [0.05, 100.0].map(|metres| sum(quality, roughness, metres));
            println!("{quality:?}, roughness {roughness}: {:.4}", thin / thick);
            assert!(thick > 0.0 && thin / thick > 0.99);
        }
    }
}

/// Nothing flickers: without jitter two frames are equal.
#[test]
fn what_is_still_stays() {
    in_own_process(|| {
        let mut headless = Headless::new(SMALL);
        for roughness in [0.0, 0.4] {
            // Reflections of reflections take a few frames.
            show_next(&mut headless, 30, |s| {
                courtyard(s, roughness, 1.0, 0.4);
            });
            let [first, second] = [(); 2].map(|()| light(&mut headless));
            let pairs = first
                .texels
                .iter()
                .flatten()
                .zip(second.texels.iter().flatten());
            let most = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            println!("roughness {roughness}: at most {most:.5} from frame to frame");
            assert!(most < 2e-3, "roughness {roughness}: {most}");
        }
    });
}

/// Meshes that forward draws are reflected on cameras that have their depth.
#[test]
fn forward_meshes_are_mirrored_by_cameras_with_a_depth_prepass() {
    in_own_process(|| {
        let mut headless = Headless::new(SMALL);
        let mut sum = |prepass: bool, forward: bool| {
            let seen = show_next(&mut headless, 8, |s| {
                let camera = courtyard(s, 0.0, 0.0, 0.0);
                if prepass {
                    s.world().entity_mut(camera).insert(DepthPrepass);
                }
                let wall = Rectangle::new(2.0, 0.8);
                s.mesh(wall, glowing(forward), Transform::from_xyz(0.0, 0.4, 0.8));
            });
            seen.save(&format!("forward_{prepass}_{forward}"), 1.0);
            // In front of the wall.
            let near = floor(&seen).filter(|(place, _)| place.z > 0.9);
            near.map(|(_, light)| light).sum::<f32>()
        };
        let lean = sum(false, false);
        let [without, with] = [false, true].map(|prepass| sum(prepass, true));
        println!("lean {lean:.1}, forward {without:.1}, with a prepass {with:.1}");
        assert!(without < 0.2 * lean && (with / lean - 1.0).abs() < 0.02);
    });
}
