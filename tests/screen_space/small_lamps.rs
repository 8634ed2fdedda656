//! Evenness of diffuse GI: light of lamps of a few pixels, which few directions of a texel meet, and of a panel.

use bevy::prelude::*;
use bevy_lean_deferred::prelude::*;
use kit::{
    analytic_light::{Seen, camera, surface},
    headless::Headless,
    own_process::in_own_process,
};

use super::scenes::{EYE, SIZE, gi, looking, show_next};

const LAMP: Vec3 = Vec3::new(0.0, 0.35, 0.0);
/// Middle of a glowing panel on the floor.
const PANEL: Vec3 = Vec3::new(0.2, 0.0, -0.3);
/// Wall behind both.
const WALL: f32 = -0.8;
/// Pixels to each side of a pixel over which the local mean is taken: three blocks of the pattern.
const WINDOW: u32 = 12;

/// A glowing ball before a wall.
fn lamp(headless: &mut Headless, radius: f32, light: f32, quality: LeanQuality) -> Seen {
    show_next(headless, 3, |s| {
        let floor = Plane3d::default().mesh().size(12.0, 12.0);
        s.mesh(floor, surface(0.5, 0.0), Transform::default());
        let wall = Transform::from_xyz(0.0, 0.75, WALL);
        s.mesh(Rectangle::new(6.0, 1.5), surface(0.5, 0.0), wall);
        let ball = Sphere::new(radius).mesh().ico(6).expect("few subdivisions");
        let place = Transform::from_translation(LAMP);
        s.mesh(ball, surface(0.0, light), place);
        let effect = LeanScreenSpaceGi { quality, ..gi() };
        camera(s, looking(EYE, 0.3), 0.0, effect);
    })
}

/// Differences between light and its local mean, as shares of the mean.
#[derive(Debug)]
struct Unevenness {
    rms: f32,
    largest: f32,
}

/// Of the light on a plane, divided by that of a far ball: cos / D². `is_compared` of pixels on the plane, for all of the window.
fn unevenness(
    seen: &Seen,
    point: Vec3,
    normal: Vec3,
    is_compared: impl Fn(Vec3, f32) -> bool,
) -> Unevenness {
    let size = seen.light.size;
    let index = |pixel: UVec2| (pixel.y * size.x + pixel.x) as usize;
    let mut ratios = vec![None; size.element_product() as usize];
    for (pixel, place, light) in seen.on_plane(point, normal) {
        let ray = seen.rays()[index(pixel)];
        let off_lamp = ray.direction.cross(LAMP - ray.origin).length();
        if is_compared(place, off_lamp) {
            let distance = place.distance(LAMP);
            ratios[index(pixel)] = Some(light * distance.powi(3) / normal.dot(LAMP - place));
        }
    }
    unevenness_within(WINDOW, size, &ratios)
}

/// Mean of `values` of a picture of this size within `reach` pixels to each side of a pixel, where all of these are known.
fn mean_around(reach: u32, size: UVec2, values: &[Option<f32>], pixel: UVec2) -> Option<f32> {
    if pixel.min_element() < reach || (pixel + reach).cmpge(size).any() {
        return None;
    }
    let rows = pixel.y - reach..=pixel.y + reach;
    let around = rows.flat_map(|y| {
        (pixel.x - reach..=pixel.x + reach).map(move |x| values[(y * size.x + x) as usize])
    });
    let sum: Option<f32> = around.sum();
    let side = (2 * reach + 1) as f32;
    sum.map(|sum| sum / (side * side))
}

/// Pixels of a picture of this size, row by row.
fn pixels(size: UVec2) -> impl Iterator<Item = UVec2> {
    (0..size.y).flat_map(move |y| (0..size.x).map(move |x| UVec2::new(x, y)))
}

/// Of `values` of a picture of this size, against their means within `window` pixels to each side, where all of these are known.
fn unevenness_within(window: u32, size: UVec2, values: &[Option<f32>]) -> Unevenness {
    let mut off = Vec::new();
    for (pixel, own) in pixels(size).zip(values) {
        let Some(own) = own else {
            continue;
        };
        if let Some(mean) = mean_around(window, size, values, pixel) {
            off.push(own / mean - 1.0);
        }
    }
    assert!(off.len() > 300, "{} pixels are compared", off.len());
    let squares: f32 = off.iter().map(|off| off * off).sum();
    Unevenness {
        rms: (squares / off.len() as f32).sqrt(),
        largest: off.iter().map(|off| off.abs()).fold(0.0, f32::max),
    }
}

