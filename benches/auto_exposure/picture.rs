//! The metered picture, and its true luminances.

use std::ops::Range;

use bevy::{
    asset::Handle,
    math::{UVec2, Vec3},
};
use bevy_lean_deferred::effects::auto_exposure::{
    LeanAutoExposure, LuminanceTrim, Metering, MeteringPattern,
};
use half::f16;

use kit::{
    exposure_reference::{self as reference, Mask},
    random::Random,
    reference::effects::auto_exposure::luminance::{LARGEST, LOWEST_LOG},
};

/// Bytes per Rgba16Float texel.
pub const TEXEL: usize = 8;
/// The trim of [`Truth::trimmed`]: the same as Bevy's default.
pub const TRIM: LuminanceTrim = LuminanceTrim {
    low: 0.1,
    high: 0.1,
};

/// Texels in Rgba16Float, the same in every run.
pub struct Picture {
    pub size: UVec2,
    pub bytes: Vec<u8>,
}

impl Picture {
    /// Gradients as large as the picture over 12 stops, -7 to 5, noise of one stop, and small lights of 8 to 13 stops.
    pub fn new(size: UVec2) -> Self {
        let row = size.x as usize * TEXEL;
        let mut bytes = vec![0; row * size.y as usize];
        let shape = Shape::new(size);
        let rows = rows_of_a_band(size.y);
        std::thread::scope(|scope| {
            for (band, chunk) in bytes.chunks_mut(row * rows as usize).enumerate() {
                let shape = &shape;
                scope.spawn(move || {
                    for (y, row) in (band as u32 * rows..).zip(chunk.chunks_mut(row)) {
                        shape.fill(y, row);
                    }
                });
            }
        });
        Self { size, bytes }
    }

    /// A single grey: all pixels fall into one bin of a histogram.
    pub fn flat(size: UVec2) -> Self {
        let texel = [0.5, 0.5, 0.5, 1.0].map(|channel| f16::from_f32(channel).to_le_bytes());
        Self {
            size,
            bytes: texel.as_flattened().repeat(size.element_product() as usize),
        }
    }

    fn texel(&self, x: u32, y: u32) -> Vec3 {
        let at = (y as usize * self.size.x as usize + x as usize) * TEXEL;
        let channel = |i| f16::from_le_bytes([self.bytes[at + i], self.bytes[at + i + 1]]).to_f32();
        Vec3::new(channel(0), channel(2), channel(4))
    }
}

/// Waves by column and by row, in stops: their sums and products make the gradients cheap.
struct Shape {
    columns: Vec<[f32; 2]>,
    rows: Vec<[f32; 2]>,
    /// Side of the squares that may hold a light each.
    cell: u32,
}

impl Shape {
    fn new(size: UVec2) -> Self {
        let waves = |count: u32, slow: f32, fast: f32| {
            (0..count)
                .map(|i| {
                    let t = i as f32 / count as f32;
                    [(slow * t).sin(), (fast * t + 1.0).sin()]
                })
                .collect()
        };
        Self {
            columns: waves(size.x, 5.0, 17.0),
            rows: waves(size.y, 4.0, 11.0),
            cell: (size.y / 32).max(8),
        }
    }

    fn fill(&self, y: u32, row: &mut [u8]) {
        let mut random = Random::new(u64::from(y));
        let [slow, fast] = self.rows[y as usize];
        for (x, texel) in row.chunks_exact_mut(TEXEL).enumerate() {
            let column = self.columns[x];
            let noise = random.unit() - 0.5;
            let stops = -1.5 + 2.5 * (column[0] + slow) + column[1] * fast + noise;
            let tint = 0.2 * column[1];
            let color = Vec3::new(1.0 + tint, 1.0, 1.0 - tint) * stops.exp2()
                + Vec3::splat(self.light(x as u32, y));
            for (bytes, channel) in texel.chunks_exact_mut(2).zip(color.extend(1.0).to_array()) {
                bytes.copy_from_slice(&f16::from_f32(channel).to_le_bytes());
            }
        }
    }

    /// Luminance of the light at a pixel. One square in twelve has a disc somewhere.
    fn light(&self, x: u32, y: u32) -> f32 {
        let (cell_x, cell_y) = (x / self.cell, y / self.cell);
        let hash = (cell_x.wrapping_mul(0x9e37_79b1) ^ cell_y.wrapping_mul(0x85eb_ca77))
            .wrapping_mul(0xc2b2_ae3d);
        if !(hash >> 20).is_multiple_of(12) {
            return 0.0;
        }
        let radius = (self.cell / 16).max(1) as i32;
        let place = |bits: u32| radius + (bits % (self.cell - 2 * radius as u32)) as i32;
        let dx = (x % self.cell) as i32 - place(hash >> 8);
        let dy = (y % self.cell) as i32 - place(hash >> 14);
        if dx * dx + dy * dy > radius * radius {
            return 0.0;
        }
        ((hash >> 5) as f32 / (1 << 27) as f32 * 5.0 + 8.0).exp2()
    }
}

/// Means over the whole picture in double precision.
#[derive(Clone, Copy)]
pub struct Truth {
    log_average: f64,
    linear_average: f64,
    center_weighted: f64,
    mask: f64,
    trimmed: f64,
}

