//! Atmosphere: its transmittance on lights, and its sky behind and in front of lean meshes, beside Bevy forward's.
//!
//! The llvmpipe of Mesa 22 crashes in Bevy's own atmosphere passes, with or without this crate: there is nothing to compare with.

use bevy::{
    light::{Atmosphere, atmosphere::ScatteringMedium, light_consts::lux},
    pbr::AtmosphereSettings,
    prelude::*,
    render::{RenderApp, renderer::RenderAdapterInfo},
};
use kit::{
    headless::Headless,
    lean::{judge, report, set_lean, settled},
    own_process::in_own_process,
    scenes::{LEAST_PSNR, SceneBuilder},
};
use wgpu::DeviceType;

fn crashes(headless: &Headless) -> bool {
    let render_world = headless.app.sub_app(RenderApp).world();
    let adapter = render_world.resource::<RenderAdapterInfo>();
    adapter.device_type == DeviceType::Cpu && adapter.driver_info.starts_with("Mesa 22")
}

/// The solids under a sun that stands `elevation` radians over the horizon.
fn build(elevation: f32) -> Option<Headless> {
    let mut headless = Headless::new(UVec2::new(320, 240));
    if crashes(&headless) {
        println!("skipped: atmosphere: Mesa 22 crashes in Bevy's own passes");
        return None;
    }
    let mut scene = SceneBuilder {
        headless: &mut headless,
    };
    scene.solids();
    scene.spawn((
        DirectionalLight {
            illuminance: lux::RAW_SUNLIGHT,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_rotation(Quat::from_euler(EulerRot::YXZ, 0.6, -elevation, 0.0)),
    ));
    let medium = scene.add::<ScatteringMedium>(ScatteringMedium::default());
    scene.spawn(Atmosphere::earth(medium));
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
            let mut headless = build(elevation)?;
            let forward = settled(&mut headless);
            set_lean(&mut headless, true);
            let lean = settled(&mut headless);
            let name = format!("atmosphere_{elevation}");
            Some(judge(&name, &forward, &lean, LEAST_PSNR))
        }));
    });
}
