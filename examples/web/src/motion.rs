//! Whether everything moves. Pictures are compared while nothing does.

use bevy::prelude::*;
use street::Walking;

#[derive(Resource, Clone, Copy, PartialEq, Eq)]
pub struct Motion(pub bool);

impl Default for Motion {
    fn default() -> Self {
        Self(true)
    }
}

/// Brings the street's people to it.
pub fn walk_or_stand(mut commands: Commands, motion: Res<Motion>) {
    commands.insert_resource(Walking(if motion.0 { 1.0 } else { 0.0 }));
}
