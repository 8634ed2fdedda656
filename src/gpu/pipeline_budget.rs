//! Limits the pipelines of this crate that are requested per frame, where each new one delays the frame.

use core::sync::atomic::{AtomicUsize, Ordering};

/// Pipelines that may be requested in this frame. Those that are withheld are requested again in the next one.
#[derive(Default)]
pub(crate) struct PipelineBudget {
    /// `None` without a limit.
    limit: Option<usize>,
    requested: AtomicUsize,
    withheld: AtomicUsize,
}

impl PipelineBudget {
    /// Begins a frame with this limit.
    pub(crate) fn begin_frame(&mut self, limit: Option<usize>) {
        *self = Self {
            limit,
            ..Self::default()
        };
    }

    /// True if one more pipeline may be requested in this frame, which counts as requested then. Otherwise it counts as
    /// withheld.
    pub(crate) fn admits(&self) -> bool {
        let Some(limit) = self.limit else {
            return true;
        };
        // Systems run in parallel.
        let admitted = self.requested.fetch_add(1, Ordering::Relaxed) < limit;
        if !admitted {
            self.withheld.fetch_add(1, Ordering::Relaxed);
        }
        admitted
    }

    /// Number of pipelines that were withheld in this frame.
    pub(crate) fn withheld(&self) -> usize {
        self.withheld.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pipelines_beyond_the_limit_are_withheld() {
        let mut budget = PipelineBudget::default();
        assert!((0..100).all(|_| budget.admits()));
        assert_eq!(budget.withheld(), 0);
        for _ in 0..2 {
            budget.begin_frame(Some(2));
            let admitted = (0..5).filter(|_| budget.admits()).count();
            assert_eq!((admitted, budget.withheld()), (2, 3));
        }
        budget.begin_frame(None);
        assert!(budget.admits());
        assert_eq!(budget.withheld(), 0);
    }
}
