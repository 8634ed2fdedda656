//! A body of a few rounded parts, and the joints that move them.

use bevy::{mesh::VertexAttributeValues, prelude::*};

use crate::geometry::Geometry;

/// A joint, and its parent.
#[derive(Clone, Copy)]
pub struct Joint {
    pub parent: Option<usize>,
    place: [f32; 3],
}

/// Joints of a body that stands upright with its arms down and looks along +z, its left at +x. In metres.
pub const JOINTS: [Joint; 11] = [
    Joint::new(None, [0.0, 0.92, 0.0]),
    Joint::new(Some(HIPS), [0.0, 1.12, 0.0]),
    Joint::new(Some(CHEST), [0.0, 1.47, 0.0]),
    Joint::new(Some(CHEST), [0.21, 1.4, 0.0]),
    Joint::new(Some(LEFT_ARM), [0.23, 1.12, 0.0]),
    Joint::new(Some(CHEST), [-0.21, 1.4, 0.0]),
    Joint::new(Some(RIGHT_ARM), [-0.23, 1.12, 0.0]),
    Joint::new(Some(HIPS), [0.1, 0.88, 0.0]),
    Joint::new(Some(LEFT_THIGH), [0.1, 0.47, 0.0]),
    Joint::new(Some(HIPS), [-0.1, 0.88, 0.0]),
    Joint::new(Some(RIGHT_THIGH), [-0.1, 0.47, 0.0]),
];

pub const HIPS: usize = 0;
pub const CHEST: usize = 1;
pub const HEAD: usize = 2;
pub const LEFT_ARM: usize = 3;
pub const LEFT_FOREARM: usize = 4;
pub const RIGHT_ARM: usize = 5;
pub const RIGHT_FOREARM: usize = 6;
pub const LEFT_THIGH: usize = 7;
pub const LEFT_SHIN: usize = 8;
pub const RIGHT_THIGH: usize = 9;
pub const RIGHT_SHIN: usize = 10;

/// Position of a right hand that holds an umbrella.
pub const HAND: Vec3 = Vec3::new(-0.23, 1.2, 0.27);

impl Joint {
    const fn new(parent: Option<usize>, place: [f32; 3]) -> Self {
        Self { parent, place }
    }

    /// Position in the upright body.
    pub fn place(self) -> Vec3 {
        Vec3::from_array(self.place)
    }

    /// Transform relative to the parent joint.
    pub fn local(self) -> Transform {
        let carrier = self
            .parent
            .map_or(Vec3::ZERO, |parent| JOINTS[parent].place());
        Transform::from_translation(self.place() - carrier)
    }
}

/// Geometry, and the joint of each vertex.
#[derive(Default)]
struct Skin {
    geometry: Geometry,
    joints: Vec<[u16; 4]>,
    weights: Vec<[f32; 4]>,
}

impl Skin {
    /// Assigns the geometry that `add` adds to one joint.
    fn part(&mut self, joint: usize, add: impl FnOnce(&mut Geometry)) {
        add(&mut self.geometry);
        let count = self.geometry.vertices();
        self.joints.resize(count, [joint as u16, 0, 0, 0]);
        self.weights.resize(count, [1.0, 0.0, 0.0, 0.0]);
    }

    /// Hangs the geometry that `add` adds from the hips; it follows the thighs the more, the lower it is.
    fn skirt(&mut self, add: impl FnOnce(&mut Geometry)) {
        add(&mut self.geometry);
        for vertex in &self.geometry.positions()[self.joints.len()..] {
            let low = ((0.95 - vertex.y) / 0.5).clamp(0.0, 1.0) * 0.7;
            let left = ((vertex.x + 0.12) / 0.24).clamp(0.0, 1.0);
            let thighs = [LEFT_THIGH as u16, RIGHT_THIGH as u16];
            self.joints.push([HIPS as u16, thighs[0], thighs[1], 0]);
            self.weights
                .push([1.0 - low, low * left, low * (1.0 - left), 0.0]);
        }
    }
}

