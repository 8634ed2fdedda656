//! The places of the camera, and its way from one to the next.

use core::f32::consts::{PI, TAU};

use bevy::prelude::*;
use bevy_panorbit_camera::PanOrbitCamera;

use kit::example::model::{self, Viewpoint};

/// Distance from the camera to the point that it orbits: short, so that it looks around and stays within the walls.
const DISTANCE: f32 = 0.4;
/// Duration of the way from one place to the next, in seconds.
const DURATION: f32 = 2.0;

/// The place where the camera is, or that it moves to.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// In front of the corner with the lamp.
    Dark,
    /// In view of both the corner and the door.
    Room,
    /// At the door, looking out.
    Door,
}

pub const PLACES: [Place; 3] = [Place::Dark, Place::Room, Place::Door];

/// Order in which Space visits them: the straight lines between neighbours hit no wall.
const ROUND: [Place; 4] = [Place::Dark, Place::Room, Place::Door, Place::Room];

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

pub fn stand(place: Res<Place>, camera: Single<(&mut Transform, &mut PanOrbitCamera)>) {
    let (mut transform, mut orbit) = camera.into_inner();
    place.pose().take(&mut transform, &mut orbit);
}

/// Present while the camera moves.
#[derive(Resource)]
pub struct Walk {
    from: Pose,
    seconds: f32,
}

pub fn read_keys(
    mut commands: Commands,
    keys: Res<ButtonInput<KeyCode>>,
    orbit: Single<&PanOrbitCamera>,
    mut place: ResMut<Place>,
    mut visited: Local<Option<usize>>,
) {
    if !keys.just_pressed(KeyCode::Space) {
        return;
    }
    let here = visited
        .or_else(|| ROUND.iter().position(|other| other == &*place))
        .unwrap_or(0);
    let next = (here + 1) % ROUND.len();
    *visited = Some(next);
    *place = ROUND[next];
    commands.insert_resource(Walk {
        from: Pose::of(&orbit),
        seconds: 0.0,
    });
}

pub fn walk(
    mut commands: Commands,
    time: Res<Time>,
    place: Res<Place>,
    walk: Option<ResMut<Walk>>,
    camera: Single<(&mut Transform, &mut PanOrbitCamera)>,
) {
    let Some(mut walk) = walk else {
        return;
    };
    walk.seconds += time.delta_secs();
    let t = (walk.seconds / DURATION).min(1.0);
    let (mut transform, mut orbit) = camera.into_inner();
    let smooth = t * t * (3.0 - 2.0 * t);
    walk.from
        .lerp(place.pose(), smooth)
        .take(&mut transform, &mut orbit);
    if t >= 1.0 {
        commands.remove_resource::<Walk>();
    }
}
