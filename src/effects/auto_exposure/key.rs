//! Pipeline key, and sizes of dispatches and buffers.

use bevy::{math::UVec2, shader::ShaderDefVal};

use super::settings::{LeanAutoExposure, Metering, MeteringPattern};
use crate::gpu::{effect_pipelines::EffectKey, shader_defs};

/// Columns of pixels that a workgroup of the first pass reads.
pub const TILE_WIDTH: u32 = 64;
/// Rows that it may read. Few workgroups leave parts of a large GPU idle; many leave much work to the second pass.
const TILE_HEIGHTS: [u32; 2] = [64, 128];
/// Partial sums that the second pass adds in one iteration.
const MOST_WORKGROUPS: u32 = 1024;
/// Bins of the histogram.
pub const BINS: u64 = 256;

/// Pipeline key of both passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ExposureKey {
    metering: Metering,
    pattern: PatternKey,
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
    /// Derives the key from `settings`. `subgroups`: the device reduces by subgroups. Until a mask is loaded, all pixels count.
    pub fn new(settings: &LeanAutoExposure, subgroups: bool, mask_is_loaded: bool) -> Self {
        Self {
            metering: settings.metering,
            pattern: match &settings.pattern {
                MeteringPattern::CenterWeighted => PatternKey::CenterWeighted,
                MeteringPattern::Spot { .. } => PatternKey::Spot,
                MeteringPattern::Mask(_) if mask_is_loaded => PatternKey::Mask,
                MeteringPattern::Average | MeteringPattern::Mask(_) => PatternKey::Average,
            },
            histogram: settings.trim.is_some(),
            subgroups,
        }
    }

    /// True if the darkest and brightest pixels are left out.
    pub fn has_histogram(self) -> bool {
        self.histogram
    }

    /// Size in bytes of the buffer between the passes: partial sums, or the histogram.
    pub fn sums_size(self, viewport_size: UVec2) -> u64 {
        if self.histogram {
            4 * BINS
        } else {
            8 * u64::from(workgroups(viewport_size).element_product())
        }
    }

    /// The key without the fields that the overlay's shader does not read.
    pub(super) fn of_overlay(self) -> Self {
        Self {
            metering: Metering::default(),
            histogram: false,
            subgroups: false,
            ..self
        }
    }

    /// Shader defs of both passes.
    pub fn shader_defs(self) -> Vec<ShaderDefVal> {
        let log_average = self.metering == Metering::LogAverage;
        let pattern = self.pattern;
        let weighted = pattern != PatternKey::Average;
        let of_products = log_average && !weighted && !self.histogram;
        shader_defs::of_table([
            (log_average, "LOG_AVERAGE"),
            (of_products, "LOG_OF_PRODUCTS"),
            (weighted, "WEIGHTED"),
            (pattern == PatternKey::CenterWeighted, "CENTER_WEIGHTED"),
            (pattern == PatternKey::Spot, "SPOT"),
            (pattern == PatternKey::Mask, "MASK"),
            (self.histogram, "HISTOGRAM"),
            (self.subgroups, "SUBGROUPS"),
        ])
        .collect()
    }
}

impl EffectKey for ExposureKey {
    fn shader_defs(self) -> Vec<ShaderDefVal> {
        Self::shader_defs(self)
    }
}

/// Workgroups of the first pass.
pub fn workgroups(viewport_size: UVec2) -> UVec2 {
    workgroups_with(tile_height(viewport_size), viewport_size)
}

/// Workgroups of the first pass, if each reads `height` rows.
fn workgroups_with(height: u32, viewport_size: UVec2) -> UVec2 {
    UVec2::new(
        viewport_size.x.div_ceil(TILE_WIDTH),
        viewport_size.y.div_ceil(height),
    )
}

/// Rows that a workgroup of the first pass reads: the fewest that keep the partial sums within one iteration of the second pass.
pub(super) fn tile_height(viewport_size: UVec2) -> u32 {
    let [low, high] = TILE_HEIGHTS;
    let workgroups = workgroups_with(low, viewport_size);
    if workgroups.element_product() <= MOST_WORKGROUPS {
        low
    } else {
        high
    }
}