/// Light of lamps 0.3 m and 0.1 m wide is even: no texels, blocks or streaks are visible.
fn check_lamps(lamps: impl IntoIterator<Item = (f32, f32, LeanQuality, [f32; 2])>) {
    let mut headless = Headless::new(SIZE);
    for (radius, light, quality, [rms, largest]) in lamps {
        let seen = lamp(&mut headless, radius, light, quality);
        seen.save(&format!("lamp_{radius}_{light}_{quality:?}"), 8.0 / light);
        // Screen-space light ends where half of the picture's height does.
        let is_reached = |place: Vec3, most: f32| place.distance(LAMP) + radius < most;
        let on_floor = unevenness(&seen, Vec3::ZERO, Vec3::Y, |place, off_lamp| {
            place.z > 0.02 && off_lamp > 1.5 * radius.max(0.1) && is_reached(place, 0.85)
        });
        let on_wall = unevenness(&seen, Vec3::Z * WALL, Vec3::Z, |place, off_lamp| {
            let is_wall = (0.03..1.45).contains(&place.y);
            is_wall && off_lamp > 2.5 * radius.max(0.1) && is_reached(place, 1.2)
        });
        println!(
            "{radius} m, light {light}, {quality:?}: floor {on_floor:.3?}, wall {on_wall:.3?}"
        );
        for found in [on_floor, on_wall] {
            assert!(found.rms < rms && found.largest < largest, "{found:?}");
        }
    }
}

#[test]
fn light_of_a_small_lamp_is_even() {
    in_own_process(|| {
        check_lamps([
            (0.15, 8.0, LeanQuality::Medium, [0.03, 0.1]),
            (0.05, 200.0, LeanQuality::Medium, [0.18, 0.6]),
        ]);
    });
}

#[test]
#[ignore = "nightly: further qualities and lights"]
fn light_of_further_small_lamps_is_even() {
    in_own_process(|| {
        check_lamps([
            (0.15, 200.0, LeanQuality::Medium, [0.03, 0.1]),
            (0.15, 8.0, LeanQuality::High, [0.055, 0.2]),
            (0.05, 8.0, LeanQuality::High, [0.25, 1.0]),
        ]);
    });
}

/// In light from a part of the hemisphere, neither the filter's texels are visible, as a weave, nor the directions of the gathered
/// texels, as blotches.
#[test]
fn light_of_a_panel_has_no_weave_and_no_blotches() {
    in_own_process(|| {
        let mut headless = Headless::new(SIZE);
        for quality in [LeanQuality::Medium, LeanQuality::High] {
            let seen = show_next(&mut headless, 3, |s| {
                let wall = Transform::from_xyz(0.0, 1.5, WALL);
                s.mesh(Rectangle::new(6.0, 3.0), surface(0.5, 0.0), wall);
                let panel = Plane3d::default().mesh().size(0.8, 0.5);
                s.mesh(panel, surface(0.0, 4.0), Transform::from_translation(PANEL));
                let effect = LeanScreenSpaceGi { quality, ..gi() };
                camera(s, looking(EYE, 0.6), 0.0, effect);
            });
            seen.save(&format!("panel_{quality:?}"), 1.0);
            let size = seen.light.size;
            let mut values = vec![None; size.element_product() as usize];
            for (pixel, place, light) in seen.on_plane(Vec3::Z * WALL, Vec3::Z) {
                // Not where screen-space light ends.
                if place.y > 0.1 && place.distance(PANEL) < 0.95 {
                    values[(pixel.y * size.x + pixel.x) as usize] = Some(light);
                }
            }
            let weave = unevenness_within(3, size, &values);
            let means: Vec<Option<f32>> = pixels(size)
                .map(|pixel| mean_around(2, size, &values, pixel))
                .collect();
            let blotches = unevenness_within(10, size, &means);
            println!("panel, {quality:?}: weave {weave:.4?}, blotches {blotches:.4?}");
            assert!(weave.rms < 0.0025, "weave: {weave:?}");
            assert!(blotches.rms < 0.011, "blotches: {blotches:?}");
        }
    });
}
