//! Sizes of textures of views that are resized while they are drawn: dragged windows, sliding split screens, dynamic resolution.

use bevy::math::UVec2;

/// Factor by which an axis grows that has become too short, so that a view that doubles its size within a few frames causes two
/// allocations.
const GROWTH: f32 = 1.5;
/// Frames of one size after which textures that are too large shrink to it.
const REST: u32 = 60;
/// Sizes with headroom are multiples of this.
const STEP: u32 = 64;

/// Size of textures of a view. Exact at first and at rest, and larger while the size of the view changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct GrowingSize {
    allocated: UVec2,
    needed: UVec2,
    /// Frames in a row that needed the same size.
    unchanged: u32,
}

impl GrowingSize {
    /// Size of the textures in a frame that needs `needed` texels, at most `largest` a side. Call it once per frame. `is_exact`
    /// takes the headroom away.
    pub(crate) fn fit(&mut self, needed: UVec2, largest: u32, is_exact: bool) -> UVec2 {
        let is_first = self.allocated == UVec2::ZERO;
        self.unchanged = if needed == self.needed {
            self.unchanged.saturating_add(1)
        } else {
            0
        };
        self.needed = needed;
        self.allocated = if is_first || is_exact || self.unchanged >= REST {
            needed
        } else {
            let grown = (needed.as_vec2() * GROWTH).as_uvec2();
            let grown = grown.map(|side| side.next_multiple_of(STEP).min(largest));
            UVec2::select(
                needed.cmpgt(self.allocated),
                grown.max(needed),
                self.allocated,
            )
        };
        self.allocated
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LARGEST: u32 = 8192;

    /// Number of allocations, the first one included, for views of these sizes.
    fn allocations(sizes: impl IntoIterator<Item = UVec2>) -> usize {
        let mut size = GrowingSize::default();
        let mut held = UVec2::ZERO;
        let mut count = 0;
        for needed in sizes {
            let allocated = size.fit(needed, LARGEST, false);
            assert!(allocated.cmpge(needed).all(), "{allocated} for {needed}");
            count += usize::from(allocated != held);
            held = allocated;
        }
        count
    }

    #[test]
    fn views_at_rest_have_textures_of_their_size() {
        let mut size = GrowingSize::default();
        let view = UVec2::new(1921, 1083);
        assert_eq!(size.fit(view, LARGEST, false), view);
        assert_eq!(size.fit(view, LARGEST, false), view);
        let smaller = UVec2::new(1000, 1083);
        for _ in 0..REST {
            assert_eq!(size.fit(smaller, LARGEST, false), view);
        }
        assert_eq!(size.fit(smaller, LARGEST, false), smaller);
        let larger = UVec2::new(8000, 1083);
        let grown = size.fit(larger, LARGEST, false);
        assert_eq!(
            grown,
            UVec2::new(LARGEST, 1083),
            "within the device's limit"
        );
        assert_eq!(size.fit(larger, LARGEST, true), larger);
    }

    #[test]
    fn dragged_views_are_reallocated_rarely() {
        let dragged =
            |step: i32| (0..=12).map(move |frame| UVec2::new(640 + (frame * step) as u32, 480));
        assert_eq!(allocations(dragged(20)), 2);
        assert!(
            allocations(dragged(53)) <= 3,
            "a view that doubles its width"
        );
        let shrinking = (0..12u32).map(|frame| UVec2::new(640 - 40 * frame, 480 - 20 * frame));
        assert_eq!(allocations(shrinking), 1);
        // Dynamic resolution.
        let scaled = (0..1000u32).map(|frame| UVec2::new(1920, 1080) * (50 + frame * 7 % 51) / 100);
        assert!(allocations(scaled) <= 3);
    }
}
