//! What is compared.

use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;

#[derive(Clone, Copy, PartialEq)]
pub enum Contender {
    Plain,
    Occlusion,
    Gi(ScreenSpaceGiQuality, ScreenSpaceGiResolution),
}

impl Contender {
    pub fn all() -> Vec<Self> {
        use ScreenSpaceGiResolution::{Full, Half};
        let gi = [Half, Full].into_iter().flat_map(|resolution| {
            ScreenSpaceGiQuality::ALL.map(|quality| Self::Gi(quality, resolution))
        });
        [Self::Plain, Self::Occlusion]
            .into_iter()
            .chain(gi)
            .collect()
    }

    pub fn is_plain(self) -> bool {
        self == Self::Plain
    }

    pub fn name(self) -> String {
        match self {
            Self::Plain => "none".into(),
            Self::Occlusion => "ambient occlusion, Medium".into(),
            Self::Gi(quality, resolution) => format!("GI, {quality:?}, {resolution:?}"),
        }
    }

    /// The passes that only the effect has.
    pub fn spans(self) -> &'static [&'static str] {
        match self {
            Self::Plain => &[],
            Self::Occlusion => &["lean_deferred/ambient_occlusion/gather"],
            Self::Gi(..) => &[
                "lean_deferred/diffuse_gi/levels",
                "lean_deferred/diffuse_gi/gather",
                "lean_deferred/diffuse_gi/filter",
            ],
        }
    }

    /// Bytes a pixel that are moved with the effect and not without: each texture once written and once read, but for depth and
    /// normals.
    pub fn bytes(self) -> f64 {
        match self {
            Self::Plain => 0.0,
            Self::Occlusion => 2.0,
            // Light is written and read as words; a level's texel is 8 bytes, and the last frame's first level is read too; what is
            // gathered and what is filtered are 8 bytes a texel each.
            Self::Gi(_, resolution) => {
                let texels = match resolution {
                    ScreenSpaceGiResolution::Full => 1.0,
                    ScreenSpaceGiResolution::Half => 0.25,
                };
                let levels = 1.0 + 0.25 + 0.0625 + 0.015_625;
                4.0 + 4.0 + texels * 8.0 * (2.0 * levels + 1.0 + 2.0 + 2.0)
            }
        }
    }

    /// Makes `camera` this contender's.
    pub fn dress(self, camera: &mut EntityWorldMut) {
        match self {
            Self::Plain => {}
            Self::Occlusion => {
                camera.insert(LeanAmbientOcclusion::default());
            }
            Self::Gi(quality, resolution) => {
                camera.insert(LeanScreenSpaceGi {
                    quality,
                    resolution,
                    ..default()
                });
            }
        }
    }
}
