//! Units: light is bounded relative to displayed white, and a scene may use any unit of length.

use bevy::{
    prelude::*,
    render::{
        RenderApp,
        render_resource::TextureFormat,
        view::{ColorGrading, ColorGradingGlobal},
    },
};
use bevy_lean_deferred::{
    effects::{ViewHistory, diffuse_gi::ViewGi},
    prelude::*,
};
use kit::{
    analytic_light::{Errors, camera, see, surface},
    analytic_mirrors::{metal, mirror_app},
    hdr::read_light,
    headless::Headless,
    lean::{change_cameras, instant_exposure},
    own_process::in_own_process,
};

use super::scenes::{EYE, SMALL, gi, looking, reflections, show_next, spawn_floor};

/// Brightest light in the effects of the single camera: gathered by diffuse GI, and kept for reflections.
fn brightest(headless: &mut Headless) -> [f32; 2] {
    let world = headless.app.sub_app_mut(RenderApp).world_mut();
    let mut views = world.query::<(&ViewGi, &ViewHistory)>();
    let (gi, history) = views.single(world).expect("one camera has both");
    let found = gi
        .textures()
        .filter(|texture| texture.format() == TextureFormat::Rgba16Float)
        .last()
        .expect("it has found some");
    let textures = [found.clone(), history.texture().clone()];
    textures.map(|texture| {
        let light = read_light(headless, &texture);
        let texels = light.texels.iter().flat_map(|texel| &texel[..3]);
        texels.copied().fold(0.0, f32::max)
    })
}

/// Brightest light beside a lamp of radiance `light`, on a camera with `exposure`.
fn lamp(headless: &mut Headless, light: f32, exposure: impl Bundle) -> [f32; 2] {
    show_next(headless, 8, |s| {
        let floor = StandardMaterial {
            metallic: 0.5,
            ..metal(0.1)
        };
        spawn_floor(s, floor, 0.0);
        let card = Transform::from_xyz(0.0, 0.5, -0.8);
        s.mesh(Rectangle::new(2.0, 1.0), surface(0.0, light), card);
        let camera = camera(s, looking(EYE, 0.3), 0.0, (gi(), reflections()));
        s.world().entity_mut(camera).insert(exposure);
    });
    brightest(headless)
}

/// A constant exposure, in stops.
fn adapted_to(stops: f32) -> LeanAutoExposure {
    LeanAutoExposure {
        range: stops..=stops,
        ..instant_exposure()
    }
}

fn graded_to(exposure: f32) -> ColorGrading {
    ColorGrading {
        global: ColorGradingGlobal {
            exposure,
            ..default()
        },
        ..default()
    }
}

/// Lamps keep their light in a darkened picture, and light thousands of times above white is bounded in a brightened one.
#[test]
fn light_is_bounded_by_what_shows_as_white() {
    in_own_process(|| {
        let mut headless = Headless::new(SMALL);
        for (name, dark, bright) in [
            (
                "auto exposure",
                lamp(&mut headless, 20_000.0, adapted_to(-8.0)),
                lamp(&mut headless, 200.0, adapted_to(8.0)),
            ),
            (
                "colour grading",
                lamp(&mut headless, 20_000.0, graded_to(-8.0)),
                lamp(&mut headless, 200.0, graded_to(8.0)),
            ),
        ] {
            println!(
                "{name}: of a lamp of 20000 at -8 stops {dark:.0?}, of one of 200 at 8 stops {bright:.2?}"
            );
            // Half floats and words are rounded.
            assert!((dark[1] / 20_000.0 - 1.0).abs() < 0.01, "{name}");
            // The lamp covers most of the hemisphere beside it.
            assert!(dark[0] > 4000.0 && dark[0] < 20_100.0, "{name}");
            // Bounded to 256 and 1024 times white.
            assert!(bright[0] > 0.2 && bright[0] < 1.01, "{name}");
            assert!((bright[1] / 4.0 - 1.0).abs() < 0.01, "{name}");
        }
        let [of_gi, of_history] = lamp(&mut headless, 20_000.0, ());
        println!("as it is: {of_gi:.1}, {of_history:.1}");
        assert!(of_gi < 257.0 && (of_history / 1024.0 - 1.0).abs() < 0.01);
    });
}

/// A scene with thousands of units per metre reflects the same as one in metres.
#[test]
fn mirrors_know_no_largest_distance() {
    in_own_process(|| {
        let mut headless = mirror_app(SMALL, 0.0, |_| ());
        let mut before = 1.0_f32;
        let mut shown = |scale: f32| {
            let grows = scale / before;
            before = scale;
            let world = headless.world();
            let mut meshes = world.query_filtered::<&mut Transform, With<Mesh3d>>();
            for mut mesh in meshes.iter_mut(world) {
                mesh.translation *= grows;
                mesh.scale *= grows;
            }
            change_cameras(&mut headless, |camera| {
                let mut transform = camera.get_mut::<Transform>().expect("cameras have one");
                transform.translation *= grows;
                // Nothing is culled by distance.
                camera.insert(Projection::Perspective(PerspectiveProjection {
                    far: 1e9,
                    ..default()
                }));
                let effect = LeanScreenSpaceReflections {
                    thickness: 0.25 * scale,
                    ..reflections()
                };
                camera.insert((effect, CameraCut));
            });
            see(&mut headless, 8)
        };
        let metres = shown(1.0);
        for scale in [100.0, 40_000.0, 1e6] {
            let seen = shown(scale);
            seen.save(&format!("mirror_times_{scale}"), 1.0);
            let pairs = metres.light.texels.iter().zip(&seen.light.texels);
            let off = Errors::of(pairs.map(|(metres, seen)| seen[1] - metres[1]));
            println!("{scale} units a metre: {:.1} dB", off.psnr());
            assert!(off.psnr() > 40.0, "{scale}");
        }
    });
}
