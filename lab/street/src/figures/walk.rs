//! The people's walk.

use core::f32::consts::{PI, TAU};

use bevy::prelude::*;

use super::body::{
    CHEST, HIPS, LEFT_ARM, LEFT_FOREARM, LEFT_SHIN, LEFT_THIGH, RIGHT_ARM, RIGHT_FOREARM,
    RIGHT_SHIN, RIGHT_THIGH,
};

/// Length of two steps, in metres.
const STRIDE: f32 = 1.35;

/// Factor on the walking speed: 0 for pictures that are compared. Default 1.
#[derive(Resource, Clone, Copy)]
pub struct Walking(pub f32);

/// A person or animal who walks from one end of the street to the other, and then again from its beginning.
#[derive(Component, Clone, Copy)]
pub struct Walker {
    /// X and y, in metres.
    pub lane: Vec2,
    pub towards_us: bool,
    /// In metres per second.
    pub speed: f32,
    /// End of the way, along z.
    pub far: f32,
    pub near: f32,
    /// Distance walked, in metres.
    pub way: f32,
}

impl Walker {
    /// Current position, turned in walking direction.
    pub fn transform(self) -> Transform {
        let length = self.near - self.far;
        let way = self.way.rem_euclid(length);
        let (z, turn) = match self.towards_us {
            true => (self.far + way, 0.0),
            false => (self.near - way, PI),
        };
        Transform::from_xyz(self.lane.x, self.lane.y, z).with_rotation(Quat::from_rotation_y(turn))
    }
}

/// In the order of [`JOINTS`](super::body::JOINTS).
#[derive(Component)]
pub struct Joints(pub Vec<Entity>);

#[derive(Component)]
pub struct HoldsUmbrella(pub bool);

pub fn walk(
    time: Res<Time>,
    walking: Option<Res<Walking>>,
    mut walkers: Query<(
        &mut Walker,
        &mut Transform,
        Option<(&Joints, &HoldsUmbrella)>,
    )>,
    mut joints: Query<&mut Transform, Without<Walker>>,
) {
    let pace = walking.map_or(1.0, |walking| walking.0);
    for (mut walker, mut transform, body) in &mut walkers {
        walker.way += pace * walker.speed * time.delta_secs();
        let scale = transform.scale;
        *transform = walker.transform().with_scale(scale);
        // Files animate the others.
        let Some((bones, holds)) = body else {
            continue;
        };
        let phase = TAU * walker.way / STRIDE;
        // Each step lifts the body, twice per stride.
        transform.translation.y += 0.02 * (2.0 * phase).cos() - 0.02;
        let mut turn = |joint: usize, rotation: Quat| {
            if let Ok(mut bone) = joints.get_mut(bones.0[joint]) {
                bone.rotation = rotation;
            }
        };
        let forth = |angle: f32| Quat::from_rotation_x(-angle);
        let swing = phase.sin();
        turn(HIPS, Quat::from_rotation_y(0.08 * swing));
        turn(CHEST, Quat::from_rotation_y(-0.16 * swing) * forth(0.04));
        for (sign, thigh, shin) in [
            (1.0, LEFT_THIGH, LEFT_SHIN),
            (-1.0, RIGHT_THIGH, RIGHT_SHIN),
        ] {
            turn(thigh, forth(0.48 * sign * swing + 0.05));
            // The leg that swings forward is bent.
            let lifted = (sign * phase.cos()).max(0.0);
            turn(shin, forth(-0.1 - 0.75 * lifted));
        }
        turn(LEFT_ARM, forth(-0.4 * swing));
        turn(LEFT_FOREARM, forth(0.25));
        if holds.0 {
            turn(RIGHT_ARM, forth(0.35));
            turn(RIGHT_FOREARM, forth(1.5));
        } else {
            turn(RIGHT_ARM, forth(0.4 * swing));
            turn(RIGHT_FOREARM, forth(0.25));
        }
    }
}
