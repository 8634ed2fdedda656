//! The contenders.

use bevy::{
    anti_alias::taa::TemporalAntiAliasing,
    core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass},
    pbr::{ScreenSpaceAmbientOcclusion, ScreenSpaceAmbientOcclusionQualityLevel},
    prelude::*,
};
use bevy_lean_deferred::prelude::*;
use kit::{analytic_mirrors::with_bevys_reflections, motion::yard::Subject};

#[derive(Clone, Copy, PartialEq)]
pub enum Contender {
    Lean,
    /// With the motion vectors that `LeanTaa` has.
    LeanMotion,
    LeanTaa,
    /// `ScreenSpaceReflections` on Bevy's deferred path, or `ScreenSpaceAmbientOcclusion`.
    BevyTaa,
}

impl Contender {
    pub const ALL: [Self; 4] = [Self::Lean, Self::LeanMotion, Self::LeanTaa, Self::BevyTaa];

    pub fn name(self, subject: Subject) -> &'static str {
        match (self, subject) {
            (Self::Lean, _) => "lean",
            (Self::LeanMotion, _) => "lean, motion vectors",
            (Self::LeanTaa, _) => "lean + TAA",
            (Self::BevyTaa, Subject::Reflections) => "Bevy's SSR + TAA",
            (Self::BevyTaa, Subject::DiffuseLight) => "Bevy's SSAO + TAA",
        }
    }

    /// Adds the contender's components to `camera`. `at_best`: those of its truth.
    pub fn dress(self, subject: Subject, at_best: bool, camera: &mut EntityWorldMut) {
        let (quality, resolution) = if at_best {
            (LeanQuality::High, LeanResolution::Full)
        } else {
            default()
        };
        match (self, subject) {
            (Self::BevyTaa, Subject::Reflections) => with_bevys_reflections(camera),
            (Self::BevyTaa, Subject::DiffuseLight) => {
                camera.remove::<LeanDeferred>();
                camera.insert(ScreenSpaceAmbientOcclusion {
                    quality_level: if at_best {
                        ScreenSpaceAmbientOcclusionQualityLevel::Ultra
                    } else {
                        default()
                    },
                    ..default()
                });
            }
            (_, Subject::Reflections) => {
                camera.insert(LeanScreenSpaceReflections {
                    quality,
                    resolution,
                    ..default()
                });
            }
            (_, Subject::DiffuseLight) => {
                camera.insert(LeanScreenSpaceGi {
                    quality,
                    resolution,
                    ..default()
                });
            }
        }
        match self {
            Self::Lean => {}
            Self::LeanMotion => {
                camera.insert((DepthPrepass, MotionVectorPrepass));
            }
            Self::LeanTaa | Self::BevyTaa => {
                camera.insert(TemporalAntiAliasing::default());
            }
        }
    }
}