/// Someone in a coat, with a hat or bareheaded.
pub fn mesh(is_bareheaded: bool) -> Mesh {
    let mut skin = Skin::default();
    let v = |[x, y, z]: [f32; 3]| Vec3::new(x, y, z);
    skin.part(HEAD, |part| {
        part.ball(v([0.0, 1.62, 0.01]), v([0.095, 0.13, 0.11]), 20);
        part.bar(v([0.0, 1.42, 0.0]), v([0.0, 1.56, 0.0]), 0.05, 12);
        if !is_bareheaded {
            part.cone(v([0.0, 1.67, 0.0]), v([0.0, 1.69, 0.0]), [0.19, 0.12], 20);
            part.cone(v([0.0, 1.68, 0.0]), v([0.0, 1.8, 0.0]), [0.115, 0.09], 20);
            part.ball(v([0.0, 1.8, 0.0]), v([0.09, 0.03, 0.09]), 20);
        }
    });
    skin.part(CHEST, |part| {
        part.ball(v([0.0, 1.27, 0.0]), v([0.2, 0.24, 0.13]), 20);
        part.ball(v([0.0, 1.4, 0.0]), v([0.22, 0.08, 0.1]), 20);
    });
    skin.part(HIPS, |part| {
        part.ball(v([0.0, 1.0, 0.0]), v([0.17, 0.17, 0.125]), 20);
    });
    skin.skirt(|part| {
        for ring in 0..4 {
            let up = |ring: i32| 1.05 - 0.15 * ring as f32;
            let wide = |ring: i32| 0.165 + 0.018 * ring as f32;
            let (top, below) = (v([0.0, up(ring), 0.0]), v([0.0, up(ring + 1), 0.0]));
            part.cone(below, top, [wide(ring + 1), wide(ring)], 20);
        }
    });
    for (sign, arm, forearm, thigh, shin) in [
        (1.0, LEFT_ARM, LEFT_FOREARM, LEFT_THIGH, LEFT_SHIN),
        (-1.0, RIGHT_ARM, RIGHT_FOREARM, RIGHT_THIGH, RIGHT_SHIN),
    ] {
        skin.part(arm, |part| {
            part.ball(v([0.21 * sign, 1.39, 0.0]), v([0.07, 0.07, 0.07]), 14);
            let (low, high) = (v([0.23 * sign, 1.11, 0.0]), v([0.215 * sign, 1.4, 0.0]));
            part.cone(low, high, [0.05, 0.065], 14);
        });
        skin.part(forearm, |part| {
            part.ball(v([0.23 * sign, 1.11, 0.0]), v([0.05, 0.05, 0.05]), 14);
            let (low, high) = (v([0.235 * sign, 0.86, 0.0]), v([0.23 * sign, 1.11, 0.0]));
            part.cone(low, high, [0.04, 0.05], 14);
            part.ball(v([0.235 * sign, 0.82, 0.01]), v([0.035, 0.06, 0.045]), 14);
        });
        skin.part(thigh, |part| {
            let (low, high) = (v([0.1 * sign, 0.46, 0.0]), v([0.095 * sign, 0.9, 0.0]));
            part.cone(low, high, [0.06, 0.085], 14);
        });
        skin.part(shin, |part| {
            part.ball(v([0.1 * sign, 0.46, 0.0]), v([0.06, 0.06, 0.06]), 14);
            let (low, high) = (v([0.1 * sign, 0.07, 0.0]), v([0.1 * sign, 0.46, 0.0]));
            part.cone(low, high, [0.045, 0.06], 14);
            part.ball(v([0.1 * sign, 0.05, 0.05]), v([0.05, 0.05, 0.13]), 14);
        });
    }
    let Skin {
        geometry,
        joints,
        weights,
    } = skin;
    geometry
        .mesh()
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_JOINT_INDEX,
            VertexAttributeValues::Uint16x4(joints),
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights)
}
