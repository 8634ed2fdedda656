//! Fog is seen once: on the way over a mirror, and in front of meshes that forward draws.

use bevy::{
    core_pipeline::prepass::DepthPrepass,
    pbr::{DistanceFog, FogFalloff},
    prelude::*,
};
use kit::{
    analytic_light::{Errors, Seen, camera, surface},
    analytic_mirrors::metal,
    headless::Headless,
    own_process::in_own_process,
};

use super::scenes::{
    SMALL, floor, gi, glowing, looking, mirrored, reflections, show_next, spawn_floor,
};

/// Fog of this light.
fn fog(light: f32, falloff: FogFalloff) -> DistanceFog {
    DistanceFog {
        color: Color::linear_rgb(light, light, light),
        falloff,
        ..default()
    }
}

const EYE: Vec3 = Vec3::new(0.0, 1.2, 0.0);

/// A glowing wall of this size at the end of a metal floor, in fog.
fn show_wall(
    headless: &mut Headless,
    size: Vec2,
    distance: f32,
    roughness: f32,
    extra: impl Bundle,
) -> Seen {
    show_next(headless, 6, |s| {
        let plane = Plane3d::default().mesh().size(200.0, 200.0);
        s.mesh(plane, metal(roughness), Transform::default());
        let at = Transform::from_xyz(0.0, 0.5 * size.y, -distance);
        s.mesh(Rectangle::from_size(size), surface(0.0, 1.0), at);
        let from = Transform::from_translation(EYE);
        camera(s, from, 0.0, (reflections(), extra));
    })
}

#[test]
fn mirrored_light_is_fogged_once() {
    in_own_process(|| {
        let mut headless = Headless::new(SMALL);
        let exponential = |metres: f32| (-0.035 * metres).exp();
        let squared = |metres: f32| (-(0.03 * metres).powi(2)).exp();
        let linear = |metres: f32| ((60.0 - metres) / (60.0 - 2.0)).clamp(0.0, 1.0);
        type Transmittance = fn(f32) -> f32;
        let cases: [(f32, f32, FogFalloff, Transmittance); 5] = [
            (
                7.0,
                0.0,
                FogFalloff::Exponential { density: 0.035 },
                exponential,
            ),
            (
                12.0,
                0.0,
                FogFalloff::Exponential { density: 0.035 },
                exponential,
            ),
            (
                19.0,
                0.3,
                FogFalloff::Exponential { density: 0.035 },
                exponential,
            ),
            (
                12.0,
                0.3,
                FogFalloff::ExponentialSquared { density: 0.03 },
                squared,
            ),
            (
                19.0,
                0.3,
                FogFalloff::Linear {
                    start: 2.0,
                    end: 60.0,
                },
                linear,
            ),
        ];
        for (distance, light, falloff, transmittance) in cases {
            let size = distance * Vec2::new(1.0, 0.3);
            let name = format!("{distance} m, {falloff:?} of {light}");
            let seen = show_wall(&mut headless, size, distance, 0.0, fog(light, falloff));
            seen.save(&format!("fog_{distance}_{light}"), 1.0);
            let off = floor(&seen).filter_map(|(place, found)| {
                let direction = mirrored(EYE, place);
                let at = place + direction * (-distance - place.z) / direction.z;
                let is_inside = at.x.abs() < 0.45 * size.x && (0.1..0.9).contains(&(at.y / size.y));
                let left = transmittance(EYE.distance(place) + place.distance(at));
                let truth = left + light * (1.0 - left);
                (place.z > -distance && is_inside).then_some(found / truth - 1.0)
            });
            let off: Vec<f32> = off.collect();
            let count = off.len();
            let errors = Errors::of(off);
            println!("{name}: {errors:.4?} of {count} pixels");
            assert!(count > 100 && errors.rmse < 0.03);
        }
    });
}

/// The rays of a rough floor's lobe are fogged too: close to a wall they are about as long as the mirrored ray.
#[test]
fn light_on_rough_floors_is_fogged_once() {
    in_own_process(|| {
        const DISTANCE: f32 = 12.0;
        let mut headless = Headless::new(SMALL);
        let falloff = FogFalloff::Exponential { density: 0.05 };
        let [clear, fogged] = [0.0, 1.0].map(|share| {
            let fog = DistanceFog {
                color: Color::linear_rgba(0.0, 0.0, 0.0, share),
                falloff: falloff.clone(),
                ..default()
            };
            let size = Vec2::new(40.0, 20.0);
            show_wall(&mut headless, size, DISTANCE, 0.3, fog)
        });
        fogged.save("fog_rough", 1.0);
        let off = floor(&clear)
            .zip(floor(&fogged))
            .filter_map(|((place, clear), (_, fogged))| {
                let metres = EYE.distance(place) + DISTANCE + place.z;
                let is_close = (-DISTANCE + 0.3..-DISTANCE + 2.0).contains(&place.z);
                (is_close && place.x.abs() < 2.0)
                    .then(|| fogged / clear / (-0.05 * metres).exp() - 1.0)
            });
        let off: Vec<f32> = off.collect();
        let count = off.len();
        let errors = Errors::of(off);
        println!("{errors:.4?} of {count} pixels");
        assert!(count > 50 && errors.rmse < 0.04);
    });
}

/// Light of forward meshes is handed to GI without the fog in front of them, like that of other meshes.
#[test]
fn gi_has_no_fog_in_front_of_forward_meshes() {
    in_own_process(|| {
        let mut headless = Headless::new(SMALL);
        let mut sum = |forward: bool, light: f32| {
            let seen = show_next(&mut headless, 8, |s| {
                spawn_floor(s, surface(0.5, 0.0), 0.0);
                let wall = Rectangle::new(2.0, 0.8);
                s.mesh(wall, glowing(forward), Transform::from_xyz(0.0, 0.4, 0.0));
                let fog = fog(light, FogFalloff::Exponential { density: 0.15 });
                let from = looking(Vec3::new(0.0, 1.2, 3.0), 0.3);
                camera(s, from, 0.0, (gi(), DepthPrepass, fog));
            });
            seen.save(&format!("fog_gi_{forward}_{light}"), 1.0);
            let near = floor(&seen).filter(|(place, _)| place.z > 0.05);
            near.map(|(_, light)| light).sum::<f32>()
        };
        for light in [0.0, 0.3] {
            let [lean, forward] = [false, true].map(|forward| sum(forward, light));
            println!("fog of {light}: lean {lean:.2}, forward {forward:.2}");
            assert!(lean > 1.0 && (forward / lean - 1.0).abs() < 0.02);
        }
    });
}
