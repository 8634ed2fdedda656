//! The scenes: one to time, and two whose occlusion is known.

use bevy::{light::AmbientLight, math::DVec3, prelude::*};

use kit::{
    headless::Headless,
    occlusion::{
        camera::{Camera, Projection as TruthProjection},
        depth_buffer::DepthBuffer,
        geometry::{Geometry, Scene},
    },
    scenes::boxes::{self, Boxes},
};

/// Radius of all contenders, in metres. Bevy's own is fixed.
pub const RADIUS: f64 = 0.5;

/// A scene of the bench.
#[derive(Clone, Copy)]
pub enum BenchScene {
    /// The boxes of the bench `frame_times`.
    Boxes(Boxes),
    /// A floor before an endless wall.
    Wall,
    /// A floor that reaches from 3 m to 100 m.
    Plane,
    /// A floor that fills the view of an eye this many metres above it, which looks down by 45°.
    Floor(f64),
}

impl BenchScene {
    pub fn name(self) -> &'static str {
        match self {
            Self::Boxes(_) => "boxes",
            Self::Wall => "wall",
            Self::Plane => "plane",
            Self::Floor(_) => "floor",
        }
    }

    fn geometry(self) -> Option<(Geometry, DVec3, DVec3)> {
        match self {
            Self::Boxes(_) => None,
            Self::Wall => Some((
                Geometry::Wall {
                    height: f64::INFINITY,
                },
                DVec3::new(3.0, 2.5, 3.0),
                DVec3::new(0.0, 0.3, 0.0),
            )),
            Self::Plane => Some((
                Geometry::Plane {
                    point: DVec3::ZERO,
                    normal: DVec3::Y,
                },
                DVec3::new(0.0, 2.0, 0.0),
                DVec3::new(0.0, 0.0, -6.0),
            )),
            Self::Floor(eye) => Some((
                Geometry::Plane {
                    point: DVec3::ZERO,
                    normal: DVec3::Y,
                },
                DVec3::new(0.0, eye, 0.0),
                DVec3::new(0.0, 0.0, -eye),
            )),
        }
    }

    /// Spawns everything but the camera, and returns the camera's transform.
    pub fn spawn(self, headless: &mut Headless) -> Transform {
        if let Self::Boxes(boxes) = self {
            boxes::spawn_into(headless.world(), boxes);
            return boxes::camera_transform(boxes);
        }
        let (geometry, eye, target) = self.geometry().expect("all but the boxes have one");
        let world = headless.world();
        let half_space = Plane3d::default().mesh().size(400.0, 400.0);
        let mesh = world.resource_mut::<Assets<Mesh>>().add(half_space);
        let material = world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(StandardMaterial::default());
        world.spawn((Mesh3d(mesh.clone()), MeshMaterial3d(material.clone())));
        if matches!(geometry, Geometry::Wall { .. }) {
            world.spawn((
                Mesh3d(mesh),
                MeshMaterial3d(material),
                Transform::from_rotation(Quat::from_rotation_z(-core::f32::consts::FRAC_PI_2)),
            ));
        }
        Transform::from_translation(eye.as_vec3()).looking_at(target.as_vec3(), Vec3::Y)
    }

    /// Closed form at each pixel, and the mask of pixels to compare.
    pub fn truth(self, size: UVec2) -> Option<(Vec<Option<f32>>, Vec<bool>)> {
        let (geometry, eye, target) = self.geometry()?;
        let camera = Camera::looking_at(
            eye,
            target,
            DVec3::Y,
            TruthProjection::Perspective {
                fov_y: std::f64::consts::FRAC_PI_4,
                near: 0.1,
            },
            size,
        );
        let scene = Scene::new(geometry);
        let buffer = DepthBuffer::new(camera, &scene);
        Some((buffer.truth(&scene, RADIUS), buffer.interior(8, RADIUS)))
    }
}

/// Ambient light for the occlusion to act on.
pub fn ambient() -> AmbientLight {
    AmbientLight {
        brightness: 500.0,
        ..default()
    }
}
