//! Sizes of textures of views that are resized while they are drawn: dragged windows, sliding split screens, dynamic resolution.

use bevy::math::UVec2;

/// Factor by which an axis that is too short grows while the size keeps changing.
const GROWTH: f32 = 1.5;
/// Frames of one size after which a view is at rest, and textures that are too large shrink to it.
const REST: u32 = 60;
/// Sizes with headroom are multiples of this.
const STEP: u32 = 64;

/// Size of textures of a view. Exact at rest and after a single change, and larger while the size of the view keeps changing: a
/// window that becomes full-screen must not need more memory than its new size does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct GrowingSize {
    allocated: UVec2,
    needed: UVec2,
    /// Frames in a row that needed the same size; at least [`REST`] at first.
    unchanged: u32,
    /// Headroom did not fit into memory since the view was last at rest.
    has_no_headroom: bool,
}

impl GrowingSize {
    /// Size of the textures in a frame that needs `needed` texels, at most `largest` a side. Call it once per frame. `is_exact`
    /// takes the headroom away.
    pub(crate) fn fit(&mut self, needed: UVec2, largest: u32, is_exact: bool) -> UVec2 {
        let is_first = self.allocated == UVec2::ZERO;
        let was_at_rest = self.unchanged >= REST;
        self.unchanged = if is_first {
            REST
        } else if needed == self.needed {
            self.unchanged.saturating_add(1)
        } else {
            0
        };
        self.needed = needed;
        self.has_no_headroom &= self.unchanged < REST;
        self.allocated = if is_exact || self.has_no_headroom || self.unchanged >= REST {
            needed
        } else {
            let grown = if was_at_rest {
                needed
            } else {
                let grown = (needed.as_vec2() * GROWTH).as_uvec2();
                let grown = grown.map(|side| side.next_multiple_of(STEP).min(largest));
                grown.max(needed)
            };
            UVec2::select(needed.cmpgt(self.allocated), grown, self.allocated)
        };
        self.allocated
    }

    pub(crate) fn allocated(&self) -> UVec2 {
        self.allocated
    }

    pub(crate) fn has_headroom(&self) -> bool {
        self.allocated != self.needed
    }

    /// Takes the headroom away until the view is at rest.
    pub(crate) fn drop_headroom(&mut self) {
        self.has_no_headroom = true;
        self.allocated = self.needed;
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
    }

    /// As from a window to the full screen and back.
    #[test]
    fn single_changes_have_no_headroom() {
        let window = UVec2::new(1280, 720);
        let screen = UVec2::new(3840, 2160);
        let mut size = GrowingSize::default();
        assert_eq!(size.fit(window, LARGEST, false), window);
        for _ in 0..2 * REST {
            assert_eq!(size.fit(screen, LARGEST, false), screen);
        }
        for _ in 0..REST {
            assert_eq!(size.fit(window, LARGEST, false), screen);
        }
        assert_eq!(size.fit(window, LARGEST, false), window);
        assert_eq!(size.fit(screen, LARGEST, false), screen);
    }

    #[test]
    fn headroom_ends_at_the_limit_of_the_device() {
        let mut size = GrowingSize::default();
        let sides = [7000, 7500, 8000].map(|side| UVec2::new(side, 1083));
        assert_eq!(size.fit(sides[0], LARGEST, false), sides[0]);
        assert_eq!(size.fit(sides[1], LARGEST, false), sides[1]);
        let grown = size.fit(sides[2], LARGEST, false);
        assert_eq!(grown, UVec2::new(LARGEST, 1083));
        assert_eq!(size.fit(sides[2], LARGEST, true), sides[2]);
    }

    #[test]
    fn views_without_memory_for_headroom_are_exact_until_they_rest() {
        let mut size = GrowingSize::default();
        let sides = [0, 1, 2, 3].map(|step| UVec2::new(640 + 20 * step, 480));
        size.fit(sides[0], LARGEST, false);
        size.fit(sides[1], LARGEST, false);
        assert!(!size.has_headroom(), "a single change has none");
        assert!(size.fit(sides[2], LARGEST, false).x > sides[2].x);
        size.drop_headroom();
        assert_eq!(size.allocated(), sides[2]);
        assert_eq!(size.fit(sides[3], LARGEST, false), sides[3]);
        for _ in 0..REST {
            size.fit(sides[3], LARGEST, false);
        }
        size.fit(sides[0] * 2, LARGEST, false);
        let again = sides[1] * 2;
        assert!(size.fit(again, LARGEST, false).x > again.x);
    }

    #[test]
    fn dragged_views_are_reallocated_rarely() {
        let dragged =
            |step: i32| (0..=12).map(move |frame| UVec2::new(640 + (frame * step) as u32, 480));
        // The first size, the first change, and headroom.
        assert_eq!(allocations(dragged(20)), 3);
        assert!(
            allocations(dragged(53)) <= 4,
            "a view that doubles its width"
        );
        let shrinking = (0..12u32).map(|frame| UVec2::new(640 - 40 * frame, 480 - 20 * frame));
        assert_eq!(allocations(shrinking), 1);
        // Dynamic resolution.
        let scaled = (0..1000u32).map(|frame| UVec2::new(1920, 1080) * (50 + frame * 7 % 51) / 100);
        assert!(allocations(scaled) <= 4);
    }
}
