//! Error statistics of a result.

use core::fmt;

/// Errors of linear occlusion.
#[derive(Clone, Copy, Debug)]
pub struct Errors {
    /// Pixels compared.
    pub count: usize,
    /// Mean of the result.
    pub mean: f64,
    /// Root of the mean squared error.
    pub rmse: f64,
    /// Mean error: positive where the result is too dark.
    pub bias: f64,
    /// 99 % of the errors are no larger.
    pub p99: f64,
    pub largest: f64,
}

impl Errors {
    /// Compares occlusion, not visibility, at the pixels that `mask` and `truth` hold. Panics if there are none.
    pub fn measure(result: &[f32], truth: &[Option<f32>], mask: &[bool]) -> Self {
        let result: Vec<_> = result.iter().copied().map(Some).collect();
        Self::measure_sparse(&result, truth, mask)
    }

    /// As [`measure`](Self::measure), for a result at some pixels only.
    pub fn measure_sparse(result: &[Option<f32>], truth: &[Option<f32>], mask: &[bool]) -> Self {
        assert_eq!((result.len(), truth.len()), (truth.len(), mask.len()));
        let pairs: Vec<(f64, f64)> = result
            .iter()
            .zip(truth)
            .zip(mask)
            .filter(|(_, mask)| **mask)
            .filter_map(|((result, truth), _)| Some(((*result)?.into(), (*truth)?.into())))
            .collect();
        assert!(!pairs.is_empty(), "no pixel to compare");
        let count = pairs.len();
        let mean =
            |value: fn(&(f64, f64)) -> f64| pairs.iter().map(value).sum::<f64>() / count as f64;

        let mut sizes: Vec<f64> = pairs.iter().map(|(a, b)| (a - b).abs()).collect();
        sizes.sort_by(f64::total_cmp);
        Self {
            count,
            mean: mean(|(result, _)| *result),
            rmse: mean(|(result, truth)| (result - truth).powi(2)).sqrt(),
            bias: mean(|(result, truth)| result - truth),
            p99: sizes[(count * 99).div_ceil(100) - 1],
            largest: sizes[count - 1],
        }
    }
}

impl fmt::Display for Errors {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(
            f,
            "RMSE {:.4}, bias {:+.4}, p99 {:.4}, largest {:.4}, mean {:.4} of {} pixels",
            self.rmse, self.bias, self.p99, self.largest, self.mean, self.count
        )
    }
}
