//! Reflections beside what mirrors show.

use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;
use kit::{
    known_mirrors::{mirror, rough_floor, sent_on, with_bevys_reflections},
    own_process::in_own_process,
};

const SIZE: UVec2 = UVec2::new(480, 360);

fn reflections(resolution: ScreenSpaceResolution) -> LeanScreenSpaceReflections {
    LeanScreenSpaceReflections {
        resolution,
        edge_fade: 0.0,
        ..default()
    }
}

#[test]
fn a_mirror_shows_what_is_above_it() {
    in_own_process(|| {
        for resolution in ScreenSpaceResolution::ALL {
            let found = mirror(SIZE, |camera| {
                camera.insert(reflections(resolution));
            });
            found.seen.save(&format!("mirror_{resolution:?}"), 1.0);
            println!(
                "{resolution:?}: {:.1} dB, without outlines {:.1} dB, {:.2} in the picture",
                found.everywhere.psnr(),
                found.inside.psnr(),
                found.share
            );
            assert!(found.inside.psnr() > 40.0);
        }
        let found = mirror(SIZE, with_bevys_reflections);
        found.seen.save("mirror_bevy", 1.0);
        println!(
            "Bevy: {:.1} dB, {:.1}",
            found.everywhere.psnr(),
            found.inside.psnr()
        );
    });
}

#[test]
fn a_rough_floor_shows_the_lobe_of_a_quad() {
    in_own_process(|| {
        for roughness in [0.1, 0.3, 0.5] {
            for resolution in ScreenSpaceResolution::ALL {
                let (seen, found) = rough_floor(SIZE, roughness, |camera| {
                    camera.insert(reflections(resolution));
                });
                seen.save(&format!("rough_{roughness}_{resolution:?}"), 1.0);
                println!("{roughness}, {resolution:?}: {found:.4?}");
            }
            let (seen, found) = rough_floor(SIZE, roughness, with_bevys_reflections);
            seen.save(&format!("rough_{roughness}_bevy"), 1.0);
            println!("{roughness}, Bevy: {found:.4?}");
        }
        println!("{}", sent_on(0.5, 0.5));
    });
}
