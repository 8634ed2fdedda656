//! What is compared.

use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;
use kit::known_mirrors::with_bevys_reflections;

#[derive(Clone, Copy, PartialEq)]
pub enum Contender {
    Plain,
    Occlusion,
    Gi(ScreenSpaceGiQuality, ScreenSpaceResolution),
    Reflections(ScreenSpaceReflectionsQuality, ScreenSpaceResolution),
    /// On Bevy's deferred path.
    BevysReflections,
}

/// What an effect finds.
#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    DiffuseLight,
    Reflections,
}

impl Contender {
    pub fn all() -> Vec<Self> {
        use ScreenSpaceResolution::{Full, Half};
        let gi = [Half, Full].into_iter().flat_map(|resolution| {
            ScreenSpaceGiQuality::ALL.map(|quality| Self::Gi(quality, resolution))
        });
        let reflections = [Half, Full].into_iter().flat_map(|resolution| {
            let qualities = ScreenSpaceReflectionsQuality::ALL;
            qualities.map(|quality| Self::Reflections(quality, resolution))
        });
        [Self::Plain, Self::Occlusion]
            .into_iter()
            .chain(gi)
            .chain(reflections)
            .chain([Self::BevysReflections])
            .collect()
    }

    pub fn is_plain(self) -> bool {
        self == Self::Plain
    }

    /// The table that it stands in; `None`: in both.
    pub fn kind(self) -> Option<Kind> {
        match self {
            Self::Plain => None,
            Self::Occlusion | Self::Gi(..) => Some(Kind::DiffuseLight),
            Self::Reflections(..) | Self::BevysReflections => Some(Kind::Reflections),
        }
    }

    pub fn name(self) -> String {
        match self {
            Self::Plain => "none".into(),
            Self::Occlusion => "ambient occlusion, Medium".into(),
            Self::Gi(quality, resolution) => format!("GI, {quality:?}, {resolution:?}"),
            Self::Reflections(quality, resolution) => {
                format!("reflections, {quality:?}, {resolution:?}")
            }
            Self::BevysReflections => "Bevy's reflections".into(),
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
            Self::Reflections(..) => &[
                "lean_deferred/screen_space/history",
                "lean_deferred/reflections/cells",
                "lean_deferred/reflections/trace",
                "lean_deferred/reflections/resolve",
            ],
            Self::BevysReflections => &["ssr"],
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
                    ScreenSpaceResolution::Full => 1.0,
                    ScreenSpaceResolution::Half => 0.25,
                };
                let levels = 1.0 + 0.25 + 0.0625 + 0.015_625;
                4.0 + 4.0 + texels * 8.0 * (2.0 * levels + 1.0 + 2.0 + 2.0)
            }
            // The picture is read, and written with its levels; they are read where rays end; cells are 8 bytes, rays 12; what is
            // found is written and read.
            Self::Reflections(_, resolution) => {
                let texels = match resolution {
                    ScreenSpaceResolution::Full => 1.0,
                    ScreenSpaceResolution::Half => 0.25,
                };
                let levels = 1.0 + 0.25 + 0.0625 + 0.015_625;
                let cells = 0.0625 + 0.003_906;
                8.0 + 8.0 * levels + 8.0 + 2.0 * 8.0 * cells + 2.0 * 12.0 * texels + 2.0 * 8.0
            }
            // The picture is read, where it is and where rays end, and written; so is the G-buffer.
            Self::BevysReflections => 3.0 * 8.0 + 16.0,
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
            Self::Reflections(quality, resolution) => {
                camera.insert(LeanScreenSpaceReflections {
                    quality,
                    resolution,
                    ..default()
                });
            }
            Self::BevysReflections => with_bevys_reflections(camera),
        }
    }
}
