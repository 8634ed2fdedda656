//! Light of things that move with the camera: a weapon, a cockpit, a followed character.

use bevy::prelude::*;
use kit::{
    analytic_light::{Seen, camera, look_at_once, see, surface},
    analytic_mirrors::metal,
    headless::Headless,
    lean::{change_cameras, show},
    own_process::in_own_process,
};

use super::scenes::{SMALL, gi, move_cameras, reflections, with_motion};

/// Distance of the weapon from the camera, in metres.
const DISTANCE: f32 = 0.5;
/// In radians: a pixel is as wide as at 540 rows and 45°, so that tolerances, which grow with it, are as narrow.
const FIELD_OF_VIEW: f32 = 0.22;
/// Frames per second.
const RATE: f32 = 60.0;
const FRAMES: usize = 8;

/// Two plates on the camera that meet at a right angle: the left one glows, and the right one is lit by it in its upper half and
/// mirrors it in the lower one.
fn show_weapon(headless: &mut Headless, motion: bool) {
    show(headless, |s| {
        let wall = Transform::from_xyz(0.0, 0.0, -12.0);
        s.mesh(Rectangle::new(20.0, 20.0), surface(0.5, 0.05), wall);
        let camera = camera(s, Transform::default(), 0.0, (gi(), reflections()));
        let projection = PerspectiveProjection {
            fov: FIELD_OF_VIEW,
            ..default()
        };
        let mut of_camera = s.world().entity_mut(camera);
        of_camera.insert(Projection::Perspective(projection));
        with_motion(motion, &mut of_camera);
        let plates = [
            (-1.0, 0.0, 0.16, surface(0.0, 1.0)),
            (1.0, 0.04, 0.08, surface(0.5, 0.0)),
            (1.0, -0.04, 0.08, metal(0.0)),
        ];
        for (side, height, tall, material) in plates {
            let place = Transform::from_xyz(0.025 * side, height, -DISTANCE)
                .with_rotation(Quat::from_rotation_y(-side * core::f32::consts::FRAC_PI_4));
            let plate = s.mesh(Rectangle::new(0.0707, tall), material, place);
            s.world().entity_mut(camera).add_child(plate);
        }
    });
}

/// Mean light of the two halves of the right plate.
fn light_of_plate(seen: &Seen) -> [f32; 2] {
    let size = seen.light.size;
    let columns = size.x * 58 / 100..size.x * 70 / 100;
    [(15, 40), (60, 85)].map(|(above, below)| {
        let rows = size.y * above / 100..size.y * below / 100;
        let pixels = rows.flat_map(|y| columns.clone().map(move |x| UVec2::new(x, y)));
        let (sum, count) = pixels.fold((0.0, 0), |(sum, count), pixel| {
            (sum + seen.at(pixel), count + 1)
        });
        sum / count as f32
    })
}

/// The light in each of some frames of a walk, relative to that at rest.
fn walk(headless: &mut Headless, velocity: Vec3) -> Vec<[f32; 2]> {
    let at_rest = light_of_plate(&see(headless, 8));
    assert!(at_rest.iter().all(|light| *light > 0.05), "{at_rest:?}");
    let mut shares = Vec::new();
    for frame in 0..FRAMES + 3 {
        move_cameras(headless, velocity / RATE);
        let light = light_of_plate(&look_at_once(headless));
        // The first frames may have no motion target yet.
        if frame >= 3 {
            shares.push([0, 1].map(|i| light[i] / at_rest[i]));
        }
    }
    change_cameras(headless, |camera| {
        let mut transform = camera.get_mut::<Transform>().expect("cameras have one");
        transform.translation = Vec3::ZERO;
    });
    shares
}

/// Walking and running, forwards and at an angle.
const VELOCITIES: [Vec3; 3] = [
    Vec3::new(0.0, 0.0, -1.5),
    Vec3::new(0.0, 0.0, -6.0),
    Vec3::new(4.2, 0.6, -4.2),
];

#[test]
fn weapons_keep_their_light() {
    in_own_process(|| check_weapons(true));
}

/// Without motion vectors their light neither vanishes nor flickers.
#[test]
fn weapons_keep_their_light_without_motion_vectors() {
    in_own_process(|| check_weapons(false));
}

fn check_weapons(motion: bool) {
    let mut headless = Headless::new(SMALL);
    show_weapon(&mut headless, motion);
    // The motion target comes with the first mesh that moves: forward draws all of them until its pipelines are compiled.
    walk(&mut headless, VELOCITIES[0]);
    headless.settle();
    for velocity in VELOCITIES {
        let shares = walk(&mut headless, velocity);
        for (i, name) in ["diffuse", "mirror"].into_iter().enumerate() {
            let of_plate = shares.iter().map(|share| share[i]);
            let least = of_plate.clone().fold(f32::INFINITY, f32::min);
            let most = of_plate.fold(0.0, f32::max);
            let pairs = shares.windows(2);
            let change = pairs.map(|pair| (pair[1][i] - pair[0][i]).abs());
            let change = change.fold(0.0, f32::max);
            println!(
                "{name}, motion vectors {motion}, {velocity} m/s: {least:.3} to {most:.3} of the light at rest, {change:.3} from frame to frame"
            );
            assert!(least >= if motion { 0.9 } else { 0.8 } && most < 1.2);
            assert!(change < 0.05);
        }
    }
}
