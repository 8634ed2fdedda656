//! What the shaders are compiled by.

use bevy::{math::UVec2, shader::ShaderDefVal};

use super::{ExposureSampling, LeanAutoExposure, Metering, MeteringPattern};

/// Pixels that a workgroup of the first pass reads if it reads all.
pub const TILE: UVec2 = UVec2::new(64, 128);
/// Bins of the histogram.
pub const BINS: u64 = 256;

/// What the shaders are compiled by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ExposureKey {
    metering: Metering,
    pattern: PatternKey,
    sampling: ExposureSampling,
    histogram: bool,
    subgroups: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum PatternKey {
    Average,
    CenterWeighted,
    Spot,
    Mask,
}

impl ExposureKey {
    /// Of `settings` on a device that reduces by subgroups or does not, with the mask, if there is one, loaded or not.
    pub fn new(settings: &LeanAutoExposure, subgroups: bool, mask_is_loaded: bool) -> Self {
        Self {
            metering: settings.metering,
            pattern: match &settings.pattern {
                MeteringPattern::CenterWeighted => PatternKey::CenterWeighted,
                MeteringPattern::Spot { .. } => PatternKey::Spot,
                MeteringPattern::Mask(_) if mask_is_loaded => PatternKey::Mask,
                MeteringPattern::Average | MeteringPattern::Mask(_) => PatternKey::Average,
            },
            sampling: settings.sampling,
            histogram: settings.trim.is_some(),
            subgroups,
        }
    }

    /// Whether the darkest and the brightest pixels are left out.
    pub fn has_histogram(self) -> bool {
        self.histogram
    }

    /// Whether pixels count as a mask says.
    pub fn has_mask(self) -> bool {
        self.pattern == PatternKey::Mask
    }

    /// Of the first pass.
    pub fn workgroups(self, viewport_size: UVec2) -> UVec2 {
        let tile = TILE * self.sampling.stride();
        UVec2::new(
            viewport_size.x.div_ceil(tile.x),
            viewport_size.y.div_ceil(tile.y),
        )
    }

    /// Bytes that the first pass leaves for the second: partial sums, or the histogram.
    pub fn sums_size(self, viewport_size: UVec2) -> u64 {
        if self.histogram {
            4 * BINS
        } else {
            8 * u64::from(self.workgroups(viewport_size).element_product())
        }
    }

    /// What of it the overlay's shader sees.
    pub(super) fn of_overlay(self) -> Self {
        Self {
            metering: Metering::default(),
            sampling: ExposureSampling::default(),
            histogram: false,
            subgroups: false,
            ..self
        }
    }

    /// What both shaders are compiled with.
    pub fn shader_defs(self) -> Vec<ShaderDefVal> {
        let mut defs = vec![ShaderDefVal::UInt("STRIDE".into(), self.sampling.stride())];
        defs.extend(
            [
                (self.metering == Metering::LogAverage, "LOG_AVERAGE"),
                (self.pattern != PatternKey::Average, "WEIGHTED"),
                (
                    self.pattern == PatternKey::CenterWeighted,
                    "CENTER_WEIGHTED",
                ),
                (self.pattern == PatternKey::Spot, "SPOT"),
                (self.pattern == PatternKey::Mask, "MASK"),
                (self.histogram, "HISTOGRAM"),
                (self.subgroups, "SUBGROUPS"),
            ]
            .into_iter()
            .filter(|(condition, _)| *condition)
            .map(|(_, name)| name.into()),
        );
        defs
    }
}
