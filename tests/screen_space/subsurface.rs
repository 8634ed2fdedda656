//! Light that scatters beneath surfaces, beside what its profile says.

use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;
use kit::{
    known_slabs::{SKIN, edge},
    own_process::in_own_process,
};

const SIZE: UVec2 = UVec2::new(320, 192);
const WHITE: LinearRgba = LinearRgba::WHITE;

use SubsurfaceScatteringQuality::{High, Low, Medium, Separable};

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
            for quality in [Separable, Low, Medium, High] {
                let found = edge(SIZE, color, path, with(quality));
                println!("{name}, {quality:?}: {found:.4?}");
                // Of few samples in one frame.
                let most = 0.12;
                all_right &= found.iter().all(|e| e.rmse < most && e.bias.abs() < 0.01);
            }
        }
        assert!(all_right);
    });
}
