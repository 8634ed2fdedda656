//! Cameras that draw over another camera's picture, with the settings that its effect gives to it, look as if both had been given them by
//! hand, whichever of them has the effect.

use bevy::{
    camera::{Camera3dDepthLoadOp, CameraOutputMode, Hdr, visibility::RenderLayers},
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    prelude::*,
};
use bevy_lean_deferred::prelude::*;
use kit::{
    headless::{Headless, Picture},
    lean::{active_lean_views, instant_exposure, judge, report, show},
    metrics::pixel_difference,
    own_process::in_own_process,
    scenes::{
        LEAST_PSNR, SceneBuilder,
        build::{ambient, default_camera_transform},
    },
};

const SIZE: UVec2 = UVec2::new(320, 240);

/// Moving content of a second camera, over the first one's picture.
#[derive(Component, Clone, Copy, PartialEq, Debug)]
enum Overlay {
    /// A half-transparent sprite and a disc.
    Flat,
    /// A ball, partly behind the first camera's meshes.
    Solid,
}

/// Marks what moves in front of the second camera.
#[derive(Component)]
struct Moving;

/// The world's camera and the one over it with Bevy's defaults: without HDR, with MSAA.
fn scene(headless: &mut Headless, overlay: Overlay) -> [Entity; 2] {
    let mut cameras = [Entity::PLACEHOLDER; 2];
    show(headless, |s| {
        s.solids();
        s.sun(true);
        let target = s.headless.render_target();
        cameras[0] = s.spawn((
            Camera3d::default(),
            target.clone(),
            // Without tonemapping, so that no picture is tonemapped twice.
            (Tonemapping::None, DebandDither::Disabled),
            default_camera_transform(),
            ambient(),
        ));
        let over = Camera {
            order: 1,
            clear_color: ClearColorConfig::None,
            ..default()
        };
        cameras[1] = s.spawn((over, target));
        match overlay {
            Overlay::Solid => solid(s, cameras[1]),
            Overlay::Flat => flat(s, cameras[1]),
        }
    });
    cameras
}

fn solid(s: &mut SceneBuilder, camera: Entity) {
    let layer = RenderLayers::layer(1);
    let lamp = s.sun(false);
    s.world().entity_mut(lamp).insert(layer.clone());
    let clay = StandardMaterial::from_color(Color::srgb(0.9, 0.3, 0.6));
    let ball = s.mesh(Sphere::new(0.7), clay, Transform::default());
    s.world().entity_mut(ball).insert((Moving, layer.clone()));
    s.world().entity_mut(camera).insert((
        Camera3d {
            depth_load_op: Camera3dDepthLoadOp::Load,
            ..default()
        },
        (Tonemapping::None, DebandDither::Disabled),
        default_camera_transform(),
        layer,
    ));
}

fn flat(s: &mut SceneBuilder, camera: Entity) {
    s.spawn((
        Sprite::from_color(Color::srgba(0.2, 0.9, 0.4, 0.5), Vec2::new(60.0, 30.0)),
        Moving,
    ));
    let disc = s.add::<Mesh>(Circle::new(18.0));
    let material = s.add::<ColorMaterial>(Color::srgb(0.9, 0.2, 0.2));
    s.spawn((
        Mesh2d(disc),
        MeshMaterial2d(material),
        Transform::from_xyz(40.0, 30.0, 1.0),
    ));
    s.world().entity_mut(camera).insert(Camera2d);
}

/// The last of several frames in which the overlay moves.
fn moved(headless: &mut Headless, overlay: Overlay) -> Picture {
    headless.settle();
    let film = headless.film(6, |world, frame| {
        let mut moving = world.query_filtered::<&mut Transform, With<Moving>>();
        let step = frame as f32;
        for mut transform in moving.iter_mut(world) {
            transform.translation = match overlay {
                Overlay::Solid => Vec3::new(0.5 * step - 2.0, 0.6, -0.4),
                Overlay::Flat => Vec3::new(24.0 * step - 60.0, -20.0, 0.0),
            };
        }
    });
    film.into_iter().next_back().expect("it has frames")
}

type Change = fn(&mut EntityWorldMut);

