//! Detects views whose frames are averaged over time, as by TAA and DLSS: noise that changes per frame helps only
//! there.
//!
//! Temporal averaging changes the jitter of the projection in each frame. The presence of `TemporalJitter` alone proves
//! nothing: Bevy leaves it on the camera when `TemporalAntiAliasing` is removed, and the jitter then stays constant.

use bevy::{diagnostic::FrameCount, prelude::*, render::camera::TemporalJitter};

/// On a view of the render world with a `TemporalJitter`: tells if its frames are averaged.
#[derive(Component)]
pub(crate) struct FrameAveraging {
    offset: Vec2,
    is_on: bool,
}

impl FrameAveraging {
    /// Rotation of direction patterns in this frame, in turns. 0 in views whose frames are not averaged.
    pub(crate) fn turn(averaging: Option<&Self>, frame: &FrameCount) -> f32 {
        if averaging.is_some_and(|averaging| averaging.is_on) {
            // The golden ratio spreads any number of frames evenly.
            (frame.0 % 1024) as f32 * 0.618_034 % 1.0
        } else {
            0.0
        }
    }
}

/// Runs after the systems that jitter projections, which are in `RenderSystems::PrepareViews`.
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
