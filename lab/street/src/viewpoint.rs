//! Viewpoints of cameras.

use bevy::prelude::*;

/// Position of a camera, and the point in the middle of its picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    pub eye: Vec3,
    pub target: Vec3,
}

impl Viewpoint {
    /// Down the street.
    pub const STREET: Self = Self::new([0.5, 1.75, 7.2], [-0.1, 2.3, -8.0]);
    /// A stall and the corner behind it: occlusion and diffuse GI.
    pub const STALL: Self = Self::new([-0.2, 1.6, -2.3], [-3.7, 0.85, -5.0]);
    /// Low over a puddle.
    pub const PUDDLE: Self = Self::new([0.35, 0.7, 1.6], [0.2, 1.25, -8.0]);
    /// The cats in front of the gate.
    pub const CATS: Self = Self::new([2.35, 1.35, 2.9], [3.15, 1.12, 1.2]);

    const fn new(eye: [f32; 3], target: [f32; 3]) -> Self {
        Self {
            eye: Vec3::from_array(eye),
            target: Vec3::from_array(target),
        }
    }

    pub fn transform(self) -> Transform {
        Transform::from_translation(self.eye).looking_at(self.target, Vec3::Y)
    }
}