/// Judges the picture with `effect` on a camera, and its settings on the other, against that of cameras with these settings made by hand.
fn compare(
    headless: &mut Headless,
    name: &str,
    overlay: Overlay,
    on: usize,
    effect: Change,
    by_hand: (Change, bool),
) -> Result<(), String> {
    let (settings, with_effect) = by_hand;
    let cameras = scene(headless, overlay);
    let before = moved(headless, overlay);
    effect(&mut headless.world().entity_mut(cameras[on]));
    settings(&mut headless.world().entity_mut(cameras[1 - on]));
    let with = moved(headless, overlay);
    let lean = active_lean_views(headless);

    let cameras = scene(headless, overlay);
    for camera in cameras {
        settings(&mut headless.world().entity_mut(camera));
    }
    if with_effect {
        effect(&mut headless.world().entity_mut(cameras[on]));
    }
    let expected = moved(headless, overlay);
    if !with_effect {
        assert_eq!(lean, 1, "{name}");
    }
    let name = format!("overlay_{name}_{overlay:?}_on_{on}");
    // Bevy's picture with default settings differs in edges and by blending in linear light.
    println!(
        "{name}: Bevy alone {}",
        pixel_difference(&before, &expected)
    );
    judge(&name, &expected, &with, LEAST_PSNR)
}

fn hdr_without_msaa(camera: &mut EntityWorldMut) {
    camera.insert((Hdr, Msaa::Off));
}

fn make_lean(camera: &mut EntityWorldMut) {
    camera.insert(LeanDeferred::default());
}

#[test]
fn over_a_lean_camera() {
    in_own_process(|| {
        let headless = &mut Headless::new(SIZE);
        let by_hand: (Change, bool) = (hdr_without_msaa, false);
        report(
            [Overlay::Flat, Overlay::Solid]
                .map(|overlay| compare(headless, "lean", overlay, 0, make_lean, by_hand)),
        );
    });
}

#[test]
fn a_lean_camera_over_another() {
    in_own_process(|| {
        let headless = &mut Headless::new(SIZE);
        let by_hand: (Change, bool) = (hdr_without_msaa, false);
        report([compare(
            headless,
            "lean",
            Overlay::Solid,
            1,
            make_lean,
            by_hand,
        )]);
    });
}

/// The first camera does not write to the target itself.
#[test]
fn over_a_lean_camera_that_skips_its_output() {
    in_own_process(|| {
        let skip = |camera: &mut EntityWorldMut| {
            let mut camera = camera.get_mut::<Camera>().expect("it is one");
            if camera.order == 0 {
                camera.output_mode = CameraOutputMode::Skip;
            }
        };
        let headless = &mut Headless::new(SIZE);
        report([Overlay::Flat, Overlay::Solid].map(|overlay| {
            let mut picture = |change: &dyn Fn(&mut EntityWorldMut, usize)| {
                let cameras = scene(headless, overlay);
                for (index, camera) in cameras.into_iter().enumerate() {
                    let mut camera = headless.world().entity_mut(camera);
                    skip(&mut camera);
                    change(&mut camera, index);
                }
                moved(headless, overlay)
            };
            let with = picture(&|camera, index| {
                if index == 0 {
                    make_lean(camera);
                } else {
                    hdr_without_msaa(camera);
                }
            });
            let expected = picture(&|camera, _| hdr_without_msaa(camera));
            judge(
                &format!("overlay_skip_{overlay:?}"),
                &expected,
                &with,
                LEAST_PSNR,
            )
        }));
    });
}

#[test]
fn over_cameras_with_other_effects() {
    in_own_process(|| {
        let occlusion: Change = |camera| {
            camera.insert(LeanScreenSpaceAmbientOcclusion {
                intensity: 2.0,
                ..default()
            });
        };
        let exposure: Change = |camera| {
            camera.insert(instant_exposure());
        };
        let without_msaa: Change = |camera| {
            camera.insert(Msaa::Off);
        };
        let hdr: Change = |camera| {
            camera.insert(Hdr);
        };
        let headless = &mut Headless::new(SIZE);
        let mut results = Vec::new();
        for overlay in [Overlay::Flat, Overlay::Solid] {
            for (name, effect, settings) in [
                ("occlusion", occlusion, without_msaa),
                ("exposure", exposure, hdr),
            ] {
                let by_hand = (settings, true);
                results.push(compare(headless, name, overlay, 0, effect, by_hand));
            }
        }
        report(results);
    });
}
