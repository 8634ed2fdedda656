//! CPU reference of the exposure shaders, in double precision.

use bevy::math::{DVec2, UVec2, Vec3};
use bevy_lean_deferred::effects::auto_exposure::{
    LeanAutoExposure, LuminanceTrim, Metering, MeteringPattern,
};
use half::f16;

use crate::reference::effects::auto_exposure::luminance::{LARGEST, LOWEST_LOG, WEIGHTS};

/// Red channel of a mask, filtered linearly.
pub struct Mask {
    pub size: UVec2,
    pub texels: Vec<u8>,
}

impl Mask {
    fn at(&self, uv: DVec2) -> f64 {
        let size = self.size.as_dvec2();
        let position = uv * size - 0.5;
        let texel = |offset: DVec2| {
            let p = (position.floor() + offset).clamp(DVec2::ZERO, size - 1.0);
            f64::from(self.texels[p.y as usize * self.size.x as usize + p.x as usize]) / 255.0
        };
        let t = position - position.floor();
        let row = |y| texel(DVec2::new(0.0, y)) * (1.0 - t.x) + texel(DVec2::new(1.0, y)) * t.x;
        row(0.0) * (1.0 - t.y) + row(1.0) * t.y
    }
}

/// `texel` rounded to half precision, as textures store it.
fn stored(texel: Vec3) -> [f64; 3] {
    texel
        .to_array()
        .map(|c| f64::from(f16::from_f32(c).to_f32()))
}

/// Luminance of a texel, clamped to 0 to [`LARGEST`]; `None` if NaN.
pub fn luminance(texel: Vec3) -> Option<f64> {
    let weights = WEIGHTS.to_array().map(f64::from);
    let y: f64 = stored(texel).iter().zip(weights).map(|(c, w)| c * w).sum();
    (!y.is_nan()).then(|| y.clamp(0.0, f64::from(LARGEST)))
}

/// Metering weight of a pixel of a viewport of `size`.
pub fn weight(pattern: &MeteringPattern, mask: Option<&Mask>, pixel: UVec2, size: UVec2) -> f64 {
    let size = size.as_dvec2();
    let center = pixel.as_dvec2() + 0.5;
    let distance_squared = ((center - 0.5 * size) / size.y).length_squared();
    match pattern {
        MeteringPattern::Average => 1.0,
        MeteringPattern::CenterWeighted => (-8.0 * distance_squared).exp(),
        MeteringPattern::Spot { radius } => f64::from(u8::from(
            distance_squared < f64::from(*radius) * f64::from(*radius),
        )),
        MeteringPattern::Mask(_) => mask.expect("the test has one").at(center / size),
    }
}

/// Metered luminance of the viewport (origin and size) of a picture; `None` if there is nothing to meter.
pub fn metered(
    settings: &LeanAutoExposure,
    picture: &[Vec3],
    size: UVec2,
    (origin, extent): (UVec2, UVec2),
    mask: Option<&Mask>,
) -> Option<f64> {
    let value = |y: f64| match settings.metering {
        Metering::LinearAverage => y,
        Metering::LogAverage => y.max(f64::from(LOWEST_LOG).exp2()).log2(),
    };
    let mut samples: Vec<(f64, f64)> = (0..extent.y)
        .flat_map(|y| (0..extent.x).map(move |x| UVec2::new(x, y)))
        .filter_map(|pixel| {
            let at = origin + pixel;
            let y = luminance(picture[(at.y * size.x + at.x) as usize])?;
            Some((value(y), weight(&settings.pattern, mask, pixel, extent)))
        })
        .collect();
    let mut total: f64 = samples.iter().map(|(_, w)| w).sum();
    if let Some(trim) = settings.trim {
        cut(&mut samples, trim, total);
        total = samples.iter().map(|(_, w)| w).sum();
    }
    let mean = samples.iter().map(|(v, w)| v * w).sum::<f64>() / total;
    (total > 0.0).then_some(match settings.metering {
        Metering::LinearAverage => mean,
        Metering::LogAverage => mean.exp2(),
    })
}

/// Clips each weight to the part between the trimmed shares.
fn cut(samples: &mut [(f64, f64)], trim: LuminanceTrim, total: f64) {
    samples.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let from = total * f64::from(trim.low);
    let to = total * (1.0 - f64::from(trim.high));
    let mut below = 0.0;
    for (_, weight) in samples {
        let above = below + *weight;
        *weight = (above.min(to) - below.max(from)).max(0.0);
        below = above;
    }
}
