//! Light that scatters beneath surfaces, beside what its profile says.

use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;
use kit::{
    known_slabs::{SKIN, edge},
    own_process::in_own_process,
};

const SIZE: UVec2 = UVec2::new(320, 192);
const WHITE: LinearRgba = LinearRgba::WHITE;

use SubsurfaceScatteringQuality::{High, Low};

fn with(quality: SubsurfaceScatteringQuality) -> LeanSubsurfaceScattering {
    LeanSubsurfaceScattering {
        quality,
        ..default()
    }
}

#[test]
fn light_leaves_beside_an_edge_as_the_profile_says() {
    in_own_process(|| {
        let mut all_right = true;
        for (name, color, path) in [("white", WHITE, 0.08), ("skin", SKIN, 0.2)] {
            for quality in [Low, High] {
                let found = edge(SIZE, color, path, with(quality));
                println!("{name}, {quality:?}: {found:.4?}");
                all_right &= found.iter().all(|e| e.rmse < 0.01 && e.bias.abs() < 0.002);
            }
        }
        assert!(all_right);
    });
}
