//! The contenders.

use bevy::{
    pbr::{ScreenSpaceAmbientOcclusion, ScreenSpaceAmbientOcclusionQualityLevel as BevyQuality},
    prelude::*,
};
use bevy_lean_deferred::{
    effects::ambient_occlusion::{
        LeanScreenSpaceAmbientOcclusionAdvanced as Advanced, OcclusionFilter, OcclusionKernel,
        OcclusionNormals,
    },
    prelude::*,
};
use figures::benches::ambient_occlusion::Bytes;

/// A camera with ambient occlusion of some kind, or without any.
#[derive(Clone)]
pub struct Contender {
    pub name: String,
    /// Renders with this crate rather than with Bevy's forward renderer.
    pub lean: bool,
    pub occlusion: Option<Kind>,
}

#[derive(Clone, Copy)]
pub enum Kind {
    Lean(LeanScreenSpaceAmbientOcclusion),
    Bevy(BevyQuality),
    /// The samples of the crate's default, but stored in the alpha of a 4 × FP16 target, blurred with 9 fetches and
    /// merged in a shader.
    Naive,
}

impl Contender {
    pub fn all() -> Vec<Self> {
        let of = |name: String, lean, kind| Self {
            name,
            lean,
            occlusion: kind,
        };
        let mut all = vec![of("lean camera, none".into(), true, None)];
        all.extend(LeanQuality::ALL.map(|quality| {
            let settings = LeanScreenSpaceAmbientOcclusion {
                quality,
                ..default()
            };
            of(
                format!("{quality:?}, indirect"),
                true,
                Some(Kind::Lean(settings)),
            )
        }));
        let more = |name: &str, lean, settings| of(name.into(), lean, Some(Kind::Lean(settings)));
        let base = LeanScreenSpaceAmbientOcclusion::default();
        all.extend([
            more(
                "Medium, indirect, geometric normals",
                true,
                LeanScreenSpaceAmbientOcclusion {
                    advanced: Advanced {
                        normals: OcclusionNormals::Geometric,
                        ..default()
                    },
                    ..base
                },
            ),
            more(
                "Medium, indirect, radius 2 m",
                true,
                LeanScreenSpaceAmbientOcclusion {
                    radius: 2.0,
                    ..base
                },
            ),
            more(
                "Medium, indirect, binomial",
                true,
                LeanScreenSpaceAmbientOcclusion {
                    advanced: Advanced {
                        edge_aware: false,
                        ..default()
                    },
                    ..base
                },
            ),
            more(
                "Medium, indirect, wide",
                true,
                LeanScreenSpaceAmbientOcclusion {
                    advanced: Advanced {
                        filter: OcclusionFilter::Wide,
                        ..default()
                    },
                    ..base
                },
            ),
            more(
                "Medium, indirect, half",
                true,
                LeanScreenSpaceAmbientOcclusion {
                    resolution: LeanResolution::Half,
                    ..base
                },
            ),
            more(
                "HDAO, indirect",
                true,
                LeanScreenSpaceAmbientOcclusion {
                    advanced: Advanced {
                        kernel: OcclusionKernel::Hdao,
                        ..default()
                    },
                    ..base
                },
            ),
            of("forward camera, none".into(), false, None),
            more("Medium, blend", false, base),
            more(
                "Medium, blend, half",
                false,
                LeanScreenSpaceAmbientOcclusion {
                    resolution: LeanResolution::Half,
                    ..base
                },
            ),
            of("naive".into(), false, Some(Kind::Naive)),
        ]);
        let bevy = [
            BevyQuality::Low,
            BevyQuality::Medium,
            BevyQuality::High,
            BevyQuality::Ultra,
        ];
        all.extend(bevy.map(|quality| {
            of(
                format!("Bevy {quality:?}"),
                false,
                Some(Kind::Bevy(quality)),
            )
        }));
        all
    }

    /// Adds the contender's components to `camera`. With `shows`, the picture is the occlusion alone, where the crate
    /// supports it.
    pub fn dress(&self, camera: &mut EntityWorldMut, shows: bool) {
        if self.lean {
            camera.insert(LeanDeferred::default());
        }
        match self.occlusion {
            None => {}
            Some(Kind::Lean(settings)) => {
                camera.insert(settings);
                if shows {
                    camera.insert(LeanDebugView::from(DebugView::AmbientOcclusion));
                }
            }
            Some(Kind::Bevy(quality_level)) => {
                camera.insert(ScreenSpaceAmbientOcclusion {
                    quality_level,
                    ..default()
                });
            }
            Some(Kind::Naive) => {
                camera.insert((
                    super::naive::NaiveOcclusion { shows },
                    // For its depth texture and its texture usages.
                    bevy::core_pipeline::prepass::DepthPrepass,
                ));
            }
        }
    }

