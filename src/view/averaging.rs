//! Views whose frames are averaged over time, as TAA and DLSS do: only there noise that changes from frame to frame does good.
//!
//! Whoever averages frames moves the jitter of the projection in each of them. `TemporalJitter` alone says nothing: Bevy leaves it on the
//! camera when `TemporalAntiAliasing` goes, and then the jitter stands still.

use bevy::{diagnostic::FrameCount, prelude::*, render::camera::TemporalJitter};

/// On a view of the render world that has or had a `TemporalJitter`: whether its frames are averaged.
#[derive(Component)]
pub(crate) struct FrameAveraging {
    offset: Vec2,
    is_on: bool,
}

impl FrameAveraging {
    /// By how much patterns of directions are turned in this frame, as a share of a whole turn. 0 in views whose frames stand alone.
    pub(crate) fn turn(averaging: Option<&Self>, frame: &FrameCount) -> f32 {
        if averaging.is_some_and(|averaging| averaging.is_on) {
            // The golden section spreads any number of frames.
            (frame.0 % 1024) as f32 * 0.618_034 % 1.0
        } else {
            0.0
        }
    }
}

/// After what jitters projections, which does so in `RenderSystems::PrepareViews`.
pub(super) fn note_frame_averaging(
    mut commands: Commands,
    mut views: Query<(Entity, &TemporalJitter, Option<&mut FrameAveraging>)>,
    without: Query<Entity, (With<FrameAveraging>, Without<TemporalJitter>)>,
) {
    for view in &without {
        commands.entity(view).remove::<FrameAveraging>();
    }
    for (view, jitter, averaging) in &mut views {
        match averaging {
            Some(mut averaging) => {
                averaging.is_on = averaging.offset != jitter.offset;
                averaging.offset = jitter.offset;
            }
            None => {
                commands.entity(view).insert(FrameAveraging {
                    offset: jitter.offset,
                    is_on: false,
                });
            }
        }
    }
}
