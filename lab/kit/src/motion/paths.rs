//! Paths of the camera and of things in the yard, frame by frame, at 60 frames per second.

use bevy::prelude::*;

use crate::random::Random;

/// Everything that moves, in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    pub camera: Transform,
    /// True if the camera carries the weapon.
    pub is_armed: bool,
    /// Positions of the car and of the walker along their lanes, in metres.
    pub car: f32,
    pub walker: f32,
    /// Angle by which the door is open, in radians.
    pub door: f32,
    /// Light that the lamp emits.
    pub lamp: f32,
}

impl Default for Pose {
    fn default() -> Self {
        Self {
            camera: eye(EYE, 0.0, PITCH),
            is_armed: false,
            car: -6.0,
            walker: 1.4,
            door: 0.0,
            lamp: 8.0,
        }
    }
}

const EYE: Vec3 = Vec3::new(0.0, 1.3, 3.4);
/// Radians.
const PITCH: f32 = -0.22;

/// Light of the lamp while it is off: not 0, so that its material has emission in all frames.
const OFF: f32 = 0.02;

/// A camera at `position`, turned left by `yaw` and up by `pitch`, in radians.
fn eye(position: Vec3, yaw: f32, pitch: f32) -> Transform {
    let turned = Quat::from_euler(EulerRot::YXZ, yaw, pitch, 0.0);
    Transform::from_translation(position).with_rotation(turned)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// The camera walks forwards at 1.5 m/s.
    Walk,
    /// The camera turns right by 70° a second.
    Turn,
    /// The camera moves to the right at 3 m/s.
    Strafe,
    /// The camera walks and looks around, and carries a weapon.
    Look,
    /// The camera follows a walker at 1.5 m/s, and a car passes at 10 m/s.
    Car,
    /// A door opens at 170° a second, in front of a bright room.
    Door,
    /// A lamp is switched on and off.
    Lamp,
    /// A lamp has another brightness in each frame.
    Flicker,
}

impl Path {
    pub const ALL: [Self; 8] = [
        Self::Walk,
        Self::Turn,
        Self::Strafe,
        Self::Look,
        Self::Car,
        Self::Door,
        Self::Lamp,
        Self::Flicker,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Walk => "walk",
            Self::Turn => "turn",
            Self::Strafe => "strafe",
            Self::Look => "look",
            Self::Car => "car",
            Self::Door => "door",
            Self::Lamp => "lamp",
            Self::Flicker => "flicker",
        }
    }

    /// Frames in which the lamp is switched on, and off, on a path of `frames`.
    pub fn switches(self, frames: usize) -> Option<[usize; 2]> {
        (self == Self::Lamp).then_some([frames / 4, frames * 5 / 8])
    }

    /// The pose in frame `frame` of `frames`. Frame 0 begins the path.
    pub fn pose(self, frame: usize, frames: usize) -> Pose {
        let t = frame as f32;
        let still = Pose::default();
        match self {
            Self::Walk => {
                let bob = 0.02 * (0.4 * t).sin();
                let camera = eye(EYE + Vec3::new(0.0, bob, -0.025 * t), 0.0, PITCH);
                Pose { camera, ..still }
            }
            Self::Turn => Pose {
                camera: eye(EYE, 0.48 - 0.02 * t, PITCH),
                ..still
            },
            Self::Strafe => Pose {
                camera: eye(EYE + Vec3::X * (0.05 * t - 1.2), 0.0, PITCH),
                ..still
            },
            Self::Look => {
                let (yaw, pitch) = (0.35 * (0.15 * t).sin(), 0.1 * (0.11 * t).sin());
                let camera = eye(EYE - Vec3::Z * (0.025 * t), yaw, PITCH + pitch);
                Pose {
                    camera,
                    is_armed: true,
                    ..still
                }
            }
            Self::Car => {
                let walker = 0.025 * t - 1.0;
                Pose {
                    camera: eye(EYE + Vec3::X * walker, 0.0, PITCH),
                    car: 0.167 * t - 4.0,
                    walker,
                    ..still
                }
            }
            Self::Door => Pose {
                door: (0.05 * t).min(1.5),
                ..still
            },
            Self::Lamp => {
                let is_on = self
                    .switches(frames)
                    .is_some_and(|[on, off]| (on..off).contains(&frame));
                let lamp = if is_on { still.lamp } else { OFF };
                Pose { lamp, ..still }
            }
            Self::Flicker => {
                // Six levels, so that few poses have to be held.
                let level = Random::new(frame as u64).below(6);
                Pose {
                    lamp: still.lamp * (0.5 + 0.2 * level as f32),
                    ..still
                }
            }
        }
    }
}