    /// Names of the GPU spans that only occlusion has.
    pub fn spans(&self) -> &'static [&'static str] {
        match self.occlusion {
            None => &[],
            // The lighting pass merges.
            Some(Kind::Lean(_)) if self.lean => &["lean_deferred/effects/ambient_occlusion/gather"],
            Some(Kind::Lean(_)) => &[
                "lean_deferred/effects/ambient_occlusion/gather",
                "lean_deferred/effects/ambient_occlusion/merge",
            ],
            Some(Kind::Bevy(_)) => &["ssao"],
            Some(Kind::Naive) => &["bench/naive/gather", "bench/naive/merge"],
        }
    }

    /// Bytes per pixel, counted from the formats. The blend reads and writes the picture at the share `occluded` of the
    /// pixels, which it does not discard.
    pub fn bytes(&self, occluded: f64) -> Bytes {
        let picture = 8.0;
        match self.occlusion {
            None => Bytes {
                compulsory: 0.0,
                compulsory_with_depth: 0.0,
                fetched: 0.0,
            },
            Some(Kind::Lean(settings)) => {
                let half = settings.resolution == LeanResolution::Half;
                let share = if half { 0.25 } else { 1.0 };
                let wide = settings.has_wide_pattern();
                let shading = self.lean
                    && settings.advanced.normals == OcclusionNormals::Shading
                    && settings.advanced.kernel == OcclusionKernel::Hbao;
                let samples = match settings.advanced.kernel {
                    // The pixel, eight neighbours for its normal, and the steps.
                    OcclusionKernel::Hbao => {
                        let (slices, steps) = settings.samples();
                        f64::from(9 + slices * steps * 2)
                    }
                    OcclusionKernel::Hdao => 1.0 + 32.0,
                };
                let normal = if shading { 4.0 } else { 0.0 };
                // A texel of four bytes for every fourth pixel.
                let sparse_depth = match settings.advanced.kernel {
                    OcclusionKernel::Hbao => 1.0,
                    OcclusionKernel::Hdao => 0.0,
                };
                // Lighting reads the depth anyway.
                let blend = if self.lean {
                    0.0
                } else {
                    occluded * 2.0 * picture
                };
                let merge_depth = if self.lean { 0.0 } else { 4.0 };
                // Plus the depths that give the plane of the pixel.
                let filter_depths = match (settings.advanced.edge_aware, half, wide) {
                    (false, ..) => 0.0,
                    (true, true, _) => 16.0 + 4.0,
                    (true, false, false) => 12.0 + 4.0,
                    (true, false, true) => 24.0 + 4.0,
                };
                let filter_texels = if wide { 36.0 } else { 16.0 };
                // A texel of occlusion has one byte. Both textures are once written and once read.
                let own = share * 2.0 + sparse_depth * 2.0 + blend;
                Bytes {
                    compulsory: own,
                    // The pass that writes sparse depth reads a fourth of the depths, and all of their cache lines.
                    compulsory_with_depth: own + share * (4.0 + normal) + 4.0 * sparse_depth + 4.0,
                    fetched: share * (1.0 + 4.0 * samples + normal)
                        + 2.0 * sparse_depth
                        + filter_texels
                        + 4.0 * filter_depths
                        + merge_depth
                        + blend,
                }
            }
            // Depth into five levels (R16Float, 1.33 texels per pixel), gather (R16Float, and packed depth differences,
            // R32Uint), denoise (R16Float), and the read by the material's shader.
            Some(Kind::Bevy(quality)) => {
                let (slices, steps) = match quality {
                    BevyQuality::Low => (1.0, 2.0),
                    BevyQuality::Medium => (2.0, 2.0),
                    BevyQuality::High => (3.0, 3.0),
                    _ => (9.0, 3.0),
                };
                let levels = 2.0 * 1.33;
                let own = 2.0 * levels + 2.0 * (2.0 + 4.0) + 2.0 * 2.0;
                // The normal prepass writes 4 bytes, and its depth is copied.
                let prepass = 4.0 + 4.0 + 4.0 + 4.0;
                Bytes {
                    compulsory: own,
                    compulsory_with_depth: own + 4.0 + prepass,
                    fetched: 4.0 + levels // preprocess
                        + 2.0 * (4.0 + 4.0 * 2.0) + 4.0 + 2.0 * slices * steps * 2.0 + 2.0 + 4.0
                        + 16.0 * 2.0 + 16.0 * 4.0 + 2.0 // denoise, with gathers
                        + 2.0
                        + prepass,
                }
            }
            Some(Kind::Naive) => {
                let (slices, steps) = LeanScreenSpaceAmbientOcclusion::default().samples();
                let samples = f64::from(9 + slices * steps * 2);
                Bytes {
                    compulsory: 8.0 + 8.0 + 2.0 * picture,
                    compulsory_with_depth: 8.0 + 8.0 + 2.0 * picture + 4.0,
                    fetched: 4.0 * samples + 8.0 + 9.0 * 8.0 + 2.0 * picture,
                }
            }
        }
    }
}
