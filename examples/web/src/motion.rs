//! Switches all motion on or off. Pictures are compared while nothing moves.

use bevy::prelude::*;
use street::Walking;

#[derive(Resource, Clone, Copy, PartialEq, Eq)]
pub struct Motion(pub bool);

impl Default for Motion {
    fn default() -> Self {
        Self(true)
    }
}

/// Makes the street's people walk or stand.
pub fn walk_or_stand(mut commands: Commands, motion: Res<Motion>) {
    commands.insert_resource(Walking(if motion.0 { 1.0 } else { 0.0 }));
}