impl Truth {
    pub fn new(picture: &Picture, mask: &Mask) -> Self {
        let rows = rows_of_a_band(picture.size.y);
        let mut sums = Sums::default();
        std::thread::scope(|scope| {
            let bands: Vec<_> = (0..picture.size.y)
                .step_by(rows as usize)
                .map(|from| {
                    let to = (from + rows).min(picture.size.y);
                    scope.spawn(move || Sums::of(picture, mask, from..to))
                })
                .collect();
            for band in bands {
                sums.add(&band.join().expect("no band panics"));
            }
        });
        let mean = |sum: [f64; 2]| sum[0] / sum[1];
        Self {
            log_average: mean(sums.log).exp2(),
            linear_average: mean(sums.linear),
            center_weighted: mean(sums.center).exp2(),
            mask: mean(sums.mask).exp2(),
            trimmed: mean(sums.trimmed()).exp2(),
        }
    }

    /// The luminance that `settings` should meter.
    pub fn of(&self, settings: &LeanAutoExposure) -> f64 {
        match (&settings.pattern, settings.trim, settings.metering) {
            (MeteringPattern::Average, None, Metering::LogAverage) => self.log_average,
            (MeteringPattern::Average, None, Metering::LinearAverage) => self.linear_average,
            (MeteringPattern::CenterWeighted, None, Metering::LogAverage) => self.center_weighted,
            (MeteringPattern::Mask(_), None, Metering::LogAverage) => self.mask,
            (MeteringPattern::Average, Some(TRIM), Metering::LogAverage) => self.trimmed,
            _ => panic!("not computed: {settings:?}"),
        }
    }
}

/// Fine enough that the distribution within one bin does not matter.
const BINS: usize = 1 << 16;

/// Weighted sums of values, each with the sum of its weights.
struct Sums {
    log: [f64; 2],
    linear: [f64; 2],
    center: [f64; 2],
    mask: [f64; 2],
    /// Histogram of logarithms, for trimming: sorting would take longer than everything else.
    bins: Vec<[f64; 2]>,
}

impl Default for Sums {
    fn default() -> Self {
        Self {
            log: [0.0; 2],
            linear: [0.0; 2],
            center: [0.0; 2],
            mask: [0.0; 2],
            bins: vec![[0.0; 2]; BINS],
        }
    }
}

impl Sums {
    fn of(picture: &Picture, mask: &Mask, rows: Range<u32>) -> Self {
        let mut sums = Self::default();
        let masked = MeteringPattern::Mask(Handle::default());
        let lowest = f64::from(LOWEST_LOG);
        let bins_per_stop = BINS as f64 / (f64::from(LARGEST).log2() - lowest);
        for y in rows {
            for x in 0..picture.size.x {
                let luminance =
                    reference::luminance(picture.texel(x, y)).expect("they are numbers");
                let log = luminance.max(lowest.exp2()).log2();
                let weight = |pattern, mask| {
                    reference::weight(pattern, mask, UVec2::new(x, y), picture.size)
                };
                let count = |sum: &mut [f64; 2], value, weight| {
                    sum[0] += value * weight;
                    sum[1] += weight;
                };
                count(&mut sums.log, log, 1.0);
                count(&mut sums.linear, luminance, 1.0);
                let center = weight(&MeteringPattern::CenterWeighted, None);
                count(&mut sums.center, log, center);
                count(&mut sums.mask, log, weight(&masked, Some(mask)));
                let bin = ((log - lowest) * bins_per_stop) as usize;
                count(&mut sums.bins[bin.min(BINS - 1)], log, 1.0);
            }
        }
        sums
    }

    fn add(&mut self, other: &Self) {
        let pairs = [
            (&mut self.log, other.log),
            (&mut self.linear, other.linear),
            (&mut self.center, other.center),
            (&mut self.mask, other.mask),
        ];
        let bins = self.bins.iter_mut().zip(other.bins.iter().copied());
        for (sum, more) in pairs.into_iter().chain(bins) {
            sum[0] += more[0];
            sum[1] += more[1];
        }
    }

    /// Sum of the logarithms between the trimmed shares, and its weight.
    fn trimmed(&self) -> [f64; 2] {
        let from = self.log[1] * f64::from(TRIM.low);
        let to = self.log[1] * (1.0 - f64::from(TRIM.high));
        let (mut kept, mut below) = ([0.0; 2], 0.0);
        for [log, weight] in self.bins.iter().filter(|bin| bin[1] > 0.0) {
            let above = below + weight;
            let part = (above.min(to) - below.max(from)).max(0.0);
            kept[0] += log / weight * part;
            kept[1] += part;
            below = above;
        }
        kept
    }
}

/// Rows per band, so that each thread has one band.
fn rows_of_a_band(rows: u32) -> u32 {
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get() as u32);
    rows.div_ceil(threads)
}

/// A mask that falls off towards the corners, and weighs the lower half more.
pub fn mask() -> Mask {
    let size = UVec2::splat(64);
    let texel = |i: u32| {
        let (x, y) = (i % size.x, i / size.x);
        let t = (x * (63 - x)) as f32 / 1024.0 * (y as f32 / 63.0).sqrt();
        (t * 255.0) as u8
    };
    Mask {
        size,
        texels: (0..size.element_product()).map(texel).collect(),
    }
}
