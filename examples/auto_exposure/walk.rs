//! The places of the camera, and its way from one to the next.

use core::f32::consts::{PI, TAU};

use bevy::prelude::*;
use bevy_panorbit_camera::PanOrbitCamera;

use crate::settings::House;
use kit::example::model::{self, Viewpoint};

/// Distance from the camera to the point that it orbits: short, so that it looks around and stays within the walls.
const DISTANCE: f32 = 0.4;
/// Duration of the way from one place to the next, in seconds.
const DURATION: f32 = 2.0;

/// A place of the camera.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Place {
    /// In front of the corner with the lamp.
    #[default]
    Dark,
    /// In view of both the corner and the door.
    Room,
    /// At the door, looking out.
    Door,
}

pub const PLACES: [Place; 3] = [Place::Dark, Place::Room, Place::Door];

/// Position and direction of the camera.
#[derive(Clone, Copy)]
struct Pose {
    focus: Vec3,
    yaw: f32,
    pitch: f32,
}

impl Place {
    fn pose(self) -> Pose {
        let (eye, at) = match self {
            Self::Dark => ([-1.1, 1.55, -0.3], [-2.3, 0.85, -4.2]),
            Self::Room => ([-0.5, 1.6, 2.2], [1.2, 1.2, -5.0]),
            Self::Door => ([1.2, 1.6, -4.4], [1.5, 1.5, -9.0]),
        };
        let eye = Vec3::from(eye);
        let back = (eye - Vec3::from(at)).normalize();
        Pose {
            focus: eye - back * DISTANCE,
            yaw: back.x.atan2(back.z),
            pitch: back.y.asin(),
        }
    }
}

impl Pose {
    fn of(orbit: &PanOrbitCamera) -> Self {
        Self {
            focus: orbit.focus,
            yaw: orbit.target_yaw,
            pitch: orbit.target_pitch,
        }
    }

    /// Interpolates, taking the shorter way round.
    fn lerp(self, to: Self, t: f32) -> Self {
        let turn = (to.yaw - self.yaw + PI).rem_euclid(TAU) - PI;
        Self {
            focus: self.focus.lerp(to.focus, t),
            yaw: self.yaw + turn * t,
            pitch: self.pitch + (to.pitch - self.pitch) * t,
        }
    }

    fn take(self, transform: &mut Transform, orbit: &mut PanOrbitCamera) {
        let viewpoint = Viewpoint {
            yaw: self.yaw,
            pitch: self.pitch,
            zoom: 1.0,
        };
        model::stand(transform, orbit, self.focus, viewpoint, DISTANCE);
    }
}

pub fn stand(camera: Single<(&House, &mut Transform, &mut PanOrbitCamera)>) {
    let (house, mut transform, mut orbit) = camera.into_inner();
    house.place.pose().take(&mut transform, &mut orbit);
}

/// Present while the camera moves.
#[derive(Resource)]
pub struct Walk {
    from: Pose,
    /// On the way: walls are between the corner and the door.
    via: Option<Pose>,
    seconds: f32,
}

/// Sets off when the panel has another place.
pub fn set_off(
    mut commands: Commands,
    camera: Single<(&House, &PanOrbitCamera), Changed<House>>,
    mut place: Local<Option<Place>>,
) {
    let (house, orbit) = *camera;
    let Some(before) = place.replace(house.place) else {
        return;
    };
    if before != house.place {
        let is_far = before != Place::Room && house.place != Place::Room;
        commands.insert_resource(Walk {
            from: Pose::of(orbit),
            via: is_far.then(|| Place::Room.pose()),
            seconds: 0.0,
        });
    }
}

pub fn walk(
    mut commands: Commands,
    time: Res<Time>,
    walk: Option<ResMut<Walk>>,
    camera: Single<(&House, &mut Transform, &mut PanOrbitCamera)>,
) {
    let Some(mut walk) = walk else {
        return;
    };
    walk.seconds += time.delta_secs();
    let t = (walk.seconds / DURATION).min(1.0);
    let (house, mut transform, mut orbit) = camera.into_inner();
    let smooth = t * t * (3.0 - 2.0 * t);
    let to = house.place.pose();
    let pose = match walk.via {
        None => walk.from.lerp(to, smooth),
        Some(via) if smooth < 0.5 => walk.from.lerp(via, 2.0 * smooth),
        Some(via) => via.lerp(to, 2.0 * smooth - 1.0),
    };
    pose.take(&mut transform, &mut orbit);
    if t >= 1.0 {
        commands.remove_resource::<Walk>();
    }
}
