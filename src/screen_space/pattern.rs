//! By how much the pattern of directions in which effects look turns from frame to frame.

use bevy::diagnostic::FrameCount;

/// As a share of a whole turn. None unless the projection is jittered: only where frames are brought together does noise that
/// changes do good.
pub(super) fn turn_of(frame: &FrameCount, jitters: bool) -> f32 {
    if jitters {
        // The golden section spreads any number of frames.
        (frame.0 % 1024) as f32 * 0.618_034 % 1.0
    } else {
        0.0
    }
}
