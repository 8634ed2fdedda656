//! Measures the difference between two pictures.

use super::headless::Picture;

/// Figures recorded for each comparison.
#[derive(Clone, Copy, Debug)]
pub struct Difference {
    /// Peak signal-to-noise ratio over sRGB-encoded RGB, in dB; infinite for equal pictures.
    pub psnr: f64,
    /// Mean LDR-ꟻLIP at 67 pixels per degree (Andersson et al. 2020, "ꟻLIP: A Difference Evaluator for Alternating Images"), 0 to 1.
    pub flip: f64,
    /// Share of pixels with a channel off by more than 8/255.
    pub off_by_8: f64,
    /// Largest channel difference, in 1/255.
    pub largest: u8,
}

impl core::fmt::Display for Difference {
    fn fmt(&self, f: &mut core::fmt::Formatter) -> core::fmt::Result {
        write!(
            f,
            "PSNR {:5.1} dB, FLIP {:.4}, {:.3}% off by more than 8/255, largest {}/255",
            self.psnr,
            self.flip,
            self.off_by_8 * 100.0,
            self.largest
        )
    }
}

pub fn difference(reference: &Picture, test: &Picture) -> Difference {
    Difference {
        flip: flip(reference, test),
        ..pixel_difference(reference, test)
    }
}

/// As [`difference`], without FLIP, which is slow on large pictures and is NaN here.
pub fn pixel_difference(reference: &Picture, test: &Picture) -> Difference {
    assert_eq!(reference.size, test.size);
    let (mut squares, mut largest, mut off) = (0.0f64, 0u8, 0usize);
    for (a, b) in reference.rgba.chunks(4).zip(test.rgba.chunks(4)) {
        let mut pixel_largest = 0;
        for channel in 0..3 {
            let d = a[channel].abs_diff(b[channel]);
            squares += f64::from(d) * f64::from(d);
            pixel_largest = pixel_largest.max(d);
        }
        largest = largest.max(pixel_largest);
        off += usize::from(pixel_largest > 8);
    }
    let pixels = reference.rgba.len() / 4;
    let mse = squares / (3 * pixels) as f64;
    Difference {
        psnr: 10.0 * (255.0 * 255.0 / mse).log10(),
        flip: f64::NAN,
        off_by_8: off as f64 / pixels as f64,
        largest,
    }
}

pub fn flip(reference: &Picture, test: &Picture) -> f64 {
    let image = |picture: &Picture| {
        let rgb: Vec<u8> = picture
            .rgba
            .chunks(4)
            .flat_map(|p| [p[0], p[1], p[2]])
            .collect();
        nv_flip::FlipImageRgb8::with_data(picture.size.x, picture.size.y, &rgb)
    };
    let error_map = nv_flip::flip(
        image(reference),
        image(test),
        nv_flip::DEFAULT_PIXELS_PER_DEGREE,
    );
    f64::from(nv_flip::FlipPool::from_image(&error_map).mean())
}
