//! Atmosphere: its transmittance on lights, and its sky behind and in front of lean meshes, against Bevy forward.
//!
//! Mesa 22's llvmpipe crashes in Bevy's own atmosphere passes, with or without this crate, so there is no reference.

use bevy::{
    light::{Atmosphere, atmosphere::ScatteringMedium, light_consts::lux},
    pbr::AtmosphereSettings,
    prelude::*,
    render::{RenderApp, renderer::RenderAdapterInfo},
};
use bevy_lean_deferred::prelude::*;
use kit::{
    hdr::settled_light,
    headless::Headless,
    lean::{change_cameras, judge, report, set_lean, settled},
    metrics::pixel_difference,
    own_process::in_own_process,
    scenes::{LEAST_PSNR, SceneBuilder},
};
use wgpu::DeviceType;

fn crashes(headless: &Headless) -> bool {
    let render_world = headless.app.sub_app(RenderApp).world();
    let adapter = render_world.resource::<RenderAdapterInfo>();
    adapter.device_type == DeviceType::Cpu && adapter.driver_info.starts_with("Mesa 22")
}

/// The scene of `spawn` under a sun `elevation` radians above the horizon, in air in which a unit of length is `metres` metres.
fn build(elevation: f32, metres: f32, spawn: impl Fn(&mut SceneBuilder)) -> Option<Headless> {
    let mut headless = Headless::new(UVec2::new(320, 240));
    if crashes(&headless) {
        println!("skipped: atmosphere: Mesa 22 crashes in Bevy's own passes");
        return None;
    }
    let mut scene = SceneBuilder {
        headless: &mut headless,
    };
    spawn(&mut scene);
    scene.spawn((
        DirectionalLight {
            illuminance: lux::RAW_SUNLIGHT,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_rotation(Quat::from_euler(EulerRot::YXZ, 0.6, -elevation, 0.0)),
    ));
    let medium = scene.add::<ScatteringMedium>(ScatteringMedium::default());
    let air = Atmosphere::earth(medium);
    let ground = Vec3::NEG_Y * air.inner_radius / metres;
    let placed = Transform::from_translation(ground).with_scale(Vec3::splat(1.0 / metres));
    scene.spawn((air, placed));
    scene.default_camera((
        AtmosphereSettings::default(),
        bevy::camera::Exposure { ev100: 13.0 },
    ));
    Some(headless)
}

#[test]
fn atmosphere_matches_forward() {
    in_own_process(|| {
        report([0.05, 0.8].into_iter().filter_map(|elevation| {
            let mut headless = build(elevation, 1.0, |scene| scene.solids())?;
            let forward = settled(&mut headless);
            set_lean(&mut headless, true);
            let lean = settled(&mut headless);
            let name = format!("atmosphere_{elevation}");
            Some(judge(&name, &forward, &lean, LEAST_PSNR))
        }));
    });
}

/// With the sun overhead its cosine to the zenith is slightly above 1 in some places: no NaN results.
#[test]
fn a_sun_overhead_makes_no_nan() {
    in_own_process(|| {
        let overhead = core::f32::consts::FRAC_PI_2;
        let Some(mut headless) = build(overhead, 1.0, |scene| scene.solids()) else {
            return;
        };
        let forward = settled(&mut headless);
        let forward_broken = settled_light(&mut headless).not_finite();
        set_lean(&mut headless, true);
        let lean = settled(&mut headless);
        let lean_broken = settled_light(&mut headless).not_finite();
        println!("not finite: forward {forward_broken}, lean {lean_broken} pixels");
        assert_eq!(lean_broken, 0);
        if forward_broken == 0 {
            report([judge("sun_overhead", &forward, &lean, LEAST_PSNR)]);
        }
    });
}

/// Occlusion does not darken the air: black meshes show only the light of the air in front of them.
#[test]
fn occlusion_does_not_darken_the_air() {
    in_own_process(|| {
        let shown = |color: Color| {
            let spawn = |scene: &mut SceneBuilder| {
                let material = StandardMaterial {
                    base_color: color,
                    unlit: true,
                    ..default()
                };
                let floor = Plane3d::default().mesh().size(12.0, 12.0);
                scene.mesh(floor, material.clone(), Transform::default());
                for x in [-1.0, 0.0, 1.0] {
                    let place = Transform::from_xyz(x, 0.4, 0.0);
                    scene.mesh(Cuboid::new(0.8, 0.8, 0.8), material.clone(), place);
                }
            };
            let mut headless = build(0.8, 2000.0, spawn)?;
            let without = settled(&mut headless);
            change_cameras(&mut headless, |camera| {
                camera.insert(LeanScreenSpaceAmbientOcclusion::default());
            });
            let with = settled(&mut headless);
            let middle = without.rgba[without.rgba.len() / 2 + 160 * 4..][..3].to_vec();
            println!("{middle:?} in the middle");
            Some((pixel_difference(&without, &with), middle))
        };
        let Some((black, air)) = shown(Color::BLACK) else {
            return;
        };
        assert!(air[2] > 40, "there is air: {air:?}");
        assert_eq!(black.largest, 0, "{black}");
        let (white, _) = shown(Color::linear_rgb(0.05, 0.05, 0.05)).expect("it is shown again");
        assert!(white.largest > 8, "there is occlusion: {white}");
    });
}
