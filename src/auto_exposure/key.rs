//! What the shaders are compiled by.

use bevy::{math::UVec2, shader::ShaderDefVal};

use super::{ExposureSampling, LeanAutoExposure, Metering, MeteringPattern};

/// Columns of pixels that a workgroup of the first pass reads if it reads all.
pub const TILE_WIDTH: u32 = 64;
/// Rows that it may read. Few workgroups would leave parts of a large GPU idle; many leave much to the second pass.
const TILE_HEIGHTS: [u32; 2] = [64, 128];
/// As many partial sums as the second pass adds up at once.
const MOST_WORKGROUPS: u32 = 1024;
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
        let height = tile_height(viewport_size, self.sampling);
        workgroups_with(height, viewport_size, self.sampling)
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
        let log_average = self.metering == Metering::LogAverage;
        let weighted = self.pattern != PatternKey::Average;
        let mut defs = vec![ShaderDefVal::UInt("STRIDE".into(), self.sampling.stride())];
        defs.extend(
            [
                (log_average, "LOG_AVERAGE"),
                (weighted, "WEIGHTED"),
                (
                    log_average && !weighted && !self.histogram,
                    "LOG_OF_PRODUCTS",
                ),
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

/// How many workgroups read so many rows each.
fn workgroups_with(height: u32, viewport_size: UVec2, sampling: ExposureSampling) -> UVec2 {
    let tile = UVec2::new(TILE_WIDTH, height) * sampling.stride();
    UVec2::new(
        viewport_size.x.div_ceil(tile.x),
        viewport_size.y.div_ceil(tile.y),
    )
}

/// How many rows a workgroup of the first pass reads: as few as leave no more partial sums than the second one adds up at once.
pub(super) fn tile_height(viewport_size: UVec2, sampling: ExposureSampling) -> u32 {
    let [low, high] = TILE_HEIGHTS;
    let workgroups = workgroups_with(low, viewport_size, sampling);
    if workgroups.element_product() <= MOST_WORKGROUPS {
        low
    } else {
        high
    }
}
